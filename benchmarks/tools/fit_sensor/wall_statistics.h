#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/tools/fit_sensor/recordings.h"
#include "sim/types/image.h"

namespace cousin {

/// How disparities follow from a device's depth images: d = focal baseline / (code depth_unit).
struct DepthGeometry {
  int width_px = 640, height_px = 480;
  double focal_px = 384, baseline_m = 0.095;
  double depth_unit_m = 0.001;
  double disparity_step_px = 0;  ///< the device's own; 0 = none
  ImageRegion region;            ///< where walls are measured
};

/// A number and its standard error.
struct Measured {
  double value = 0;
  double sigma = 0;
};

/// The frames of a wall, wherever they come from.
struct WallFrames {
  std::string name;
  double distance_m = 0, distance_sigma_m = 0.002;
  double albedo = 0.5, light = 0.02;
  int count = 0;
  std::function<Image<std::uint16_t>(int)> frame;  ///< of the geometry's size
};

/// Mean error of the disparity over one tenth of the fraction of the disparity.
struct RippleBin {
  double sum_px = 0;
  double pixels = 0;
};
inline constexpr int kRippleBins = 20;

/// What the frames of one wall say. A plane, which is a plane in disparity too, is fitted to each
/// frame, robustly; errors are those of the disparity about it, over the region. Standard errors
/// are those of sums over square tiles of the region, which are taken as independent: noise of
/// stereo is alike over a matching window.
struct WallStatistics {
  std::string name;
  double distance_m = 0, distance_sigma_m = 0.002;  ///< stated
  double albedo = 0.5, light = 0.02;
  int frames = 0, tiles = 0;
  double median_depth_m = 0;      ///< of the first frame's region, no plane asked; 0 = no depth
  std::int64_t pixels = 0;        ///< with a depth in at least half of the frames
  double disparity_px = 0;        ///< of the planes' mean in the image's middle, beside the ripple
  double disparity_sigma_px = 0;  ///< its standard error
  double depth_m = 0;             ///< the same
  double incidence_rad = 0;       ///< angle between the wall's normal and the optical axis
  double drift_px = 0;            ///< standard deviation of the planes over the frames
  double quantum_px = 0;          ///< step of the depth there, as disparity
  Measured spatial_px;            ///< what stays from frame to frame, without ripple and rounding
  Measured temporal_px;           ///< of one pixel over the frames, without rounding
  Measured sigma_px;              ///< both
  Measured fill;                  ///< share of pixels and frames with a depth
  double wrong = 0;               ///< share of those that are not the wall's
  bool ripple_seen = false;       ///< the disparities span enough fractions
  Eigen::Vector2d ripple_px = Eigen::Vector2d::Zero();  ///< of sin(2 pi d) and cos(2 pi d)
  Eigen::Matrix2d ripple_covariance = Eigen::Matrix2d::Zero();
  double bend_px = 0;  ///< RMS of what second-order terms of the plane explain
  double bend_m = 0;   ///< the same as depth
  double bend_p = 1;   ///< how likely a flat wall looks as bent
  std::vector<RippleBin> ripple_bins;
  std::string problem;  ///< why the wall cannot be used; empty if it can
};

/// @throws std::runtime_error naming the wall if a frame is not of the geometry's size.
WallStatistics wall_statistics(const WallFrames& wall, const DepthGeometry& geometry);

}  // namespace cousin
