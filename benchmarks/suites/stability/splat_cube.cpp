#include "benchmarks/suites/stability/splat_cube.h"

#include <cmath>

#include "sim/types/rng.h"

namespace cousin {

SplatModel cube_of_splats() {
  SplatModel model;
  model.splats.resize(400);
  Rng rng = Rng(1).fork("splat cases");
  for (Splat& s : model.splats) {
    for (int k = 0; k < 3; ++k) {
      s.centre_m[k] = static_cast<float>(uniform(rng, -0.5, 0.5));
      s.log_scale[k] = static_cast<float>(std::log(0.06) + 0.7 * normal(rng));
      s.sh_dc[static_cast<std::size_t>(k)] = static_cast<float>(0.8 * normal(rng));
    }
    for (int k = 0; k < 4; ++k) s.rotation_wxyz[k] = static_cast<float>(normal(rng));
    s.opacity_logit = static_cast<float>(0.5 + normal(rng));
    for (float& c : s.sh_rest) c = static_cast<float>(0.2 * normal(rng));
  }
  return model;
}

Camera cube_camera() {
  Camera camera;
  camera.width_px = 108;
  camera.height_px = 75;
  camera.fx_px = 100;
  camera.fy_px = 97;
  camera.cx_px = 52.7;
  camera.cy_px = 37.9;
  return camera;
}

Pose view_of_cube() { return look_at({1.3, -0.9, 0.7}, {0, 0, 0}); }

Pose ring_pose(int i, int views) {
  const double turn = 2 * M_PI * i / views;
  return look_at({1.5 * std::cos(turn), 1.5 * std::sin(turn), 0.7}, {0, 0, 0});
}

}  // namespace cousin
