#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes/seeds/setting.h"
#include "sim/types/camera.h"

namespace cousin {
namespace {

Camera phone_720p() {
  Camera camera;
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.fx_px = camera.fy_px = 0.84375 * 1280;
  camera.cx_px = 639.5;
  camera.cy_px = 359.5;
  return camera;
}

TEST(CameraPath, KeepsTheDistancesAndSeesTheWholePlate) {
  SeedsSceneConfig config;
  config.views = 270;
  const Camera camera = phone_720p();
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (const View& view : camera_path(config, Rng(seed))) {
      const double distance_m = centre_in_world_m(view.rig_from_world).norm();
      EXPECT_GE(distance_m, config.distance_min_m - 1e-9);
      EXPECT_LE(distance_m, config.distance_max_m + 1e-9);
      for (const double x : {-0.05, 0.05}) {
        for (const double y : {-0.05, 0.05}) {
          const auto pixel = project(camera, view.rig_from_world * Eigen::Vector3d(x, y, 0));
          ASSERT_TRUE(pixel.has_value());
          EXPECT_TRUE(pixel->x() > 0 && pixel->x() < 1279 && pixel->y() > 0 && pixel->y() < 719)
              << "corner at " << pixel->transpose();
        }
      }
    }
  }
}

TEST(CameraPath, RingsShareTheViewsAndGoAllTheWayRound) {
  SeedsSceneConfig config;
  config.views = 60;
  const std::vector<View> views = camera_path(config, Rng(1));
  ASSERT_EQ(views.size(), 60U);
  for (int ring = 0; ring < 3; ++ring) {
    double elevation = 0;
    double widest_gap = 0;
    double before = 0;
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d eye =
          centre_in_world_m(views[static_cast<std::size_t>(20 * ring + i)].rig_from_world);
      elevation += std::asin(eye.z() / eye.norm()) / 20;
      const double azimuth = std::atan2(eye.y(), eye.x());
      if (i > 0)
        widest_gap =
            std::max(widest_gap, std::abs(std::remainder(azimuth - before, 2 * std::numbers::pi)));
      before = azimuth;
    }
    EXPECT_NEAR(elevation, config.ring_elevations_rad[static_cast<std::size_t>(ring)], 0.05);
    EXPECT_LT(widest_gap,
              2 * std::numbers::pi / 20 + 0.25);  // the step of the ring plus hand-held wander
  }
}

TEST(CameraPath, FewViewsSpreadOverTheRings) {
  SeedsSceneConfig config;
  for (const int count : {1, 2, 3, 4, 10}) {
    config.views = count;
    EXPECT_EQ(camera_path(config, Rng(1)).size(), static_cast<std::size_t>(count));
  }
}

TEST(CameraPath, RepeatsForTheSameSeed) {
  const SeedsSceneConfig config;
  const std::vector<View> a = camera_path(config, Rng(3));
  const std::vector<View> b = camera_path(config, Rng(3));
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].rig_from_world.translation_m, b[i].rig_from_world.translation_m);
  }
}

}  // namespace
}  // namespace cousin
