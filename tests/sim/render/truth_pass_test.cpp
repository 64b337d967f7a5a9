#include "sim/render/truth_pass.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

constexpr std::array<LensModel, 6> kLenses = {
    LensModel::pinhole,  LensModel::opencv5,         LensModel::opencv8,
    LensModel::opencv12, LensModel::kannala_brandt4, LensModel::splined_stereographic};

TEST(TruthPass, PlaneHasClosedFormDepthThroughEveryLens) {
  for (const LensModel model : kLenses) {
    Scene scene;
    add(scene, square(5), matt(0.5F));
    const RayScene rays(scene);
    const TrueView view =
        view_from(strong_lens(model, 200, 150, 180), {0.4, -0.3, 0.5}, {0.1, 0.1, 0});
    const TruthImages truth =
        render_truth(rays, scene, view, {.depth = true, .normal = true, .position = true});
    const Eigen::Matrix3d r = view.camera_from_world.rotation.toRotationMatrix();
    const Eigen::Vector3d eye = centre_in_world_m(view.camera_from_world);
    for (int y = 0; y < 150; y += 7) {
      for (int x = 0; x < 200; x += 7) {
        const auto d = unproject(view.camera, {x, y});
        ASSERT_TRUE(d);
        const Eigen::Vector3d world = r.transpose() * *d;
        const double t = -eye.z() / world.z();
        const Eigen::Vector3d p = eye + t * world;
        if (!(t > 0) || p.head<2>().cwiseAbs().maxCoeff() > 4.9) continue;
        // The pixel's direction is within 1e-6 px; float output rounds at 6e-8.
        EXPECT_NEAR(truth.depth_m(x, y) / (t * d->z()), 1, 2e-7)
            << to_string(model) << x << "," << y;
        EXPECT_LT((truth.normal(x, y).cast<double>() - r.col(2)).norm(), 2e-7);
        EXPECT_LT((truth.position_m(x, y).cast<double>() - p).norm(), 2e-7 * p.norm());
      }
    }
  }
}

TEST(TruthPass, SphereIsFoundWithinItsFacetsOnly) {
  Scene scene;
  add(scene, ellipsoid({1, 1, 1}, 64), matt(0.5F), {}, true);
  const RayScene rays(scene);
  const TrueView view =
      view_from(strong_lens(LensModel::kannala_brandt4, 120, 100, 80), {0.5, -2.5, 1}, {0, 0, 0});
  const TruthImages truth = render_truth(rays, scene, view, {.position = true, .instance = true});
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 120; ++x) {
      if (truth.instance(x, y) < 0) continue;
      const double radius = static_cast<double>(truth.position_m(x, y).norm());
      // Half the diagonal of a cell is at most 1.1 degrees; the facet's middle lies 1 - cos of that
      // inside.
      EXPECT_LT(radius, 1 + 1e-6);
      EXPECT_GT(radius, 1 - 2e-4);
    }
  }
}

TEST(TruthPass, PixelWithoutRayOrSurfaceIsNone) {
  Scene scene;
  add(scene, square(0.1), matt(0.5F));
  const RayScene rays(scene);
  const TrueView view =
      view_from(strong_lens(LensModel::pinhole, 64, 48, 50), {0, -0.4, 0.5}, {0, 0, 0});
  const TruthImages truth = render_truth(
      rays, scene, view,
      {.depth = true, .normal = true, .position = true, .instance = true, .part = true});
  EXPECT_TRUE(std::isnan(truth.depth_m(0, 0)));
  EXPECT_TRUE(truth.normal(0, 0).isZero(0));
  EXPECT_TRUE(std::isnan(truth.position_m(0, 0).x()));
  EXPECT_EQ(truth.instance(0, 0), -1);
  EXPECT_EQ(truth.part(0, 0), 65535);
  EXPECT_EQ(truth.part(32, 24), 0);
}

TEST(TruthPass, ThePartIsThatOfTheTriangleSeen) {
  Scene scene;
  ObjectModel halves = square(0.1);  // two triangles, parts 2 and 5
  halves.part_names = {"a", "b", "c", "d", "e", "f"};
  halves.triangle_part = {2, 5};
  const Mesh mesh = halves.mesh;
  add(scene, halves, matt(0.5F));
  const RayScene rays(scene);
  const TrueView view =
      view_from(strong_lens(LensModel::pinhole, 64, 48, 100), {0, -0.1, 0.5}, {0, 0, 0});
  const TruthImages truth = render_truth(rays, scene, view, {.part = true});
  for (std::size_t t = 0; t < 2; ++t) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const std::uint32_t i : mesh.triangles[t]) middle += mesh.vertices_m[i] / 3;
    const auto pixel = project(view.camera, view.camera_from_world * middle);
    ASSERT_TRUE(pixel);
    EXPECT_EQ(truth.part(static_cast<int>(std::lround(pixel->x())),
                         static_cast<int>(std::lround(pixel->y()))),
              t == 0 ? 2 : 5);
  }
}

TEST(TruthPass, OccludedSphereKeepsItsFullMask) {
  // Two spheres in a row: the back one is seen as a disk less the front one's disk.
  Scene scene;
  Pose back;
  back.translation_m = {0.4, 3, 0};
  const int front_id = add(scene, ellipsoid({0.5, 0.5, 0.5}, 48), matt(0.5F), {}, true);
  const int back_id = add(scene, ellipsoid({0.8, 0.8, 0.8}, 48), matt(0.5F), back, true);
  const RayScene rays(scene);
  const TrueView view =
      view_from(strong_lens(LensModel::opencv5, 400, 300, 400), {0, -3, 0}, {0, 0, 0});
  const TruthImages truth = render_truth(rays, scene, view, {.visibility = true});
  ASSERT_EQ(truth.visibility.size(), 2U);
  std::array<std::int64_t, 2> full{};
  std::int64_t visible_back = 0;
  const Eigen::Matrix3d r = view.camera_from_world.rotation.toRotationMatrix();
  const auto meets = [&](const Eigen::Vector3d& d, const Eigen::Vector3d& centre, double radius) {
    const Eigen::Vector3d to = centre - Eigen::Vector3d(0, -3, 0);
    return (to - to.dot(d) * d).norm() < radius;
  };
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) {
      const Eigen::Vector3d d = r.transpose() * unproject(view.camera, {x, y}).value();
      const bool front = meets(d, {0, 0, 0}, 0.5), behind = meets(d, back.translation_m, 0.8);
      full[0] += front ? 1 : 0;
      full[1] += behind ? 1 : 0;
      visible_back += behind && !front ? 1 : 0;
    }
  }
  EXPECT_EQ(truth.visibility[0].instance, front_id);
  EXPECT_EQ(truth.visibility[1].instance, back_id);
  EXPECT_EQ(truth.visibility[0].visible_fraction, 1);
  // The facets of 48 cells a quarter turn cut 0.03 % of the disk.
  EXPECT_NEAR(static_cast<double>(truth.visibility[0].pixels_full) / static_cast<double>(full[0]),
              1, 2e-3);
  EXPECT_NEAR(static_cast<double>(truth.visibility[1].pixels_full) / static_cast<double>(full[1]),
              1, 2e-3);
  EXPECT_NEAR(
      static_cast<double>(truth.visibility[1].pixels_visible) / static_cast<double>(visible_back),
      1, 4e-3);
  const auto& v = truth.visibility[1];
  EXPECT_EQ(truth.masks_full[1](v.box_x + v.box_width / 2, v.box_y + v.box_height / 2), 255);
}

TEST(TruthPass, CoverageIsTheAreaInsideAStraightEdge) {
  // A specimen's edge at a slope of 1 : 5: the sum of coverage is the area, which centres alone
  // quantise.
  Scene scene;
  Pose turned;
  turned.rotation = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ());
  add(scene, square(0.5), matt(0.5F), turned, true);
  const RayScene rays(scene);
  Camera camera = strong_lens(LensModel::pinhole, 101, 101, 100);
  camera.fy_px = 100;
  const TrueView view = view_from(camera, {0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  const TruthImages truth =
      render_truth(rays, scene, view, {.coverage = true}, {.coverage_samples = 64});
  double area = 0;
  for (const float c : truth.specimen_coverage) area += static_cast<double>(c);
  EXPECT_NEAR(area, 50.0 * 50.0, 2.0);  // 200 edge pixels, each known to about 0.05
}

TEST(TruthPass, RollingShutterShiftsRowsByTheMotionUntilTheyAreRead) {
  Scene scene;
  add(scene, box({-0.5, -5, -0.01}, {0.5, 5, 0}), matt(0.5F));
  const RayScene rays(scene);
  Camera camera = strong_lens(LensModel::pinhole, 160, 121, 100);
  camera.cx_px = 80;
  camera.cy_px = 60;
  TrueView view = view_from(camera, {0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  view.camera_from_world_end =
      view_from(camera, {0.2, 0, 2}, {0.2, 0, 0}, Eigen::Vector3d::UnitY()).camera_from_world;
  const TruthImages truth = render_truth(rays, scene, view, {.instance = true});
  for (int y = 0; y < 121; y += 10) {
    int left = 0;
    while (truth.instance(left, y) < 0) ++left;
    // The edge x = -0.5 seen from x = 0.2 y / 120 at 2 m through 100 px.
    const double expected = 80 + 50 * (-0.5 - 0.2 * y / 120.0);
    EXPECT_NEAR(left, expected + 0.5, 0.51) << y;
  }
}

TEST(TruthPass, SameBytesOnAnyNumberOfThreads) {
  const Scene scene = table_top(4, 8);
  const TrueView view =
      view_from(strong_lens(LensModel::opencv5, 160, 120, 180), {0.07, -0.1, 0.12}, {0, 0, 0});
  std::vector<TruthImages> truths;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const RayScene rays(scene);
    truths.push_back(render_truth(rays, scene, view,
                                  {.normal = true,
                                   .position = false,
                                   .instance = true,
                                   .coverage = true,
                                   .visibility = true}));
  }
  for (std::size_t i = 1; i < truths.size(); ++i) {
    EXPECT_EQ(truths[0].instance, truths[i].instance);
    EXPECT_EQ(truths[0].normal, truths[i].normal);
    EXPECT_EQ(truths[0].specimen_coverage, truths[i].specimen_coverage);
    EXPECT_EQ(truths[0].masks_full, truths[i].masks_full);
  }
}

TEST(TruthPass, RefusesAnotherViewsRaysAndOddSampleCounts) {
  const Scene scene = table_top(1, 3);
  const RayScene rays(scene);
  const TrueView view =
      view_from(strong_lens(LensModel::pinhole, 32, 24, 30), {0.1, -0.1, 0.1}, {0, 0, 0});
  const TrueView other =
      view_from(strong_lens(LensModel::pinhole, 30, 24, 30), {0.1, -0.1, 0.1}, {0, 0, 0});
  EXPECT_THROW(render_truth(rays, scene, other, prepare_rays(rays, view), {.depth = true}),
               std::invalid_argument);
  EXPECT_THROW(render_truth(rays, scene, view, {.coverage = true}, {.coverage_samples = 15}),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin::test
