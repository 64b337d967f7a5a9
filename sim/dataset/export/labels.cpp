#include "sim/dataset/export/labels.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/categories.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/truth_sensors.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/undistort.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

const std::vector<Keypoint>& keypoints_of(const Scene& scene, const Instance& instance) {
  return scene.models[static_cast<std::size_t>(instance.model)].keypoints;
}

std::string category_name(const Instance& instance, const std::string& label) {
  return label.empty() ? instance.category : label_of(instance, label);
}

[[noreturn]] void refuse_label(const ExportScene& scene, const Instance& instance,
                               const std::string& label) {
  std::string has;
  for (const TrueLabel& own : instance.labels) has += (has.empty() ? "" : ", ") + own.name;
  throw std::runtime_error((scene.folder / "truth/scene.json").string() + ": \"" + instance.name +
                           "\" has no label \"" + label +
                           "\" to be a category; its labels: " + (has.empty() ? "none" : has));
}

/// Boxes and sizes of the values of an image of ids + 1.
struct Extent {
  int low_x = 65536, low_y = 65536, high_x = -1, high_y = -1;
  std::int64_t pixels = 0;
};
std::map<int, Extent> extents(const Image<std::uint16_t>& codes) {
  std::map<int, Extent> result;
  for (int y = 0; y < codes.height(); ++y) {
    for (int x = 0; x < codes.width(); ++x) {
      if (codes(x, y) == 0) continue;
      Extent& e = result[codes(x, y) - 1];
      e.low_x = std::min(e.low_x, x);
      e.low_y = std::min(e.low_y, y);
      e.high_x = std::max(e.high_x, x);
      e.high_y = std::max(e.high_y, y);
      ++e.pixels;
    }
  }
  return result;
}

void set_mask(const Image<std::uint16_t>& codes, const Extent& extent, LabelledObject& object) {
  object.box_x = extent.low_x;
  object.box_y = extent.low_y;
  object.area_px = extent.pixels;
  object.mask =
      Image<std::uint8_t>(extent.high_x - extent.low_x + 1, extent.high_y - extent.low_y + 1);
  for (int y = 0; y < object.mask.height(); ++y) {
    for (int x = 0; x < object.mask.width(); ++x) {
      const bool inside = codes(x + extent.low_x, y + extent.low_y) == object.instance->id + 1;
      object.mask(x, y) = inside ? 255 : 0;
    }
  }
}

/// Where an undistorted picture shows a keypoint.
void undistort_keypoint(const Lens& lens, const Camera& pinhole, KeypointView& keypoint) {
  const auto ray = keypoint.pixel_px.allFinite() ? lens.unproject(keypoint.pixel_px) : std::nullopt;
  const auto pixel = ray ? project(pinhole, *ray) : std::nullopt;
  if (!pixel) {
    keypoint.state = PointState::outside;
    keypoint.pixel_px.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  keypoint.pixel_px = *pixel;
  const bool inside = pixel->x() >= -0.5 && pixel->x() < pinhole.width_px - 0.5 &&
                      pixel->y() >= -0.5 && pixel->y() < pinhole.height_px - 0.5;
  if (!inside) keypoint.state = PointState::outside;
}

/// Where the truth of another sensor is; null for the first.
const SensorViews* other_sensor(const ExportScene& scene, const ExportPicture& picture) {
  if (picture.sensor == 0) return nullptr;
  for (const SensorViews& other : scene.truth->other_sensors) {
    if (other.sensor == scene.capture.rig[picture.sensor].name) return &other;
  }
  throw std::runtime_error((scene.folder / "truth/camera.json").string() + ": has no sensor \"" +
                           scene.capture.rig[picture.sensor].name + "\"");
}

/// Visibility and keypoints of a picture.
const TruthImages& known_of(const ExportScene& scene, const ExportPicture& picture) {
  const SensorViews* other = other_sensor(scene, picture);
  const std::vector<TrueView>& views = other ? other->views : scene.truth->views;
  const int frame = scene.capture.frames[picture.frame].id;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].frame == frame) return (other ? other->images : scene.truth->labels).at(i);
  }
  throw std::runtime_error((scene.folder / "truth/camera.json").string() + ": has no frame " +
                           std::to_string(frame));
}

Image<std::uint16_t> instance_codes(const ExportScene& scene, const ExportPicture& picture,
                                    const Camera& lens, const ExportOptions& options) {
  const SensorViews* other = other_sensor(scene, picture);
  const fs::path relative = "truth" / sensor_folder(other ? other->sensor : "") / "instance" /
                            (six_digits(scene.capture.frames[picture.frame].id) + ".png");
  const fs::path file = resolve_inside(scene.folder, relative);
  Image<std::uint16_t> codes = read_png16(file);
  if (codes.width() != lens.width_px || codes.height() != lens.height_px) {
    throw std::runtime_error(file.string() + ": the image is " + std::to_string(codes.width()) +
                             " x " + std::to_string(codes.height()) + " pixels; its camera has " +
                             std::to_string(lens.width_px) + " x " +
                             std::to_string(lens.height_px));
  }
  return options.undistort ? undistort(codes, lens).image : codes;
}

}  // namespace

std::vector<Category> categories_of(const std::vector<ExportScene>& scenes,
                                    const std::string& label) {
  std::map<std::string, std::vector<std::string>> longest;
  std::map<std::string, std::set<std::string>> all;
  for (const ExportScene& scene : scenes) {
    if (!scene.truth) continue;
    if (label.empty()) {
      for (const std::string& known : read_categories(scene.folder.parent_path())) longest[known];
    }
    for (const Instance* instance : specimens_of(scene.truth->scene)) {
      std::vector<std::string> names;
      for (const Keypoint& k : keypoints_of(scene.truth->scene, *instance)) names.push_back(k.name);
      const std::string category = category_name(*instance, label);
      if (!label.empty() && category.empty()) refuse_label(scene, *instance, label);
      all[category].insert(names.begin(), names.end());
      std::vector<std::string>& best = longest[category];
      if (names.size() > best.size()) best = names;
    }
  }
  std::vector<Category> categories;
  for (auto& [name, keypoints] : longest) {
    Category category{static_cast<int>(categories.size()) + 1, name, std::move(keypoints)};
    for (const std::string& keypoint : all[name]) {
      const auto& list = category.keypoints;
      if (std::find(list.begin(), list.end(), keypoint) == list.end())
        category.keypoints.push_back(keypoint);
    }
    categories.push_back(std::move(category));
  }
  return categories;
}

void require_labels(const ExportScene& scene, bool keypoints) {
  const ExportTruth& truth = truth_of(scene, "labels");
  const bool has_keypoints =
      std::any_of(truth.labels.begin(), truth.labels.end(),
                  [](const TruthImages& images) { return !images.keypoints.empty(); });
  const bool has_instances = fs::is_directory(scene.folder / "truth/instance");
  if (has_instances && !truth.labels.empty() && (has_keypoints || !keypoints)) return;
  throw std::runtime_error(
      scene.folder.string() + ": truth/ holds no " +
      (has_instances ? keypoints && !has_keypoints ? "keypoints of the frames" : "visible fractions"
                     : "instance images") +
      "; render with --truth visibility,instance" + (keypoints ? ",keypoints" : ""));
}

std::vector<LabelledObject> labels_of(const ExportScene& scene, const ExportPicture& picture,
                                      const std::vector<Category>& categories,
                                      const ExportOptions& options) {
  const ExportTruth& truth = truth_of(scene, "labels");
  const TruthImages& known = known_of(scene, picture);
  const Camera lens = camera_of(scene, picture, options.true_cameras).camera;
  const Lens from(lens);
  const Camera pinhole = handed_over(lens, options);
  const Image<std::uint16_t> codes = instance_codes(scene, picture, lens, options);
  const std::map<int, Extent> seen = extents(codes);

  std::vector<LabelledObject> objects;
  for (const Instance* instance : specimens_of(truth.scene)) {
    const auto found = seen.find(instance->id);
    if (found == seen.end()) continue;
    LabelledObject object;
    object.instance = instance;
    for (const InstanceVisibility& v : known.visibility) {
      if (v.instance == instance->id) object.visible_fraction = v.visible_fraction;
    }
    if (object.visible_fraction < options.least_visible) continue;
    const auto category = std::find_if(
        categories.begin(), categories.end(),
        [&](const Category& c) { return c.name == category_name(*instance, options.category); });
    object.category = category->id;
    object.keypoints.resize(category->keypoints.size());
    for (KeypointView keypoint : known.keypoints) {
      if (keypoint.instance != instance->id) continue;
      const std::string& name =
          keypoints_of(truth.scene, *instance)[static_cast<std::size_t>(keypoint.keypoint)].name;
      const auto place = std::find(category->keypoints.begin(), category->keypoints.end(), name);
      if (options.undistort) undistort_keypoint(from, pinhole, keypoint);
      object.keypoints[static_cast<std::size_t>(place - category->keypoints.begin())] = keypoint;
    }
    set_mask(codes, found->second, object);
    objects.push_back(std::move(object));
  }
  return objects;
}

}  // namespace cousin
