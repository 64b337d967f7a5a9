#pragma once

#include <cmath>
#include <utility>

#include "perception/pipelines/seeds_splats.h"

namespace cousin {

inline const SweepVolume kPlateVolume{{-0.05, -0.05, -0.002}, {0.05, 0.05, 0.026}};
inline constexpr Rgb8 kGreen{40, 200, 60};

/// A camera that looks down at the board's middle from a slant, with a lens that bends.
inline FramePose slanted(int frame, double turn_rad) {
  FramePose pose;
  pose.frame = frame;
  pose.status = PoseStatus::ok;
  pose.camera = {LensModel::opencv5,          320, 240, 400, 400, 159.5, 119.5,
                 {-0.1, 0.02, 1e-3, -1e-3, 0}};
  const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI - 0.4, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
  pose.camera_from_world = {down, {0, 0, 0.3}};
  return pose;
}

/// A plate of flat, dense Gaussians at z = height, and no colour beside grey.
inline SplatModel plate(double height_m) {
  SplatModel model;
  model.sh_degree = 0;
  for (double x = -0.03; x <= 0.03; x += 0.0005) {
    for (double y = -0.03; y <= 0.03; y += 0.0005) {
      Splat splat;
      splat.centre_m = Eigen::Vector3d(x, y, height_m).cast<float>();
      splat.log_scale = {std::log(0.0004F), std::log(0.0004F), std::log(1e-5F)};
      splat.opacity_logit = 4;
      model.splats.push_back(splat);
    }
  }
  return model;
}

/// Photographs of one colour.
inline Capture capture_of(const Poses& poses, Rgb8 color) {
  Capture capture;
  capture.rig.push_back({.camera = poses.front().camera});
  for (const FramePose& pose : poses) {
    Frame frame{.id = pose.frame};
    frame.sensors.push_back(
        {.reported = pose.camera,
         .color = Image<Rgb8>(pose.camera.width_px, pose.camera.height_px, color)});
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

}  // namespace cousin
