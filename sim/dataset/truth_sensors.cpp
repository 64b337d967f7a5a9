#include "sim/dataset/truth_sensors.h"

#include <algorithm>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/truth_json.h"

namespace cousin {
namespace {

constexpr std::size_t kSensorJsonLimitBytes = std::size_t{1} << 29;

}  // namespace

std::filesystem::path sensor_folder(const std::string& sensor) {
  return sensor.empty() ? std::filesystem::path() : std::filesystem::path("sensors") / sensor;
}

void write_sensor_labels(const std::filesystem::path& truth_dir, const Scene& scene,
                         const SensorViews& sensor) {
  const std::filesystem::path dir = truth_dir / sensor_folder(sensor.sensor);
  std::filesystem::create_directories(dir);
  write_file(dir / "scene_gt.json", scene_gt_to_json(scene, sensor.views));
  write_file(dir / "scene_gt_info.json", scene_gt_info_to_json(sensor.views, sensor.images));
  const bool has_keypoints =
      std::any_of(sensor.images.begin(), sensor.images.end(),
                  [](const TruthImages& images) { return !images.keypoints.empty(); });
  if (has_keypoints)
    write_file(dir / "keypoints.json", keypoints_to_json({}, sensor.views, sensor.images));
}

void read_sensor_labels(const std::filesystem::path& truth_dir, const Scene& scene,
                        SensorViews& sensor) {
  const auto file = [&](const char* name) {
    return resolve_inside(truth_dir, sensor_folder(sensor.sensor) / name);
  };
  const std::filesystem::path info = file("scene_gt_info.json"), points = file("keypoints.json");
  if (!std::filesystem::exists(info)) return;
  sensor.images.assign(sensor.views.size(), {});
  scene_gt_info_from_json(read_file(info, kSensorJsonLimitBytes), info.string(), sensor.views,
                          sensor.images);
  if (!std::filesystem::exists(points)) return;
  keypoint_views_from_json(read_file(points, kSensorJsonLimitBytes), points.string(), scene,
                           sensor.views, sensor.images);
}

}  // namespace cousin
