// COCO [cocodataset.org, "Data format"]
//   OUT/images/train/000000_000003.png     scene and frame; _right.png of the rig's sensor "right",
//                                          whose images have a key "sensor" more
//   OUT/annotations/train.json             and val.json, test.json
// Boxes and polygons count from the image's corner, keypoints are pixels, whose centres are
// integers; visibility 0 not labelled, 1 hidden, 2 seen. Annotations have four keys more:
// "visible_fraction" (of the amodal mask), "instance_id" (of scene.json), "instance_name", and
// "attributes": the specimen's traits by name, in SI units, and its labels, as text. Where a label
// has a trait's name, as "maturity", the label stands there; the trait numbers the classes.

#include <cmath>

#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/export/export_pictures.h"
#include "sim/dataset/export/for_each_picture.h"
#include "sim/dataset/export/labels.h"
#include "sim/dataset/export/splits.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/mask_codes.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

Json segmentation(const LabelledObject& object, const Camera& camera, MaskCode code) {
  if (code == MaskCode::rle) {
    return {{"size", {camera.height_px, camera.width_px}},
            {"counts", coco_run_lengths(object.mask, object.box_x, object.box_y, camera.width_px,
                                        camera.height_px)}};
  }
  Json polygons = Json::array();
  for (const PixelOutline& outline : outlines_of(object.mask, object.box_x, object.box_y)) {
    Json polygon = Json::array();
    for (const Eigen::Vector2i& corner : outline) {
      polygon.push_back(corner.x());
      polygon.push_back(corner.y());
    }
    polygons.push_back(polygon);
  }
  return polygons;
}

void add_keypoints(const LabelledObject& object, Json& annotation) {
  if (object.keypoints.empty()) return;
  Json list = Json::array();
  int labelled = 0;
  for (const KeypointView& keypoint : object.keypoints) {
    const bool seen = keypoint.state == PointState::visible;
    if (!seen && keypoint.state != PointState::occluded) {
      for (int i = 0; i < 3; ++i) list.push_back(0);
      continue;
    }
    ++labelled;
    list.push_back(keypoint.pixel_px.x());
    list.push_back(keypoint.pixel_px.y());
    list.push_back(seen ? 2 : 1);
  }
  annotation["num_keypoints"] = labelled;
  annotation["keypoints"] = list;
}

Json attributes_of(const Instance& instance) {
  Json attributes = Json::object();
  for (const TrueTrait& trait : instance.traits) attributes[trait.name] = trait.value;
  for (const TrueLabel& label : instance.labels) attributes[label.name] = label.value;
  return attributes;
}

Json annotation_of(const LabelledObject& object, std::int64_t image, const Camera& camera,
                   MaskCode code) {
  Json annotation = {
      {"id", 0},  // set when all are known
      {"image_id", image},
      {"category_id", object.category},
      {"iscrowd", 0},
      {"area", object.area_px},
      {"bbox", {object.box_x, object.box_y, object.mask.width(), object.mask.height()}},
      {"segmentation", segmentation(object, camera, code)},
      {"visible_fraction", object.visible_fraction},
      {"instance_id", object.instance->id},
      {"instance_name", object.instance->name},
      {"attributes", attributes_of(*object.instance)}};
  add_keypoints(object, annotation);
  return annotation;
}

Json json_of(const std::vector<Category>& categories) {
  Json list = Json::array();
  for (const Category& category : categories) {
    Json json = {{"id", category.id}, {"name", category.name}, {"supercategory", "plant"}};
    if (!category.keypoints.empty()) {
      json["keypoints"] = category.keypoints;
      json["skeleton"] = Json::array();
    }
    list.push_back(json);
  }
  return list;
}

/// What is said of one picture.
struct CocoPicture {
  Json image;
  std::vector<Json> annotations;
};

}  // namespace

void export_coco(ExportJob& job) {
  const std::vector<Category> categories = categories_of(job.scenes, job.options.category);
  for (const ExportScene& scene : job.scenes) require_labels(scene, false);
  const std::vector<Split> splits = splits_of(job.scenes, job.options.split, Split::val);
  if (const std::string empty = empty_splits(splits, job.options.split); !empty.empty())
    job.warnings.push_back(empty);
  std::array<Json, 3> images = {Json::array(), Json::array(), Json::array()};
  std::array<Json, 3> annotations = images;
  int done = 0;
  for (std::size_t s = 0; s < job.scenes.size(); ++s) {
    const ExportScene& scene = job.scenes[s];
    const auto side = static_cast<std::size_t>(splits[s]);
    const fs::path folder = job.out / "images" / to_string(splits[s]);
    const std::vector<const ExportPicture*> pictures = labelled_pictures(scene);
    std::vector<CocoPicture> made(pictures.size());
    for_each_picture(job, scene, pictures, done, [&](std::size_t i, const ExportPicture& picture) {
      const Camera lens = camera_of(scene, picture, job.options.true_cameras).camera;
      const Camera camera = handed_over(lens, job.options);
      const std::int64_t id = picture_id(scene, picture);
      const fs::path file =
          write_picture(picture, lens, camera, folder / picture_name(scene, picture), job.options);
      made[i].image = {{"id", id},
                       {"file_name", file.filename().string()},
                       {"width", camera.width_px},
                       {"height", camera.height_px}};
      if (picture.sensor > 0) made[i].image["sensor"] = scene.capture.rig[picture.sensor].name;
      for (const LabelledObject& object : labels_of(scene, picture, categories, job.options))
        made[i].annotations.push_back(annotation_of(object, id, camera, job.options.masks));
    });
    for (CocoPicture& picture : made) {
      if (picture.image.is_null()) continue;
      images[side].push_back(std::move(picture.image));
      for (Json& annotation : picture.annotations) {
        annotation["id"] = annotations[side].size() + 1;
        annotations[side].push_back(std::move(annotation));
      }
    }
  }
  for (const Split split : kSplits) {
    const auto side = static_cast<std::size_t>(split);
    if (images[side].empty()) continue;
    write_once(job.out / "annotations" / (std::string(to_string(split)) + ".json"),
               to_text(Json{{"info", {{"description", "exported by cousin"}}},  // pycocotools asks
                            {"licenses", Json::array()},
                            {"images", images[side]},
                            {"annotations", annotations[side]},
                            {"categories", json_of(categories)}}));
  }
}

}  // namespace cousin
