#include "perception/pipelines/stereo.h"

#include <array>
#include <cmath>
#include <string>

#include "perception/pipelines/pipeline_table.h"
#include "perception/stereo/stereo_pair.h"
#include "sim/config/changed_keys.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

std::string at_frame(const Frame& frame, const std::string& what) {
  return "frame " + std::to_string(frame.id) + ": " + what;
}

Depths depths_of(const Capture& capture, const StereoDepthConfig& config, StageNotes& notes) {
  Depths depths;
  std::string first;
  bool any = false;
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    StereoMeasure measured = measure_stereo(capture, i, config);
    const Frame& frame = capture.frames[i];
    const std::string& why = measured.findings.why_none;
    if (!why.empty()) {
      if (first.empty()) first = at_frame(frame, why);
      notes.push_back(at_frame(frame, "no depth: " + why));
    }
    for (const std::string& doubt : measured.findings.doubts)
      notes.push_back(at_frame(frame, doubt));
    any = any || why.empty();
    depths.push_back(std::move(measured.depth));
  }
  if (!any) throw StageError("depth", "no frame has depth; " + first);
  return depths;
}

/// Normal of the surface that a pixel and its neighbours lie on, towards the camera; zero where a
/// neighbour has no depth.
Eigen::Vector3d normal_at(const Image<float>& depth_m, const Lens& lens, int x, int y) {
  const auto point = [&](int i, int j) -> std::optional<Eigen::Vector3d> {
    if (!depth_m.contains(i, j) || std::isnan(depth_m(i, j))) return std::nullopt;
    const auto ray = lens.unproject(Eigen::Vector2d(i, j));
    if (!ray) return std::nullopt;
    return *ray / ray->z() * static_cast<double>(depth_m(i, j));
  };
  const auto left = point(x - 1, y), right = point(x + 1, y), up = point(x, y - 1),
             down = point(x, y + 1);
  if (!left || !right || !up || !down) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d across = (*right - *left).cross(*down - *up);
  const double size = across.norm();
  if (!(size > 0)) return Eigen::Vector3d::Zero();
  return across.dot(*left) > 0 ? Eigen::Vector3d(-across / size) : Eigen::Vector3d(across / size);
}

void add_frame(const Frame& frame, const SensorReport& sensor, const FrameDepth& depth, int stride,
               const StereoPipelineConfig& config, Cloud& cloud) {
  const SensorFrame& seen = frame.sensors.front();
  const Lens lens(seen.reported);
  const Pose camera_from_world =
      frame.rig_from_world ? sensor.sensor_from_rig * *frame.rig_from_world : Pose{};
  const Pose world_from_camera = inverse(camera_from_world);
  for (int y = stride / 2; y < depth.depth_m.height(); y += stride) {
    for (int x = stride / 2; x < depth.depth_m.width(); x += stride) {
      const auto z_m = static_cast<double>(depth.depth_m(x, y));
      if (!(z_m > 0)) continue;
      const double sigma_m = depth.sigma_m.empty() ? 0 : static_cast<double>(depth.sigma_m(x, y));
      if (sigma_m > config.cloud_sigma * z_m) continue;
      const auto ray = lens.unproject(Eigen::Vector2d(x, y));
      if (!ray) continue;
      const Eigen::Vector3d in_camera_m = *ray / ray->z() * z_m;
      const Eigen::Vector3d normal = normal_at(depth.depth_m, lens, x, y);
      CloudPoint point;
      point.position_m = (world_from_camera * in_camera_m).cast<float>();
      point.normal = (world_from_camera.rotation * normal).cast<float>();
      // sigma_m is along the axis: times distance / z along the ray, of which the normal sees a
      // part.
      const double turned = normal.isZero() ? 1 : std::abs(normal.dot(in_camera_m)) / z_m;
      point.sigma_m = static_cast<float>(sigma_m * turned);
      if (seen.color.contains(x, y)) {
        point.color = seen.color(x, y);
      } else if (seen.grey.contains(x, y)) {
        const std::uint8_t grey = seen.grey(x, y);
        point.color = {grey, grey, grey};
      }
      cloud.push_back(point);
    }
  }
}

/// Depths may be somebody's.
void require_size(const Frame& frame, const FrameDepth& depth) {
  const Camera& camera = frame.sensors.front().reported;
  const Image<float>& image = depth.depth_m;
  if (image.width() == camera.width_px && image.height() == camera.height_px) return;
  throw StageError("cloud",
                   at_frame(frame, "its depth has " + std::to_string(image.width()) + " x " +
                                       std::to_string(image.height()) + " pixels, its image " +
                                       std::to_string(camera.width_px) + " x " +
                                       std::to_string(camera.height_px)));
}

Cloud cloud_of(const Capture& capture, const Depths& depths, const StereoPipelineConfig& config,
               StageNotes& notes) {
  std::vector<std::size_t> used;
  std::size_t pixels = 0, left_out = 0;
  for (std::size_t i = 0; i < depths.size() && i < capture.frames.size(); ++i) {
    if (depths[i].depth_m.empty()) continue;
    require_size(capture.frames[i], depths[i]);
    if (!used.empty() &&
        !(capture.frames[i].rig_from_world && capture.frames[used.front()].rig_from_world)) {
      ++left_out;
      continue;
    }
    used.push_back(i);
    pixels += depths[i].depth_m.size();
  }
  if (left_out > 0) {
    const Frame& first = capture.frames[used.front()];
    notes.push_back(first.rig_from_world
                        ? std::to_string(left_out) +
                              " frames do not say where the rig was: the cloud is without them"
                        : "the rig does not say where it was: the cloud is of frame " +
                              std::to_string(first.id) + " alone, in its axes");
  }
  const double every =
      static_cast<double>(pixels) / static_cast<double>(std::max(1, config.cloud_points));
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(every))));
  Cloud cloud;
  for (const std::size_t i : used)
    add_frame(capture.frames[i], capture.rig.front(), depths[i], stride, config, cloud);
  return cloud;
}

}  // namespace

Fields fields(StereoPipelineConfig& c) {
  return Fields{{"method", matcher_field(c.method), "which matching finds the disparities"}} +
         nested("stereo", fields(c.stereo)) +
         Fields{{"cloud_points", &c.cloud_points, "about, of all frames together; 0: no cloud", 0,
                 100'000'000},
                {"cloud_sigma", &c.cloud_sigma,
                 "over the depth: points known worse are not in the cloud", 1e-6, 10}};
}

void validate(const StereoPipelineConfig& config) {
  validate(config.stereo);
  StereoPipelineConfig copy = config;
  check_limits(fields(copy), "pipeline");
}

PipelineNeeds needs(const StereoPipelineConfig& config) {
  PipelineNeeds result{.images = {"color"}, .stages = {"depth"}, .left_out = {}};
  if (config.cloud_points > 0)
    result.stages.emplace_back("cloud");
  else
    result.left_out.emplace_back("cloud", "cloud_points=0");
  return result;
}

std::vector<std::string> unused_settings(const StereoPipelineConfig& config) {
  if (config.method == PairMatcher::ours) return {};
  return keys_without_effect(
      config, to_string(config.method),
      {"cloud_sigma", "stereo.speckle_px", "stereo.radius_px", "stereo.least_likeness",
       "stereo.most_sigma_px", "stereo.sigma_floor_px", "stereo.calibration_px"});
}

void check_capture(const Capture& capture, const StereoPipelineConfig& /*config*/) {
  check_stereo_rig(capture);
}

Stages stages_for(const StereoPipelineConfig& config, const Capture& /*capture*/,
                  std::uint64_t /*seed*/, const SplatWatch& /*watch*/) {
  StereoDepthConfig stereo = config.stereo;
  stereo.pair.matcher = config.method;
  Stages stages;
  stages.depths = [stereo](const Capture& capture, const Estimate& so_far) {
    return depths_of(capture, stereo, *so_far.notes);
  };
  if (config.cloud_points > 0) {
    stages.cloud = [config](const Capture& capture, const Estimate& so_far) {
      return cloud_of(capture, so_far.depths, config, *so_far.notes);
    };
  }
  return stages;
}

const PipelineRow& stereo_pipeline();
const PipelineRow& row_of(const StereoPipelineConfig& /*config*/) { return stereo_pipeline(); }

const PipelineRow& stereo_pipeline() {
  static constexpr auto kOrder = std::to_array<std::string_view>({"depth", "cloud"});
  static const PipelineRow kRow = {
      .name = "stereo",
      .help = "depth and a cloud of anything that a pair of cameras sees, with deviations",
      .scenes = {},
      .order = kOrder,
      .traits_of = TraitsOf::depths,
      .methods = {{"ours",
                   "census codes matched semi-globally, then least squares on the brightness, "
                   "which say how sure each disparity is; rows that are off are moved"},
                  {"opencv", "cv::StereoSGBM, which says nothing of its errors"}},
      .defaults = [] { return PipelineConfig(StereoPipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
