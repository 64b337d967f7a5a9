#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "perception/ngp/ngp.h"

namespace cousin {

inline Camera small_camera() {
  Camera camera;
  camera.width_px = 48;
  camera.height_px = 36;
  camera.fx_px = camera.fy_px = 50;
  camera.cx_px = 23.5;
  camera.cy_px = 17.5;
  return camera;
}

/// A ball of radius 0.3 m with stripes over a grey ground, by closed-form intersection.
inline NgpView ball_view(const Camera& camera, double turn_rad) {
  NgpView view;
  view.camera = camera;
  view.camera_from_world =
      look_at({1.1 * std::cos(turn_rad), 1.1 * std::sin(turn_rad), 0.5}, {0, 0, 0});
  view.color = Image<Rgb8>(camera.width_px, camera.height_px);
  const Pose world_from_camera = inverse(view.camera_from_world);
  const Eigen::Vector3d eye = world_from_camera.translation_m;
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const Eigen::Vector3d ray =
          world_from_camera.rotation * *unproject(camera, Eigen::Vector2d(x, y));
      const double b = eye.dot(ray), c = eye.squaredNorm() - 0.09;
      if (b * b - c > 0) {
        const Eigen::Vector3d hit = eye - (b + std::sqrt(b * b - c)) * ray;
        const bool stripe = std::fmod(hit.z() + 10, 0.2) < 0.1;
        view.color(x, y) = stripe ? Rgb8{200, 60, 40} : Rgb8{40, 160, 60};
      }
    }
  }
  return view;
}

inline std::vector<NgpView> ball_views(int count) {
  std::vector<NgpView> views;
  for (int i = 0; i < count; ++i)
    views.push_back(ball_view(small_camera(), 2 * std::numbers::pi * i / count));
  return views;
}

inline NgpConfig small_field_config() {
  NgpConfig config;
  config.iterations = 120;
  config.samples_per_step = 4096;
  config.grid = {8, 12, 8, 128};
  config.occupancy_cells = 32;
  config.steps = 128;
  config.cascades = 1;
  config.side_m = 1.2;
  return config;
}

}  // namespace cousin
