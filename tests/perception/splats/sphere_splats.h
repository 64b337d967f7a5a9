#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "perception/splats/splat_geometry.h"

namespace cousin {

/// A ball's surface covered with flat, nearly opaque Gaussians, spread by the golden angle.
struct SphereSplats {
  double radius_m = 0.1;
  Eigen::Vector3d centre_m = {0.02, -0.01, 0.03};
  int count = 20000;
  double scale_m = 0.0015;  ///< along the surface; across it a tenth
  float opacity_logit = 4;

  SplatModel model() const {
    SplatModel result;
    result.sh_degree = 0;
    result.origin_in_world_m = centre_m;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d normal = direction(i);
      Splat splat;
      splat.centre_m = (radius_m * normal).cast<float>();
      const auto along = static_cast<float>(std::log(scale_m));
      splat.log_scale = {along, along, along - std::log(10.0f)};
      const auto turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal);
      splat.rotation_wxyz = Eigen::Vector4d(turn.w(), turn.x(), turn.y(), turn.z()).cast<float>();
      splat.opacity_logit = opacity_logit;
      splat.sh_dc = {1.0f, 0.0f, -1.0f};
      result.splats.push_back(splat);
    }
    return result;
  }
  Eigen::Vector3d direction(int i) const {
    const double z = 1 - (2 * i + 1) / static_cast<double>(count);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }
  /// Cameras all around, looking at the ball, which fills about two thirds of the image.
  std::vector<SplatViewpoint> viewpoints(int views = 16) const {
    std::vector<SplatViewpoint> result;
    const SphereSplats around{.count = views};
    const Camera camera{
        .width_px = 160, .height_px = 150, .fx_px = 250, .fy_px = 250, .cx_px = 79, .cy_px = 76};
    for (int i = 0; i < views; ++i) {
      const Eigen::Vector3d eye_m = centre_m + 0.5 * around.direction(i);
      result.push_back({camera, look_at(eye_m, centre_m, Eigen::Vector3d(0.3, 0.5, 0.8))});
    }
    return result;
  }
};

}  // namespace cousin
