#include "perception/stereo/sensor_depth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"
#include "sim/imaging/depth_registration.h"

namespace cousin {
namespace {

std::optional<std::size_t> sensor_named(const Capture& capture, std::string_view name) {
  for (std::size_t s = 0; s < capture.rig.size(); ++s) {
    if (capture.rig[s].name == name) return s;
  }
  return std::nullopt;
}

/// Place of the sensor whose depth counts.
std::optional<std::size_t> depth_place(const Capture& capture) {
  if (const auto own = sensor_named(capture, kDepthSensor)) return own;
  for (const Frame& frame : capture.frames) {
    for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
      if (!frame.sensors[s].depth.empty()) return s;
    }
  }
  return std::nullopt;
}

/// Distance of the infrared imagers, if the rig reports both.
double baseline_m(const Capture& capture) {
  const auto left = sensor_named(capture, "ir_left"), right = sensor_named(capture, "ir_right");
  if (!left || !right) return kNaN;
  const Pose right_from_left =
      capture.rig[*right].sensor_from_rig * inverse(capture.rig[*left].sensor_from_rig);
  return right_from_left.translation_m.norm();
}

FrameDepth in_first_sensor(const SensorFrame& depth, const Pose& first_from_depth,
                           const FramePose& pose, const DepthVolume& volume,
                           double sigma_per_squared_m, const SensorDepthConfig& config) {
  FrameDepth result;
  result.frame = pose.frame;
  const Image<std::uint16_t> codes = register_depth(depth.depth, depth.depth_unit_m, depth.reported,
                                                    pose.camera, first_from_depth);
  const auto none = std::numeric_limits<float>::quiet_NaN();
  result.depth_m = Image<float>(codes.width(), codes.height(), none);
  if (std::isfinite(sigma_per_squared_m))
    result.sigma_m = Image<float>(codes.width(), codes.height(), none);
  const Pose world_from_camera = inverse(pose.camera_from_world);
  for (int y = 0; y < codes.height(); ++y) {
    for (int x = 0; x < codes.width(); ++x) {
      if (codes(x, y) == 0) continue;
      const double z_m = codes(x, y) * depth.depth_unit_m;
      const double sigma_m = sigma_per_squared_m * z_m * z_m;
      if (sigma_m > config.max_sigma_m) continue;
      const auto ray = unproject(pose.camera, Eigen::Vector2d(x, y));
      if (!ray || !(ray->z() > 0)) continue;
      const Eigen::Vector3d point_m = world_from_camera * (*ray * (z_m / ray->z())).eval();
      const bool inside = (point_m.array() >= volume.low_m.array()).all() &&
                          (point_m.array() <= volume.high_m.array()).all();
      if (!inside) continue;
      result.depth_m(x, y) = static_cast<float>(z_m);
      if (!result.sigma_m.empty()) result.sigma_m(x, y) = static_cast<float>(sigma_m);
    }
  }
  return result;
}

}  // namespace

Fields fields(SensorDepthConfig& c) {
  return {{"sigma_px", &c.sigma_px, "sigma of the sensor's disparity", 0.001, 10},
          {"max_sigma_m", &c.max_sigma_m, "depths known worse are left out", 1e-6, 10}};
}

void validate(const SensorDepthConfig& config) {
  SensorDepthConfig copy = config;
  check_limits(fields(copy), "sensor_depth");
}

bool has_sensor_depth(const Capture& capture) {
  const std::optional<std::size_t> place = depth_place(capture);
  return place && std::any_of(capture.frames.begin(), capture.frames.end(), [&](const Frame& f) {
           return f.sensors.size() > *place && !f.sensors[*place].depth.empty();
         });
}

Depths depths_of_sensor(const Capture& capture, const Poses& poses, const DepthVolume& volume,
                        const SensorDepthConfig& config) {
  validate(config);
  if (poses.size() != capture.frames.size()) {
    throw std::invalid_argument("sensor depth: " + std::to_string(poses.size()) + " poses for " +
                                std::to_string(capture.frames.size()) + " frames");
  }
  const std::optional<std::size_t> place = depth_place(capture);
  const double baseline = baseline_m(capture);
  Depths depths(poses.size());
  tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
    depths[i].frame = poses[i].frame;
    const Frame& frame = capture.frames[i];
    if (!place || poses[i].status != PoseStatus::ok || frame.sensors.size() <= *place) return;
    const SensorFrame& sensor = frame.sensors[*place];
    if (sensor.depth.empty()) return;
    const Pose first_from_depth =
        capture.rig.front().sensor_from_rig * inverse(capture.rig[*place].sensor_from_rig);
    const double sigma_per_squared_m = config.sigma_px / (sensor.reported.fx_px * baseline);
    depths[i] =
        in_first_sensor(sensor, first_from_depth, poses[i], volume, sigma_per_squared_m, config);
  });
  return depths;
}

Poses poses_of_rig(const Capture& capture) {
  Poses poses;
  for (const Frame& frame : capture.frames) {
    FramePose pose;
    pose.frame = frame.id;
    if (!frame.sensors.empty()) pose.camera = frame.sensors.front().reported;
    if (frame.rig_from_world && !frame.sensors.empty()) {
      pose.status = PoseStatus::ok;
      pose.camera_from_world = capture.rig.front().sensor_from_rig * *frame.rig_from_world;
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace cousin
