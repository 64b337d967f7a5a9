#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "calibration/boards/planar_pose.h"
#include "calibration/bundle/bundle_adjustment.h"
#include "sim/types/rng.h"

namespace cousin {

inline Camera phone() {
  Camera camera;
  camera.model = LensModel::opencv5;
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.fx_px = camera.fy_px = 1080;
  camera.cx_px = 643;
  camera.cy_px = 356;
  camera.distortion = {0.05, -0.08, 4e-4, -3e-4, 0.02};
  return camera;
}

/// A plant of 0.2 m seen from cameras around it, as a hand goes around a pot.
struct PlantCapture {
  BundleAdjustmentInput truth;  ///< exact, with what the images show
};

/// @param nadir  all look straight down on a flat bench
inline PlantCapture plant_capture(int images, int points, double noise_px, bool nadir,
                                  std::uint64_t seed) {
  PlantCapture capture;
  BundleAdjustmentInput& t = capture.truth;
  t.lenses = {phone()};
  Rng rng = Rng(seed).fork("plant");
  for (int i = 0; i < points; ++i) {
    Eigen::Vector3d at(uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1), uniform(rng, 0, 0.15));
    if (nadir) at.z() = 0;
    t.points_in_world_m.push_back(at);
  }
  for (int i = 0; i < images; ++i) {
    const double a = 2 * std::numbers::pi * i / images, e = 0.5 + 0.4 * (i % 3);
    Pose pose;
    if (nadir) {
      pose.rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
      const Eigen::Vector3d eye(0.01 * (i % 5) - 0.02, 0.01 * (i / 5) - 0.02, 0.4);
      pose.translation_m = -(pose.rotation * eye);
    } else {
      pose = look_at(
          0.4 * Eigen::Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)),
          Eigen::Vector3d(0, 0, 0.05));
      const Eigen::AngleAxisd roll(0.3 * std::sin(5.0 * i), Eigen::Vector3d::UnitZ());
      pose.rotation = roll * pose.rotation;
      pose.translation_m = roll * pose.translation_m;
    }
    t.camera_from_world.push_back(pose);
    t.lens_of_image.push_back(0);
  }
  const Lens lens(t.lenses[0]);
  for (int i = 0; i < images; ++i) {
    for (int p = 0; p < points; ++p) {
      const auto pixel = lens.project(t.camera_from_world[static_cast<std::size_t>(i)] *
                                      t.points_in_world_m[static_cast<std::size_t>(p)]);
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 1279 || pixel->y() > 719)
        continue;
      const Eigen::Vector2d noise(noise_px * normal(rng), noise_px * normal(rng));
      t.observations.push_back({i, p, *pixel + noise, 1});
    }
  }
  return capture;
}

/// What a structure from motion would hand over: all a little off.
inline BundleAdjustmentInput disturbed(BundleAdjustmentInput input, std::uint64_t seed) {
  Rng rng = Rng(seed).fork("start");
  for (Camera& lens : input.lenses) {
    lens.fx_px *= 1.01;
    lens.fy_px *= 1.01;
    lens.cx_px += 3;
    lens.distortion = {};
  }
  for (Pose& pose : input.camera_from_world) {
    const Eigen::Vector3d turn(0.005 * normal(rng), 0.005 * normal(rng), 0.005 * normal(rng));
    pose.rotation = exp_rotation(turn) * pose.rotation;
    pose.translation_m += 0.002 * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
  }
  for (Eigen::Vector3d& point : input.points_in_world_m)
    point += 0.003 * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
  return input;
}

}  // namespace cousin
