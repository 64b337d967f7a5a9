// Writes what a sweep finds in small pictures, for tests that compare it between instruction sets.
#include <cmath>
#include <cstdio>
#include <fstream>

#include "perception/mvs/plane_sweep.h"
#include "tests/perception/mvs/synthetic_seeds.h"

int main(int argc, char** argv) {
  using namespace cousin;
  if (argc != 2) {
    std::fprintf(stderr, "Usage: sweep_bytes FILE\n");
    return 2;
  }
  SyntheticScene scene;
  scene.seeds.push_back({0.001, -0.002, {0.007, 0.006, 0.004}, 0.4});
  std::vector<Eigen::Vector3d> eyes;
  for (int i = 0; i < 6; ++i)
    eyes.emplace_back(0.1 * std::cos(0.785 * i), 0.1 * std::sin(0.785 * i), 0.30);
  const SyntheticViews views =
      make_views(scene, synthetic_camera(LensModel::opencv5, 160, 120, 800), eyes, 7);
  const SweepVolume volume = {{-0.016, -0.016, -0.002}, {0.016, 0.016, 0.012}};
  MvsConfig config;
  config.min_angle_rad = 0.05;
  config.normals = true;
  std::ofstream out(argv[1], std::ios::binary);
  std::size_t found = 0;
  for (const FrameDepth& frame : estimate_depths(views.capture, views.poses, volume, config)) {
    for (const Image<float>* image : {&frame.depth_m, &frame.sigma_m}) {
      for (const float value : *image) found += std::isfinite(value) ? 1 : 0;
      out.write(reinterpret_cast<const char*>(image->data()),
                static_cast<std::streamsize>(image->size() * sizeof(float)));
    }
    out.write(reinterpret_cast<const char*>(frame.normal.data()),
              static_cast<std::streamsize>(frame.normal.size() * sizeof(Eigen::Vector3f)));
  }
  if (found < 1000 || !out.flush()) {
    std::fprintf(stderr, "sweep_bytes: %zu values, or %s cannot be written\n", found, argv[1]);
    return 1;
  }
  return 0;
}
