#include "benchmarks/tools/detections/true_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "sim/config/toml_peek.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/categories.h"
#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/export/labels.h"
#include "sim/dataset/links.h"
#include "sim/dataset/photograph_labels.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

TrueObject object_of(const LabelledObject& labelled, const std::vector<Category>& categories) {
  TrueObject object;
  object.instance = labelled.instance->id;
  object.name = labelled.instance->name;
  object.category = categories[static_cast<std::size_t>(labelled.category) - 1].name;
  object.mask = {labelled.box_x, labelled.box_y, labelled.mask};
  object.box = {static_cast<double>(labelled.box_x), static_cast<double>(labelled.box_y),
                static_cast<double>(labelled.mask.width()),
                static_cast<double>(labelled.mask.height())};
  object.area_px = labelled.area_px;
  object.visible_fraction = labelled.visible_fraction;
  for (const TrueTrait& trait : labelled.instance->traits) object.traits[trait.name] = trait.value;
  for (const TrueLabel& label : labelled.instance->labels) object.labels[label.name] = label.value;
  return object;
}

/// The names that a file may call a picture: scene, frame and sensor, COCO's number, and without
/// the scene where there is one alone.
void add_names(const ExportScene& scene, const ExportPicture& picture, bool is_only_scene,
               const PictureSize& size, PictureNames& names) {
  const std::string name = picture_name(scene, picture);
  names.emplace(name, size);
  names.emplace(std::to_string(picture_id(scene, picture)), size);
  if (is_only_scene) names.emplace(name.substr(name.find('_') + 1), size);
}

/// Scenes that show the same plants are one.
std::string plant_of(const ExportScene& scene) {
  const std::vector<std::string>& shared = scene.truth->shared_plants;
  return shared.empty() ? "scene " + std::to_string(scene.number) : shared.front();
}

// ---- Somebody's labels --------------------------------------------------------------------------

TrueObject object_of(const DetectedBox& box, const std::vector<std::string>& categories) {
  TrueObject object;
  object.instance = box.id;
  object.name = "label " + std::to_string(box.id);
  object.category = categories.at(static_cast<std::size_t>(box.category) - 1);
  object.box = {box.low_px.x() + 0.5, box.low_px.y() + 0.5, box.high_px.x() - box.low_px.x(),
                box.high_px.y() - box.low_px.y()};
  object.area_px = std::llround(object.box.width * object.box.height);
  if (!box.mask.empty()) {
    object.mask = {box.mask_at_px.x(), box.mask_at_px.y(), box.mask};
    object.area_px = std::count_if(box.mask.begin(), box.mask.end(),
                                   [](std::uint8_t inside) { return inside != 0; });
  }
  object.visible_fraction = std::numeric_limits<double>::quiet_NaN();
  return object;
}

/// Pictures that were made of one photograph are of one plant.
std::string source_of(const std::string& file) { return file.substr(0, file.find(".rf.")); }

void add_name(const std::string& name, const PictureSize& picture, PictureNames& names) {
  const auto [known, is_new] = names.emplace(name, picture);
  if (!is_new && known->second.place != picture.place) known->second.is_ambiguous = true;
}

/// COCO's number, the file's name, and what Ultralytics makes of a name that is a number.
void add_source_names(const LabelledPicture& picture, const PictureSize& size,
                      PictureNames& names) {
  const std::string stem = fs::path(picture.file).stem().string();
  add_name(stem, size, names);
  if (!picture.id.empty()) {
    add_name("#" + picture.id, size, names);
  } else if (!stem.empty() && stem.find_first_not_of("0123456789") == std::string::npos) {
    const std::size_t first = stem.find_first_not_of('0');
    add_name("#" + (first == std::string::npos ? "0" : stem.substr(first)), size, names);
  }
}

DetectionImages images_of(const ExportScene& scene) {
  DetectionImages images;
  for (const ExportPicture* picture : first_pictures(scene)) {
    const Camera camera = camera_of(scene, *picture, false).camera;
    images.size_px[{picture->frame, 0}] = {camera.width_px, camera.height_px};
  }
  images.scene = scene.number;
  return images;
}

void add_labelled_scene(const fs::path& folder, TruePictures& all) {
  const ExportScene scene = read_export_scene(folder);
  const DetectionImages images = images_of(scene);
  const PhotographLabels labels = read_labels(folder, images);
  std::map<int, const LabelledPicture*> source;
  for (const LabelledPicture& picture : labels.pictures) source[picture.frame] = &picture;
  std::map<int, std::size_t> place;
  for (const ExportPicture* picture : first_pictures(scene)) {
    const auto own = source.find(picture->frame);
    if (own == source.end())
      throw std::runtime_error(folder.string() + "/labels/pictures.json: frame " +
                               std::to_string(picture->frame) + " is not named");
    const Eigen::Vector2i size = images.size_px.at({picture->frame, 0});
    place[picture->frame] = all.pictures.size();
    TruePicture one;
    one.file = picture->file;
    one.name = own->second->file;
    one.plant = source_of(own->second->file);
    one.width_px = size.x();
    one.height_px = size.y();
    const PictureSize named{all.pictures.size(), size.x(), size.y()};
    add_source_names(*own->second, named, all.names);
    all.pictures.push_back(std::move(one));
  }
  for (std::size_t k = 0; k < std::min(labels.category_ids.size(), all.categories.size()); ++k)
    all.class_numbers[labels.category_ids[k]] = all.categories[k];
  for (const DetectedBox& box : labels.boxes) {
    if (box.category < 1 || box.category > static_cast<int>(all.categories.size()))
      throw std::runtime_error(folder.string() + "/labels/boxes.json: category_id " +
                               std::to_string(box.category) + " is none of the " +
                               std::to_string(all.categories.size()) + " of categories.json");
    all.pictures[place.at(box.frame)].objects.push_back(object_of(box, all.categories));
    all.has_masks = all.has_masks && !box.mask.empty();
  }
}

TruePictures read_labelled_pictures(const fs::path& dataset, const std::vector<fs::path>& folders,
                                    const std::string& label) {
  if (!label.empty())
    throw std::invalid_argument(dataset.string() +
                                ": --category: labels of photographs have their "
                                "own categories and no others");
  TruePictures all;
  all.categories = read_categories(dataset);
  for (const fs::path& folder : folders) {
    refuse_links_out(dataset, folder.filename());
    add_labelled_scene(folder, all);
  }
  return all;
}

}  // namespace

TruePictures read_true_pictures(const fs::path& dataset, const std::string& label,
                                const std::function<void(int, int)>& progress) {
  const std::vector<fs::path> folders = scene_folders(dataset);
  if (folders.empty())
    throw std::runtime_error(dataset.string() + ": holds no scene (000000/rig.json)");
  if (has_labels(folders.front())) return read_labelled_pictures(dataset, folders, label);
  std::vector<ExportScene> scenes;
  for (const fs::path& folder : folders) {
    refuse_links_out(dataset, folder.filename());
    scenes.push_back(read_export_scene(folder));
    if (!scenes.back().truth)
      throw std::runtime_error(folder.string() + ": there is no truth/ to score against");
    require_labels(scenes.back(), false);
  }
  const std::vector<Category> categories = categories_of(scenes, label);
  ExportOptions options;
  options.category = label;
  TruePictures all;
  for (const Category& category : categories) all.categories.push_back(category.name);
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    const ExportScene& scene = scenes[s];
    if (progress) progress(static_cast<int>(s), static_cast<int>(scenes.size()));
    const fs::path config = scene.folder / "truth/config.toml";
    std::string light = fs::exists(config) ? toml_text_of(config, "scene", "light") : "";
    if (light == "drawn") light.clear();  // another one each scene, which truth does not name
    for (const ExportPicture* picture : labelled_pictures(scene)) {
      TruePicture one;
      one.file = picture->file;
      one.name = picture_name(scene, *picture);
      one.sensor = picture->sensor;
      one.light = light;
      one.plant = plant_of(scene);
      const Camera camera = camera_of(scene, *picture, false).camera;
      one.width_px = camera.width_px;
      one.height_px = camera.height_px;
      for (const LabelledObject& object : labels_of(scene, *picture, categories, options))
        one.objects.push_back(object_of(object, categories));
      add_names(scene, *picture, scenes.size() == 1,
                {all.pictures.size(), one.width_px, one.height_px}, all.names);
      all.pictures.push_back(std::move(one));
    }
  }
  return all;
}

std::size_t leave_out_sensors(TruePictures& truth, FoundFile& found) {
  std::set<std::size_t> sensors = {0};
  for (const auto& [place, objects] : found.of_picture)
    sensors.insert(truth.pictures.at(place).sensor);
  const std::size_t all = truth.pictures.size();
  std::vector<TruePicture> kept;
  std::map<std::size_t, std::vector<FoundObject>> of_kept;
  for (std::size_t i = 0; i < all; ++i) {
    if (!sensors.contains(truth.pictures[i].sensor)) continue;
    const auto own = found.of_picture.find(i);
    if (own != found.of_picture.end()) of_kept[kept.size()] = std::move(own->second);
    kept.push_back(std::move(truth.pictures[i]));
  }
  truth.pictures = std::move(kept);
  truth.names.clear();  // their places are of before
  found.of_picture = std::move(of_kept);
  return all - truth.pictures.size();
}

}  // namespace cousin
