#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/types/board.h"
#include "sim/types/camera.h"
#include "sim/types/capture.h"
#include "sim/types/pose.h"
#include "sim/types/rng.h"

namespace cousin::synthetic {

/// A seed stand-in: an ellipsoid resting on the board.
struct Ellipsoid {
  Eigen::Vector3d centre_m;
  Eigen::Matrix3d world_from_axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d half_axes_m{0.004, 0.002, 0.002};
};

/// One exposure of a board by a rolling or global shutter, without any renderer.
struct View {
  Camera camera;               ///< true lens
  Pose camera_from_world;      ///< first row
  Pose camera_from_world_end;  ///< last row; equal for a global shutter
};

struct ImageConfig {
  double blur_sigma_px = 0.5;
  double electrons = 6000;  ///< at a linear signal of 1
  double read_noise_e = 2;
  bool noise = true;
};

Camera phone_camera(int width_px, LensModel model = LensModel::opencv5);
/// Ten ellipsoids of 5-12 mm on the middle of the board.
std::vector<Ellipsoid> seeds(Rng rng);
/// Camera at a distance, elevation and azimuth from the board's centre, aimed near it.
Pose orbit(double distance_m, double elevation_rad, double azimuth_rad, double roll_rad = 0,
           const Eigen::Vector3d& target_m = Eigen::Vector3d::Zero());
/// Adds a hand's motion during readout (camera side).
View hand_held(const Camera& camera, const Pose& camera_from_world, double shift_sigma_m,
               double turn_sigma_rad, Rng rng);
Pose middle_pose(const View& view);
Pose pose_at_row(const View& view, double row);
/// True pixel of a board point, by iterating on the row in which it is read.
Eigen::Vector2d true_pixel(const View& view, const Eigen::Vector3d& in_world_m);

/// 8-bit sRGB: plate, print, ellipsoids and a green screen, box-filtered over the pixel, blurred,
/// with shot noise.
Image<Rgb8> photograph(const View& view, const SeedBoard& board,
                       const std::vector<Ellipsoid>& ellipsoids, const ImageConfig& config,
                       Rng rng);

/// A hand-held capture on three rings, with the truth beside it.
struct Shoot {
  Capture capture;
  std::vector<View> views;
};
struct ShootConfig {
  int views = 60;
  int width_px = 1280;
  LensModel lens = LensModel::opencv5;
  double readout_s = 0.015;
  double hand_speed_m_per_s = 0.02;
  double hand_rate_rad_per_s = 0.02;
  double report_focal_error = 0.002;
  double report_centre_error_px = 1;
  double report_distortion_error = 0.05;
  double focus_error = 0.01;  ///< of the focused distance; the report follows the nominal distance
  double report_focus_error = 0;  ///< of the focused distance that an image's report is made for
  bool seeds = true;
  double distance_scale = 1;  ///< rings at 0.45, 0.40 and 0.35 m times this
};
/// Geometry and reported cameras; images stay empty.
Shoot plan_shoot(const ShootConfig& config, Rng rng);
/// The same with images.
Shoot shoot(const ShootConfig& config, const SeedBoard& board, const ImageConfig& image, Rng rng);

}  // namespace cousin::synthetic
