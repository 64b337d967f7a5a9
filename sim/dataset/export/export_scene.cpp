#include "sim/dataset/export/export_scene.h"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_json.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/truth_json.h"
#include "sim/dataset/truth_sensors.h"
#include "sim/imaging/undistort.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kJsonLimitBytes = std::size_t{1} << 29;

ExportTruth read_export_truth(const fs::path& scene_dir) {
  const fs::path dir = scene_dir / "truth";
  const auto text = [&](const char* name) {
    return read_file(resolve_inside(dir, name), kJsonLimitBytes);
  };
  const auto name = [&](const char* file) { return (dir / file).string(); };
  ExportTruth truth;
  if (fs::exists(dir / "shared_plants.json")) {
    truth.shared_plants =
        shared_plants_from_json(text("shared_plants.json"), name("shared_plants.json"));
  }
  truth.views = views_from_json(text("camera.json"), name("camera.json"), truth.other_sensors);
  SceneFiles files;
  truth.scene = scene_from_json(text("scene.json"), name("scene.json"), files);
  truth.mesh_files = std::move(files.meshes);
  for (ObjectModel& model : truth.scene.models) model.triangle_part = {};  // most of what is read
  for (const Instance& instance : truth.scene.instances) {
    if (static_cast<std::size_t>(instance.model) >= truth.scene.models.size()) {
      throw std::runtime_error(name("scene.json") + ": instance " + std::to_string(instance.id) +
                               ": model " + std::to_string(instance.model) + " is outside 0.." +
                               std::to_string(truth.scene.models.size()));
    }
  }
  keypoints_from_json(text("keypoints.json"), name("keypoints.json"), truth.scene);
  true_traits_from_json(text("traits.json"), name("traits.json"), truth.scene);
  if (!fs::exists(dir / "scene_gt_info.json")) return truth;
  truth.labels.resize(truth.views.size());
  scene_gt_info_from_json(text("scene_gt_info.json"), name("scene_gt_info.json"), truth.views,
                          truth.labels);
  keypoint_views_from_json(text("keypoints.json"), name("keypoints.json"), truth.scene, truth.views,
                           truth.labels);
  for (SensorViews& other : truth.other_sensors) read_sensor_labels(dir, truth.scene, other);
  return truth;
}

/// The file of an image, which may be a JPEG. @throws if there is neither.
fs::path image_there(const fs::path& scene_dir, const std::string& folder, int frame) {
  const fs::path png = fs::path(folder) / (six_digits(frame) + ".png");
  for (const fs::path& relative : {png, fs::path(png).replace_extension(".jpg")}) {
    if (fs::exists(scene_dir / relative)) return resolve_inside(scene_dir, relative);
  }
  throw std::runtime_error((scene_dir / png).string() + " (frame " + std::to_string(frame) +
                           "): the image is missing");
}

const TrueView& true_view(const ExportTruth& truth, const ExportScene& scene,
                          const ExportPicture& picture) {
  const int id = scene.capture.frames[picture.frame].id;
  const std::string& sensor = scene.capture.rig[picture.sensor].name;
  const std::vector<TrueView>* views = picture.sensor == 0 ? &truth.views : nullptr;
  for (const SensorViews& other : truth.other_sensors) {
    if (picture.sensor > 0 && other.sensor == sensor) views = &other.views;
  }
  if (views != nullptr) {
    for (const TrueView& view : *views) {
      if (view.frame == id) return view;
    }
  }
  throw std::runtime_error((scene.folder / "truth/camera.json").string() + ": has no frame " +
                           std::to_string(id) + " of the sensor \"" + sensor + "\"");
}

}  // namespace

ExportScene read_export_scene(const fs::path& scene_dir) {
  ExportScene scene;
  scene.folder = scene_dir;
  scene.number = std::max(0, number_of_six_digits(scene_dir.filename().string()));
  const fs::path rig_file = scene_dir / "rig.json", camera_file = scene_dir / "scene_camera.json";
  scene.capture = rig_from_json(read_file(rig_file), rig_file.string());
  const std::vector<std::vector<ImageKinds>> kinds =
      frames_from_json(read_file(camera_file), camera_file.string(), scene.capture);
  const std::vector<SensorReport>& rig = scene.capture.rig;
  const std::size_t own_depth = depth_sensor(rig);
  const std::size_t depth = own_depth < rig.size() ? own_depth : 0;
  scene.depth_images.resize(kinds.size());
  for (std::size_t f = 0; f < kinds.size(); ++f) {
    const int id = scene.capture.frames[f].id;
    for (std::size_t s = 0; s < rig.size(); ++s) {
      if (!kinds[f][s].color && !kinds[f][s].grey) continue;
      scene.pictures.push_back({f, s,
                                image_there(scene_dir, image_folder(rig, s, ImageKind::color), id),
                                kinds[f][s].grey});
    }
    const std::string folder = image_folder(rig, depth, ImageKind::depth);
    const bool is_foreign = kinds[f][depth].depth_if_there &&
                            fs::exists(scene_dir / folder / (six_digits(id) + ".png"));
    if (!kinds[f][depth].depth && !is_foreign) continue;
    scene.depth_images[f] = image_there(scene_dir, folder, id);
    scene.depth_sensor = depth;
  }
  if (fs::is_directory(scene_dir / "truth")) scene.truth = read_export_truth(scene_dir);
  return scene;
}

// ---- options ------------------------------------------------------------------------------------

std::string_view to_string(MaskCode code) { return code == MaskCode::rle ? "rle" : "polygon"; }

std::string_view to_string(YoloTask task) {
  return task == YoloTask::detect ? "detect" : task == YoloTask::segment ? "segment" : "pose";
}

MaskCode mask_code_from_string(const std::string& text) {
  for (const MaskCode code : {MaskCode::rle, MaskCode::polygon}) {
    if (text == to_string(code)) return code;
  }
  throw std::invalid_argument("--masks \"" + text + "\" is not one of rle, polygon");
}

YoloTask yolo_task_from_string(const std::string& text) {
  for (const YoloTask task : {YoloTask::detect, YoloTask::segment, YoloTask::pose}) {
    if (text == to_string(task)) return task;
  }
  throw std::invalid_argument("--task \"" + text + "\" is not one of detect, segment, pose");
}

std::array<double, 3> split_from_string(const std::string& text) {
  std::array<double, 3> shares{};
  const char* at = text.data();
  const char* const end = at + text.size();
  bool good = true;
  for (std::size_t i = 0; i < 3 && good; ++i) {
    const auto [stop, error] = std::from_chars(at, end, shares[i]);
    good = error == std::errc{} && shares[i] >= 0 && shares[i] <= 1 &&
           (i < 2 ? stop != end && *stop == ',' : stop == end);
    at = stop + (good && i < 2 ? 1 : 0);
  }
  if (!good || std::abs(shares[0] + shares[1] + shares[2] - 1) > 1e-9) {
    throw std::invalid_argument("--split \"" + text +
                                "\" is not three shares of train, val and test that add up to 1, "
                                "as 0.8,0.1,0.1");
  }
  return shares;
}

// ---- cameras ------------------------------------------------------------------------------------

const ExportTruth& truth_of(const ExportScene& scene, const std::string& format) {
  if (scene.truth) return *scene.truth;
  throw std::runtime_error(scene.folder.string() + ": there is no truth/; " + format +
                           " needs a simulated dataset with its truth");
}

ExportCamera camera_of(const ExportScene& scene, const ExportPicture& picture, bool is_true) {
  const Frame& frame = scene.capture.frames[picture.frame];
  const SensorFrame& sensor = frame.sensors[picture.sensor];
  ExportCamera result;
  result.time_s = sensor.time_s.value_or(frame.time_s);
  if (is_true) {
    const TrueView& view = true_view(truth_of(scene, "--true-cameras"), scene, picture);
    result.camera = view.camera;
    result.camera_from_world = pose_at_row(view, 0.5 * (view.camera.height_px - 1));
    result.time_s = view.time_s;
    return result;
  }
  result.camera = sensor.reported;
  if (frame.rig_from_world) {
    result.camera_from_world =
        scene.capture.rig[picture.sensor].sensor_from_rig * *frame.rig_from_world;
  }
  return result;
}

Pose pose_of(const ExportScene& scene, const ExportPicture& picture, const ExportCamera& camera) {
  if (camera.camera_from_world) return *camera.camera_from_world;
  throw std::runtime_error(
      scene.folder.string() + ": frame " + std::to_string(scene.capture.frames[picture.frame].id) +
      " has no pose: the rig does not know where it is; --true-cameras takes the truth's");
}

Camera handed_over(const Camera& lens, const ExportOptions& options) {
  return options.undistort ? undistorted_camera(lens) : lens;
}

}  // namespace cousin
