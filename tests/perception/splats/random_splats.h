#pragma once

#include <cmath>
#include <vector>

#include "perception/splats/splat_model.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"
#include "sim/types/rng.h"

namespace cousin {

/// Gaussians of all shapes, turns and colours in the unit cube about zero.
inline std::vector<Splat> random_splats(int count, std::uint64_t seed, double size = 0.06) {
  std::vector<Splat> splats(static_cast<std::size_t>(count));
  Rng rng(seed);
  for (Splat& s : splats) {
    for (int k = 0; k < 3; ++k) {
      s.centre_m[k] = static_cast<float>(uniform(rng, -0.5, 0.5));
      s.log_scale[k] = static_cast<float>(std::log(size) + 0.7 * normal(rng));
      s.sh_dc[static_cast<std::size_t>(k)] = static_cast<float>(0.8 * normal(rng));
    }
    for (int k = 0; k < 4; ++k) s.rotation_wxyz[k] = static_cast<float>(normal(rng));
    s.opacity_logit = static_cast<float>(normal(rng) + 0.5);
    for (float& c : s.sh_rest) c = static_cast<float>(0.2 * normal(rng));
  }
  return splats;
}

inline Camera pinhole(int width, int height, double focal) {
  Camera camera;
  camera.width_px = width;
  camera.height_px = height;
  camera.fx_px = focal;
  camera.fy_px = 0.97 * focal;
  camera.cx_px = 0.5 * width - 1.3;
  camera.cy_px = 0.5 * height + 0.4;
  return camera;
}

inline Pose view_of_cube() { return look_at({1.3, -0.9, 0.7}, {0, 0, 0}); }

}  // namespace cousin
