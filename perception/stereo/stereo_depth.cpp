#include "perception/stereo/stereo_depth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"
#include "sim/imaging/rectification.h"

namespace cousin {
namespace {

/// Looks a left pixel's depth up in the rectified image, whose camera shares its centre.
float depth_at(const Eigen::Vector3d& ray, const Rectification& rectification,
               const Image<float>& rectified_depth_m) {
  const Eigen::Vector3d turned = rectification.rectified_from_left * ray;
  const auto pixel = project(rectification.camera, turned);
  if (!pixel) return std::numeric_limits<float>::quiet_NaN();
  const int x = static_cast<int>(std::lround(pixel->x()));
  const int y = static_cast<int>(std::lround(pixel->y()));
  if (!rectified_depth_m.contains(x, y)) return std::numeric_limits<float>::quiet_NaN();
  // The rectified depth is along another axis: the same point's distance is what both share.
  const double along = static_cast<double>(rectified_depth_m(x, y)) / turned.z();
  return static_cast<float>(along * ray.z());
}

}  // namespace

Fields fields(StereoDepthConfig& c) {
  return {{"range_px", &c.match.range_px, "largest disparity", 1, 254},
          {"nearest_m", &c.nearest_m, "disparities end there; 0: at range_px", 0, 100}};
}

void validate(const StereoDepthConfig& config) {
  StereoDepthConfig copy = config;
  check_limits(fields(copy), "stereo_depth");
  validate(config.match);
}

FrameDepth depth_of_stereo(const Capture& capture, std::size_t frame,
                           const StereoDepthConfig& config) {
  validate(config);
  const Frame& seen = capture.frames.at(frame);
  const std::string where = "stereo depth: frame " + std::to_string(seen.id);
  if (capture.rig.size() < 2 || seen.sensors.size() < 2 || seen.sensors[0].color.empty() ||
      seen.sensors[1].color.empty()) {
    throw std::invalid_argument(where + " has not two colour images");
  }
  const SensorFrame &left = seen.sensors[0], &right = seen.sensors[1];
  const Pose right_from_left =
      capture.rig[1].sensor_from_rig * inverse(capture.rig[0].sensor_from_rig);
  const Rectification rectification = rectify(left.reported, right.reported, right_from_left);
  StereoMatchConfig match = config.match;
  if (config.nearest_m > 0) {
    const double most_px = rectification.camera.fx_px * rectification.baseline_m / config.nearest_m;
    if (!(most_px <= 254)) {
      throw std::invalid_argument(where + ": nearest_m = " + std::to_string(config.nearest_m) +
                                  " is " + std::to_string(most_px) +
                                  " px of disparity; the limit is 254");
    }
    match.range_px = std::max(1, static_cast<int>(std::ceil(most_px)));
  }
  const PassiveDepth rectified = passive_depth(left.color, right.color, rectification, match);
  FrameDepth result;
  result.frame = seen.id;
  result.depth_m = Image<float>(left.color.width(), left.color.height());
  tbb::parallel_for(0, result.depth_m.height(), [&](int y) {
    for (int x = 0; x < result.depth_m.width(); ++x) {
      const auto ray = unproject(left.reported, Eigen::Vector2d(x, y));
      result.depth_m(x, y) = ray && ray->z() > 0 ? depth_at(*ray, rectification, rectified.depth_m)
                                                 : std::numeric_limits<float>::quiet_NaN();
    }
  });
  return result;
}

}  // namespace cousin
