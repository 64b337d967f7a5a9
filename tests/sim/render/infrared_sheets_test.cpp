#include <gtest/gtest.h>

#include "sim/render/infrared_pass.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

/// Mean radiance of the lower of two leaves of 0.1 m, `gap_m` apart and `away_m` from the scene's
/// centre, seen from below in a sun that stands above; `covered`: the upper one lets nothing
/// through.
double seen_from_below(double gap_m, double away_m, bool covered) {
  Scene scene;
  Material leaf = matt(0.3F);
  leaf.infrared_albedo = 0.3F;
  leaf.infrared_transmittance = 0.5F;
  const auto place = [&](double half_m, double x_m, double z_m) {
    Pose pose;
    pose.translation_m = {x_m, 0, z_m};
    add(scene, square(half_m), leaf, pose);
  };
  place(0.05, away_m, 0);
  if (covered) place(0.05, away_m, gap_m);
  place(1e-3, -away_m, 0);  // the scene's centre is half-way
  scene.lights.emplace_back(Sun{Eigen::Vector3d::UnitZ(), 0.005, {3, 3, 3}});
  Camera camera;
  camera.width_px = camera.height_px = 24;
  camera.fx_px = camera.fy_px = 40;
  camera.cx_px = camera.cy_px = 11.5;
  const TrueView view =
      view_from(camera, {away_m, 0, -0.02}, {away_m, 0, 0}, Eigen::Vector3d::UnitY());
  const InfraredImage image = render_infrared(RayScene(scene), scene, view, {}, {}, Rng(1));
  double sum = 0;
  for (const float v : image.radiance) sum += static_cast<double>(v);
  return sum / static_cast<double>(image.radiance.size());
}

TEST(InfraredPass, ALeafIsShadedByOneCloseAboveItFarFromTheScenesCentre) {
  for (const double away_m : {1.0, 100.0}) {
    EXPECT_GT(seen_from_below(2e-4, away_m, false), 0.1);
    // Rays start 25 um off a surface there, well within the gap.
    EXPECT_EQ(seen_from_below(2e-4, away_m, true), 0) << away_m;
  }
}

}  // namespace
}  // namespace cousin::test
