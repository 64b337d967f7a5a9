#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "perception/mvs/plane_sweep.h"
#include "perception/splats/splat_views.h"
#include "sim/imaging/color.h"
#include "sim/types/camera.h"

namespace cousin {

inline constexpr int kPlaneWidth_px = 160, kPlaneHeight_px = 120;
inline const SweepVolume kPlaneVolume{{-0.25, -0.2, -0.05}, {0.25, 0.2, 0.15}};

/// Spots a few pixels wide, without a period within the plane.
inline double light_at(double x_m, double y_m) {
  double sum = 0;
  for (int i = 1; i <= 6; ++i)
    sum += std::sin(90 * (x_m * std::cos(1.7 * i) + y_m * std::sin(1.7 * i)) + i * i);
  return 0.25 + 0.03 * sum;
}

/// Of its exposure.
inline double plane_log_gain(int view) { return (view % 2 == 0 ? 1 : -1) * std::log(1.3); }

/// Eight views of the plane z = 0.03 from about half a metre, by automatic exposure.
/// @param lamp  its light in each channel
inline std::vector<SplatView> exposed_plane(const std::array<double, 3>& lamp = {1, 1, 1}) {
  std::vector<SplatView> views;
  for (int i = 0; i < 8; ++i) {
    SplatView view;
    view.frame = i;
    const double turn = 0.785 * i;
    view.camera_from_world = look_at({0.15 * std::cos(turn), 0.15 * std::sin(turn), 0.5},
                                     {0, 0, 0.03}, Eigen::Vector3d::UnitY());
    SplatViewLevel& level = view.full;
    level.camera = {LensModel::pinhole, kPlaneWidth_px, kPlaneHeight_px, 180, 180, 79.5, 59.5};
    for (Image<float>& channel : level.color.channel)
      channel = Image<float>(kPlaneWidth_px, kPlaneHeight_px);
    const Lens lens(level.camera);
    const Pose world_from_camera = inverse(view.camera_from_world);
    const Eigen::Vector3d eye_m = world_from_camera.translation_m;
    const double gain = std::exp(plane_log_gain(i));
    for (int y = 0; y < kPlaneHeight_px; ++y) {
      for (int x = 0; x < kPlaneWidth_px; ++x) {
        const Eigen::Vector3d ray = world_from_camera.rotation * *lens.unproject({x, y});
        const Eigen::Vector3d at_m = eye_m + ray * ((0.03 - eye_m.z()) / ray.z());
        const double light = gain * light_at(at_m.x(), at_m.y());
        for (std::size_t c = 0; c < 3; ++c)
          level.color.channel[c](x, y) = srgb_from_linear(static_cast<float>(lamp[c] * light));
      }
    }
    views.push_back(view);
  }
  return views;
}

}  // namespace cousin
