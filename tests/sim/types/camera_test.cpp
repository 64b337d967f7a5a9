#include "sim/types/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "sim/types/rng.h"

namespace cousin {
namespace {

Camera camera_of(LensModel model) {
  Camera camera{model, 1280, 720, 1083.0, 1079.0, 642.3, 357.1, {}, {}};
  switch (model) {
    case LensModel::pinhole:
      break;
    case LensModel::opencv5:
      camera.distortion = {0.05, -0.08, 4e-4, -3e-4, 0.02};
      break;
    case LensModel::opencv8:
      camera.distortion = {0.3, 0.02, 4e-4, -3e-4, 0.001, 0.28, 0.03, 0.002};
      break;
    case LensModel::opencv12:
      camera.distortion = {0.3,  0.02,  4e-4, -3e-4, 0.001, 0.28,
                           0.03, 0.002, 1e-3, -2e-4, -8e-4, 1e-4};
      break;
    case LensModel::kannala_brandt4:
      camera.distortion = {0.02, -0.006, 0.001, -0.0002};
      break;
    case LensModel::splined_stereographic:
      camera.spline = {.order = 3, .columns = 12, .rows = 9, .fov_x_rad = 1.6, .delta_u = {}};
      for (int i = 0; i < 2 * 12 * 9; ++i) camera.spline.delta_u.push_back(0.01 * std::sin(i * i));
      break;
  }
  return camera;
}

class EveryLens : public testing::TestWithParam<LensModel> {};

TEST_P(EveryLens, UnprojectInvertsProjectAllOverTheImage) {
  const Camera camera = camera_of(GetParam());
  validate(camera);
  Rng rng(1);
  for (int i = 0; i < 10000; ++i) {
    const Eigen::Vector2d pixel(uniform(rng, -0.5, 1279.5), uniform(rng, -0.5, 719.5));
    const auto direction = unproject(camera, pixel);
    ASSERT_TRUE(direction);
    EXPECT_NEAR(direction->norm(), 1, 1e-12);
    const auto back = project(camera, *direction * uniform(rng, 0.1, 10));
    ASSERT_TRUE(back);
    // unproject promises 1e-9 of the focal length; its last Newton step is quadratic, far below
    // that.
    EXPECT_LT((*back - pixel).norm(), 1e-9);
  }
}

TEST_P(EveryLens, JacobianMatchesCentralDifferences) {
  const Camera camera = camera_of(GetParam());
  Rng rng(2);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d point(uniform(rng, -0.2, 0.2), uniform(rng, -0.12, 0.12),
                                uniform(rng, 0.4, 1));
    const auto value = project_with_jacobian(camera, point);
    ASSERT_TRUE(value);
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kStep = 1e-6;  // truncation h^2, rounding 1e-13 / h: both near 1e-7 relative
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector2d numeric =
          (*project(camera, point + d) - *project(camera, point - d)) / (2 * kStep);
      EXPECT_LT((numeric - value->d_point.col(axis)).norm(), 1e-4 * (1 + numeric.norm()));
    }
  }
}

TEST_P(EveryLens, PreparedForManyPointsGivesTheSameBits) {
  const Camera camera = camera_of(GetParam());
  const Lens lens(camera);
  EXPECT_EQ(lens.monotone_limit(), monotone_limit(camera));
  Rng rng(3);
  int seen = 0, beyond = 0;
  for (int i = 0; i < 2000; ++i) {  // also far outside the image, where some lenses give nothing
    const Eigen::Vector3d point(uniform(rng, -4, 4), uniform(rng, -4, 4), uniform(rng, -0.5, 1.5));
    const Eigen::Vector2d pixel(uniform(rng, -3e3, 4e3), uniform(rng, -3e3, 4e3));
    EXPECT_EQ(lens.project(point), project(camera, point));
    EXPECT_EQ(lens.unproject(pixel), unproject(camera, pixel));
    ++(lens.project(point) ? seen : beyond);
  }
  EXPECT_GT(seen, 10);
  EXPECT_GT(beyond, 0);
}

TEST_P(EveryLens, NamesRoundTrip) {
  EXPECT_EQ(lens_model_from_string(to_string(GetParam())), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Lens, EveryLens,
                         testing::Values(LensModel::pinhole, LensModel::opencv5, LensModel::opencv8,
                                         LensModel::opencv12, LensModel::kannala_brandt4,
                                         LensModel::splined_stereographic),
                         [](const auto& test) { return std::string(to_string(test.param)); });

TEST(Camera, ProjectsAsTheOpenCvDocumentationSays) {
  // Hand evaluation at x = 0.2, y = -0.1: r2 = 0.05, radial 1 + 0.05 k1, tangential and prism terms
  // apart.
  Camera camera{LensModel::opencv12, 100, 100, 1, 1, 0, 0, {}, {}};
  camera.distortion = {0.1, 0, 0.01, 0.02, 0, 0, 0, 0, 0.03, 0, 0.04, 0};
  const auto pixel = project(camera, {0.2, -0.1, 1});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 0.2 * 1.005 + 2 * 0.01 * 0.2 * -0.1 + 0.02 * (0.05 + 0.08) + 0.03 * 0.05,
              1e-15);
  EXPECT_NEAR(pixel->y(), -0.1 * 1.005 + 0.01 * (0.05 + 0.02) + 2 * 0.02 * 0.2 * -0.1 + 0.04 * 0.05,
              1e-15);
}

TEST(Camera, RefusesALensThatFoldsInsideTheImage) {
  Camera camera = camera_of(LensModel::opencv5);
  camera.distortion = {-0.9, 0, 0, 0,
                       0};  // r (1 - 0.9 r2) turns at r = 0.61; the corner is at 0.68
  try {
    validate(camera);
    FAIL() << "a folding lens was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("folds inside the image"), std::string::npos)
        << error.what();
  }
  EXPECT_NEAR(monotone_limit(camera), std::sqrt(1 / 2.7), 1e-6);
}

TEST(Camera, GivesNothingBeyondTheFold) {
  Camera camera = camera_of(LensModel::opencv5);
  camera.distortion = {-0.9, 0, 0, 0, 0};
  EXPECT_FALSE(project(camera, {0.9, 0, 1}));
  EXPECT_FALSE(project(camera, {0.1, 0, -1}));
  EXPECT_FALSE(project(camera, {0.1, std::numeric_limits<double>::quiet_NaN(), 1}));
}

TEST(Camera, RefusesNumbersThatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](auto change, const char* field) {
    Camera camera = camera_of(LensModel::opencv5);
    change(camera);
    try {
      validate(camera);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what()).find(field) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused([&](Camera& c) { c.fx_px = nan; }, "fx_px"));
  EXPECT_TRUE(refused([](Camera& c) { c.fy_px = 0; }, "fy_px"));
  EXPECT_TRUE(refused([](Camera& c) { c.width_px = 0; }, "width_px"));
  EXPECT_TRUE(refused([](Camera& c) { c.height_px = 70000; }, "height_px"));
  EXPECT_TRUE(refused([](Camera& c) { c.cx_px = 1e9; }, "cx_px"));
  EXPECT_TRUE(refused([&](Camera& c) { c.distortion[1] = nan; }, "distortion[1]"));
  EXPECT_TRUE(refused([](Camera& c) { c.distortion[7] = 0.1; }, "distortion[7]"));
}

TEST(Camera, ResizingKeepsTheRayOfEveryImageFraction) {
  const Camera large = camera_of(LensModel::opencv5);
  const Camera small = resized(large, 640, 360);
  for (const double fraction : {0.0, 0.3, 1.0}) {
    const auto a = unproject(large, {fraction * 1280 - 0.5, fraction * 720 - 0.5});
    const auto b = unproject(small, {fraction * 640 - 0.5, fraction * 360 - 0.5});
    ASSERT_TRUE(a && b);
    EXPECT_LT((*a - *b).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace cousin
