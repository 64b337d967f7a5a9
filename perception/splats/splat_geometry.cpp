#include "perception/splats/splat_geometry.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kFirstHarmonic = 0.28209479177387814;  ///< Y of degree 0: 1 / sqrt(4 pi)
/// Share of the centres' extent that positions as float may be off by.
constexpr double kMostRounded = 1e-3;

/// 8-bit code of a colour of 0..1; values beyond are clamped, NaN is 0.
std::uint8_t code_of(double value) {
  return static_cast<std::uint8_t>(value > 0 ? std::lround(255 * std::min(value, 1.0)) : 0);
}

double opacity_of(const Splat& splat) {
  return 1 / (1 + std::exp(-static_cast<double>(splat.opacity_logit)));
}

Image<Rgb8> codes_of(const ColorPlanes& color) {
  const auto& [red, green, blue] = color.channel;
  Image<Rgb8> image(red.width(), red.height());
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = {code_of(static_cast<double>(red.data()[i])),
                       code_of(static_cast<double>(green.data()[i])),
                       code_of(static_cast<double>(blue.data()[i]))};
  }
  return image;
}

/// Adds one to each Gaussian that a view sees.
void count_seen(const SplatModel& model, const FramePose& pose, const Image<float>& depth_m,
                double slack, std::vector<int>& counts) {
  const Lens lens(pose.camera);
  tbb::parallel_for(std::size_t{0}, model.splats.size(), [&](std::size_t i) {
    const Splat& splat = model.splats[i];
    const Eigen::Vector3d in_world_m = model.origin_in_world_m + splat.centre_m.cast<double>();
    const Eigen::Vector3d in_camera_m = pose.camera_from_world * in_world_m;
    if (!in_camera_m.allFinite() || !(in_camera_m.z() > 0)) return;
    const auto pixel = lens.project(in_camera_m);
    if (!pixel || !(pixel->cwiseAbs().maxCoeff() < 1e6)) return;
    const int x = static_cast<int>(std::floor(pixel->x() + 0.5));
    const int y = static_cast<int>(std::floor(pixel->y() + 0.5));
    if (!depth_m.contains(x, y)) return;
    const double reach_m = slack * std::exp(static_cast<double>(splat.log_scale.maxCoeff()));
    const auto surface_m = static_cast<double>(depth_m(x, y));
    if (!std::isfinite(surface_m) || in_camera_m.z() <= surface_m + reach_m) ++counts[i];
  });
}

}  // namespace

Cloud splat_centres(const SplatModel& model, double least_opacity) {
  if (!(least_opacity >= 0 && least_opacity <= 1)) {
    throw std::invalid_argument("splat_centres: least_opacity = " + std::to_string(least_opacity) +
                                " is not in 0..1");
  }
  Cloud cloud;
  Eigen::AlignedBox3d box;
  for (const Splat& splat : model.splats) {
    if (!(opacity_of(splat) >= least_opacity)) continue;
    box.extend(splat.centre_m.cast<double>());
    CloudPoint point;
    point.position_m = (model.origin_in_world_m + splat.centre_m.cast<double>()).cast<float>();
    const auto code = [&](std::size_t c) {
      return code_of(0.5 + kFirstHarmonic * static_cast<double>(splat.sh_dc[c]));
    };
    point.color = {code(0), code(1), code(2)};
    cloud.push_back(point);
  }
  if (!model.origin_in_world_m.allFinite())
    throw std::invalid_argument("splat_centres: the model's origin is not finite");
  const double far_m = model.origin_in_world_m.cwiseAbs().maxCoeff();
  const double off_m = 0.5 * std::numeric_limits<float>::epsilon() * far_m;
  const double extent_m = box.isEmpty() ? 0 : box.diagonal().norm();
  if (extent_m > 0 && off_m > kMostRounded * extent_m) {
    std::ostringstream text;
    text << "splat_centres: the model's origin is " << far_m << " m away, its centres are "
         << extent_m << " m apart: positions as float would be off by " << off_m << " m";
    throw std::invalid_argument(text.str());
  }
  return cloud;
}

SplatDepthImages render_splat_depths(const SplatModel& model, std::span<const SplatViewpoint> from,
                                     const SplatRenderConfig& config) {
  SplatDepthImages result;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const SplatViewpoint& viewpoint = from[i];
    SplatImage image = render_splats(model, viewpoint.camera, viewpoint.camera_from_world, config);
    const int id = static_cast<int>(i);
    Frame frame{.id = id, .rig_from_world = viewpoint.camera_from_world};
    frame.sensors.push_back({.reported = viewpoint.camera, .color = codes_of(image.color)});
    result.capture.frames.push_back(std::move(frame));
    FramePose pose;
    pose.frame = id;
    pose.status = PoseStatus::ok;
    pose.camera_from_world = viewpoint.camera_from_world;
    pose.camera = viewpoint.camera;
    result.poses.push_back(pose);
    result.depths.push_back({id, std::move(image.depth_m), {}});
  }
  if (!from.empty()) result.capture.rig.push_back({.camera = from.front().camera});
  return result;
}

Cloud fused_splat_cloud(const SplatDepthImages& depths, const FuseConfig& config) {
  const GreenConfig nothing_is_green{.hue_low = 1, .hue_high = 0};
  return fuse_depths(depths.capture, depths.poses, depths.depths, nothing_is_green, config);
}

std::vector<int> views_that_see(const SplatModel& model, const SplatDepthImages& depths,
                                double slack) {
  if (!(slack >= 0) || !std::isfinite(slack)) {
    throw std::invalid_argument("views_that_see: slack = " + std::to_string(slack) +
                                " is not a number of 0 or more");
  }
  std::vector<int> counts(model.splats.size(), 0);
  for (std::size_t v = 0; v < depths.depths.size(); ++v)
    count_seen(model, depths.poses.at(v), depths.depths[v].depth_m, slack, counts);
  return counts;
}

}  // namespace cousin
