// Ultralytics' YOLO [docs.ultralytics.com/datasets]
//   OUT/data.yaml                          always names train and val: readers insist on both
//   OUT/images/train/000000_000003.png     scene and frame
//   OUT/labels/train/000000_000003.txt     a line an object, shares of width and height from the
//                                          image's corner:
//     detect   class x y w h               the box of what is seen
//     segment  class x1 y1 x2 y2 ...       one polygon; parts and holes joined by cuts of no width
//     pose     class x y w h px py v ...   v: 0 not labelled, 1 hidden, 2 seen

#include <algorithm>
#include <stdexcept>

#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/export/export_pictures.h"
#include "sim/dataset/export/for_each_picture.h"
#include "sim/dataset/export/labels.h"
#include "sim/dataset/export/splits.h"
#include "sim/dataset/mask_codes.h"
#include "sim/dataset/text_fields.h"
#include "sim/dataset/yaml_text.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// Keypoints of all categories: YOLO has one list for all classes.
std::vector<std::string> all_keypoints(const std::vector<Category>& categories) {
  std::vector<std::string> names;
  for (const Category& category : categories) {
    for (const std::string& name : category.keypoints) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

/// What labels need of the dataset.
struct YoloNames {
  std::vector<Category> categories;
  std::vector<std::string> keypoints;
};

std::string box_text(const LabelledObject& object, const Camera& camera) {
  const double w = object.mask.width(), h = object.mask.height();
  return exact_text({(object.box_x + 0.5 * w) / camera.width_px,
                     (object.box_y + 0.5 * h) / camera.height_px, w / camera.width_px,
                     h / camera.height_px});
}

std::string outline_text(const LabelledObject& object, const Camera& camera) {
  std::vector<double> shares;
  for (const Eigen::Vector2i& corner :
       joined(outlines_of(object.mask, object.box_x, object.box_y))) {
    shares.push_back(static_cast<double>(corner.x()) / camera.width_px);
    shares.push_back(static_cast<double>(corner.y()) / camera.height_px);
  }
  return exact_text(shares);
}

std::string keypoints_text(const LabelledObject& object, const Camera& camera,
                           const YoloNames& names) {
  const Category& category = names.categories[static_cast<std::size_t>(object.category) - 1];
  std::string text;
  for (const std::string& name : names.keypoints) {
    const auto place = std::find(category.keypoints.begin(), category.keypoints.end(), name);
    KeypointView keypoint;
    if (place != category.keypoints.end())
      keypoint = object.keypoints[static_cast<std::size_t>(place - category.keypoints.begin())];
    const bool seen = keypoint.state == PointState::visible;
    if (!seen && keypoint.state != PointState::occluded) {
      text += " 0 0 0";
      continue;
    }
    // From a pixel's centre to the image's corner.
    text += " " +
            exact_text({(keypoint.pixel_px.x() + 0.5) / camera.width_px,
                        (keypoint.pixel_px.y() + 0.5) / camera.height_px}) +
            (seen ? " 2" : " 1");
  }
  return text;
}

std::string label_text(const std::vector<LabelledObject>& objects, const Camera& camera,
                       YoloTask task, const YoloNames& names) {
  std::string text;
  for (const LabelledObject& object : objects) {
    text += std::to_string(object.category - 1) + " ";
    text += task == YoloTask::segment ? outline_text(object, camera) : box_text(object, camera);
    if (task == YoloTask::pose) text += keypoints_text(object, camera, names);
    text += "\n";
  }
  return text;
}

/// Where a split's pictures are: its own folder, or for validation, which readers insist on, the
/// best there is beside it.
std::string folder_of(Split split, const std::vector<Split>& splits) {
  const auto is_there = [&](Split s) {
    return std::find(splits.begin(), splits.end(), s) != splits.end();
  };
  if (is_there(split)) return "images/" + std::string(to_string(split));
  if (split == Split::test) return "";
  return folder_of(split == Split::train || !is_there(Split::test) ? splits.front() : Split::test,
                   splits);
}

std::string data_yaml(const std::vector<Split>& splits, YoloTask task, const YoloNames& names) {
  std::string text = "# paths are from this file's folder\n";
  for (const Split split : kSplits) {
    const std::string name(to_string(split)), folder = folder_of(split, splits);
    if (folder.empty()) continue;
    text += name + ": " + folder;
    text += folder.ends_with(name) ? "\n" : "  # there are no pictures for " + name + " alone\n";
  }
  text += "names:\n";
  for (const Category& category : names.categories)
    text += "  " + std::to_string(category.id - 1) + ": " + yaml_quoted(category.name) + "\n";
  if (task != YoloTask::pose) return text;
  std::string same, quoted;
  for (std::size_t i = 0; i < names.keypoints.size(); ++i) {
    same += (i > 0 ? ", " : "") + std::to_string(i);
    quoted += (i > 0 ? "," : "") + yaml_quoted(names.keypoints[i]);
  }
  text += "kpt_shape: [" + std::to_string(names.keypoints.size()) + ", 3]\n";
  text += "flip_idx: [" + same + "]  # a mirrored plant keeps its keypoints' names\n";
  return text + "kpt_names: [" + quoted + "]\n";
}

}  // namespace

void export_yolo(ExportJob& job) {
  const YoloTask task = job.options.task;
  YoloNames names;
  names.categories = categories_of(job.scenes, job.options.category);
  names.keypoints = all_keypoints(names.categories);
  if (task == YoloTask::pose && names.keypoints.empty()) {
    throw std::invalid_argument(
        "--task pose: the dataset's specimens have no keypoints; detect and segment need none");
  }
  for (const ExportScene& scene : job.scenes) require_labels(scene, task == YoloTask::pose);
  const std::vector<Split> splits = splits_of(job.scenes, job.options.split, Split::val);
  if (const std::string empty = empty_splits(splits, job.options.split); !empty.empty())
    job.warnings.push_back(empty);
  if (const std::string val = folder_of(Split::val, splits); !val.ends_with("val")) {
    job.warnings.push_back("data.yaml names " + val +
                           " for val, which readers insist on: what is measured on it says nothing "
                           "of other plants");
  }
  int done = 0;
  for (std::size_t s = 0; s < job.scenes.size(); ++s) {
    const ExportScene& scene = job.scenes[s];
    const std::string side(to_string(splits[s]));
    for_each_picture(
        job, scene, labelled_pictures(scene), done, [&](std::size_t, const ExportPicture& picture) {
          const std::string name = picture_name(scene, picture);
          const Camera lens = camera_of(scene, picture, job.options.true_cameras).camera;
          const Camera camera = handed_over(lens, job.options);
          write_picture(picture, lens, camera, job.out / "images" / side / name, job.options);
          write_once(job.out / "labels" / side / (name + ".txt"),
                     label_text(labels_of(scene, picture, names.categories, job.options), camera,
                                task, names));
        });
  }
  write_once(job.out / "data.yaml", data_yaml(splits, task, names));
}

}  // namespace cousin
