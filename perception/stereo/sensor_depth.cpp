#include "perception/stereo/sensor_depth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

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

/// The sensor's depth in the first one's pixels; NaN = none.
Image<float> in_first_sensor(const SensorFrame& depth, const Pose& first_from_depth,
                             const FramePose& pose) {
  const Image<std::uint16_t> codes = register_depth(depth.depth, depth.depth_unit_m, depth.reported,
                                                    pose.camera, first_from_depth);
  Image<float> depth_m(codes.width(), codes.height(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < codes.size(); ++i) {
    if (codes.data()[i] != 0)
      depth_m.data()[i] = static_cast<float>(codes.data()[i] * depth.depth_unit_m);
  }
  return depth_m;
}

/// A frame's depth with its sigmas. @param sigma_per_squared_m  NaN = not known
FrameDepth with_sigmas(const Image<float>& found_m, const FramePose& pose,
                       const DepthVolume& volume, double sigma_per_squared_m,
                       const SensorDepthConfig& config) {
  FrameDepth result;
  result.frame = pose.frame;
  PlateResidual plate;
  if (volume.plate_m > 0) plate = plate_residual(found_m, pose, volume.plate_m);
  const bool sees_plate = plate.pixels >= config.least_plate_px;
  const double offset_m = sees_plate && config.level_on_plate ? plate.offset_m : 0;
  const double spread_m = sees_plate ? plate.sigma_m : 0;
  const bool knows_sigma = std::isfinite(sigma_per_squared_m) || sees_plate;
  const auto none = std::numeric_limits<float>::quiet_NaN();
  result.depth_m = Image<float>(found_m.width(), found_m.height(), none);
  if (knows_sigma) result.sigma_m = Image<float>(found_m.width(), found_m.height(), none);
  const Pose world_from_camera = inverse(pose.camera_from_world);
  for (int y = 0; y < found_m.height(); ++y) {
    for (int x = 0; x < found_m.width(); ++x) {
      if (std::isnan(found_m(x, y))) continue;
      const double z_m = static_cast<double>(found_m(x, y)) - offset_m;
      const double law_m =
          std::isfinite(sigma_per_squared_m) ? sigma_per_squared_m * z_m * z_m : 0.0;
      const double sigma_m = std::max(law_m, spread_m);
      if (!(z_m > 0) || sigma_m > config.max_sigma_m) continue;
      const auto ray = unproject(pose.camera, Eigen::Vector2d(x, y));
      if (!ray || !(ray->z() > 0)) continue;
      const Eigen::Vector3d point_m = world_from_camera * (*ray * (z_m / ray->z())).eval();
      const double slack_m = 3 * sigma_m;
      if ((point_m.array() < volume.low_m.array() - slack_m).any() ||
          (point_m.array() > volume.high_m.array() + slack_m).any())
        continue;
      result.depth_m(x, y) = static_cast<float>(z_m);
      if (knows_sigma) result.sigma_m(x, y) = static_cast<float>(sigma_m);
    }
  }
  return result;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Fields fields(SensorDepthConfig& c) {
  return {{"sigma_px", &c.sigma_px, "sigma of the sensor's disparity", 0.001, 10},
          {"max_sigma_m", &c.max_sigma_m, "depths known worse are left out", 1e-6, 10},
          {"window_px", &c.window_px, "width of the sensor's matching window", 0, 101},
          {"level_on_plate", &c.level_on_plate, "move a frame's depths onto the plate it sees"},
          {"least_plate_px", &c.least_plate_px, "pixels of the plate that say how far off they are",
           3, 1000000}};
}

void validate(const SensorDepthConfig& config) {
  SensorDepthConfig copy = config;
  check_limits(fields(copy), "sensor_depth");
}

PlateResidual plate_residual(const Image<float>& depth_m, const FramePose& pose, double plate_m) {
  constexpr double kInner = 0.75;  // an eighth of the side off at each edge
  constexpr double kClip = 3;      // sigmas
  constexpr int kRounds = 3;
  const Pose world_from_camera = inverse(pose.camera_from_world);
  const Eigen::Vector3d& centre_m = world_from_camera.translation_m;
  std::vector<double> residuals_m;
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      if (std::isnan(depth_m(x, y))) continue;
      const auto ray = unproject(pose.camera, Eigen::Vector2d(x, y));
      if (!ray || !(ray->z() > 0)) continue;
      const Eigen::Vector3d way = world_from_camera.rotation * (*ray / ray->z()).eval();
      const double face_m = -centre_m.z() / way.z();  // along the axis
      const Eigen::Vector3d met_m = centre_m + face_m * way;
      if (!(face_m > 0) || !(met_m.head<2>().cwiseAbs().maxCoeff() <= 0.5 * kInner * plate_m))
        continue;
      residuals_m.push_back(static_cast<double>(depth_m(x, y)) - face_m);
    }
  }
  PlateResidual plate{.pixels = static_cast<int>(residuals_m.size())};
  for (int round = 0; round < kRounds && !residuals_m.empty(); ++round) {
    plate.offset_m = median(residuals_m);
    std::vector<double> away_m;
    for (const double r : residuals_m) away_m.push_back(std::abs(r - plate.offset_m));
    plate.sigma_m = 1.4826 * median(away_m);
    std::erase_if(residuals_m,
                  [&](double r) { return std::abs(r - plate.offset_m) > kClip * plate.sigma_m; });
  }
  return plate;
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
    depths[i] = with_sigmas(in_first_sensor(sensor, first_from_depth, poses[i]), poses[i], volume,
                            sigma_per_squared_m, config);
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
