#include "sim/types/spline_lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "sim/types/camera.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

SplineLens random_spline(int order, double bend, Rng rng) {
  SplineLens lens{.order = order, .columns = 14, .rows = 11, .fov_x_rad = 2.4, .delta_u = {}};
  for (int i = 0; i < 2 * lens.columns * lens.rows; ++i) {
    lens.delta_u.push_back(bend * uniform(rng, -1, 1));
  }
  return lens;
}

Camera fish_eye(const SplineLens& spline) {
  Camera camera{LensModel::splined_stereographic, 1280, 720, 600, 610, 642.3, 357.1, {}, {}};
  camera.spline = spline;
  return camera;
}

class SplineOrder : public testing::TestWithParam<int> {};

TEST_P(SplineOrder, ReproducesAPlaneThroughItsControlPointsExactly) {
  // B-splines of any order have linear precision: control values a + b u give a + b u.
  SplineLens lens{.order = GetParam(), .columns = 9, .rows = 7, .fov_x_rad = 2, .delta_u = {}};
  const int margin = lens.order == 2 ? 1 : 2;
  const double step = 4 * std::tan(0.5) / (lens.columns - 1 - margin);
  for (int j = 0; j < lens.rows; ++j) {
    for (int i = 0; i < lens.columns; ++i) {
      lens.delta_u.push_back(0.01 + 0.02 * step * (i - 4));
      lens.delta_u.push_back(-0.03 * step * (j - 3));
    }
  }
  EXPECT_NEAR(half_extent(lens).x(), 2 * std::tan(0.5), 1e-15);
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d u =
        half_extent(lens).cwiseProduct(Eigen::Vector2d(uniform(rng, -1, 1), uniform(rng, -1, 1)));
    const auto at = bent(lens, u);
    ASSERT_TRUE(at);
    EXPECT_LT((at->value - Eigen::Vector2d(0.01 + 1.02 * u.x(), 0.97 * u.y())).norm(), 1e-14);
    EXPECT_LT((at->d_u - Eigen::Vector2d(1.02, 0.97).asDiagonal().toDenseMatrix()).norm(), 1e-13);
  }
}

TEST_P(SplineOrder, JoinsItsPiecesWithoutAStepInValueOrSlope) {
  const SplineLens lens = random_spline(GetParam(), 0.05, Rng(3));
  const double step = 2 * half_extent(lens).x() / (lens.columns - 2 - (GetParam() == 2 ? 0 : 1));
  constexpr double kNear = 1e-9;
  for (double knot = -1.5; knot <= 1.5; knot += 0.5) {  // cubics join at knots, quadratics between
    const auto below = bent(lens, {step * (knot - kNear), 0.1});
    const auto above = bent(lens, {step * (knot + kNear), 0.1});
    ASSERT_TRUE(below && above);
    // A smooth surface moves by slope times 2e-9; a step of the control values would be 0.05.
    EXPECT_LT((above->value - below->value).norm(), 1e-8);
    EXPECT_LT((above->d_u - below->d_u).norm(), 1e-7);
  }
}

TEST_P(SplineOrder, UnbentInvertsBentWhereTheMapDoesNotFold) {
  const SplineLens lens = random_spline(GetParam(), 0.02, Rng(5));
  Rng rng(2);
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector2d u =
        half_extent(lens).cwiseProduct(Eigen::Vector2d(uniform(rng, -1, 1), uniform(rng, -1, 1)));
    const auto back = unbent(lens, bent(lens, u)->value);
    ASSERT_TRUE(back);
    EXPECT_LT((*back - u).norm(), 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, SplineOrder, testing::Values(2, 3),
                         [](const auto& test) { return "Order" + std::to_string(test.param); });

TEST(SplineLens, GivesNothingWhereTheSurfaceDoesNotReach) {
  const Camera camera = fish_eye(random_spline(3, 0.02, Rng(1)));
  const double inside = 1.19, outside = 1.21;  // half the field of view is 1.2
  EXPECT_TRUE(project(camera, {std::sin(inside), 0, std::cos(inside)}));
  EXPECT_FALSE(project(camera, {std::sin(outside), 0, std::cos(outside)}));
  EXPECT_FALSE(project(camera, {0, 0, -1}));
  EXPECT_FALSE(project(camera, {std::numeric_limits<double>::quiet_NaN(), 0, 1}));
  EXPECT_FALSE(unproject(camera, {1e6, 0}));
}

TEST(SplineLens, ResizingKeepsTheRayOfEveryImageFraction) {
  const Camera large = fish_eye(random_spline(2, 0.02, Rng(4)));
  const Camera small = resized(large, 320, 180);
  EXPECT_EQ(small.spline, large.spline);
  for (const double fraction : {0.0, 0.3, 1.0}) {
    const auto a = unproject(large, {fraction * 1280 - 0.5, fraction * 720 - 0.5});
    const auto b = unproject(small, {fraction * 320 - 0.5, fraction * 180 - 0.5});
    ASSERT_TRUE(a && b);
    EXPECT_LT((*a - *b).norm(), 1e-12);
  }
}

TEST(SplineLens, CamerasThatDifferInOneControlPointDiffer) {
  const Camera a = fish_eye(random_spline(3, 0.02, Rng(4)));
  Camera b = a;
  EXPECT_EQ(a, b);
  b.spline.delta_u.back() += 1e-15;
  EXPECT_NE(a, b);
}

TEST(SplineLens, WithoutBendIsTheStereographicProjection) {
  SplineLens flat{.order = 3, .columns = 8, .rows = 8, .fov_x_rad = 3.6, .delta_u = {}};
  flat.delta_u.assign(128, 0);
  const Camera camera = fish_eye(flat);
  for (const double theta :
       {1e-9, 0.3, 1.0, std::numbers::pi / 2, 1.75}) {  // beyond 90 degrees too
    const auto pixel = project(camera, {0, std::sin(theta), std::cos(theta)});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->y(), 357.1 + 610 * 2 * std::tan(theta / 2), 1e-10);
  }
}

TEST(SplineLens, ASurfaceThatFoldsInsideTheImageIsRefused) {
  SplineLens spline = random_spline(3, 0, Rng(1));
  // One control point pulled by two intervals across its neighbours, near the middle.
  spline.delta_u[2 * (5 * 14 + 6)] = 0.9;
  try {
    validate(fish_eye(spline));
    FAIL() << "a folding surface was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("folds inside the image"));
  }
  // Far outside the image the same does no harm.
  spline.delta_u.assign(spline.delta_u.size(), 0);
  spline.delta_u[2 * (10 * 14)] = 0.9;
  EXPECT_NO_THROW(validate(fish_eye(spline)));
}

TEST(SplineLens, ASurfaceTooSmallForTheImageIsRefused) {
  SplineLens spline = random_spline(3, 0, Rng(1));
  spline.fov_x_rad = 1;
  EXPECT_THROW(validate(fish_eye(spline)), std::invalid_argument);
}

TEST(SplineLens, RefusesNumbersThatCannotBe) {
  const auto message = [](auto change) {
    Camera camera = fish_eye(random_spline(3, 0.01, Rng(1)));
    change(camera.spline);
    try {
      validate(camera);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  using testing::HasSubstr;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message([](SplineLens& s) { s.order = 4; }), HasSubstr("order = 4"));
  EXPECT_THAT(message([](SplineLens& s) { s.columns = 3; }), HasSubstr("columns = 3"));
  EXPECT_THAT(message([](SplineLens& s) { s.rows = 1 << 30; }), HasSubstr("rows = 1073741824"));
  EXPECT_THAT(message([](SplineLens& s) { s.columns = s.rows = 1024; }), HasSubstr("above 16384"));
  EXPECT_THAT(message([](SplineLens& s) { s.fov_x_rad = 6.3; }), HasSubstr("fov_x_rad = 6.2"));
  EXPECT_THAT(message([&](SplineLens& s) { s.fov_x_rad = nan; }), HasSubstr("fov_x_rad"));
  EXPECT_THAT(message([](SplineLens& s) { s.delta_u.pop_back(); }), HasSubstr("length"));
  EXPECT_THAT(message([&](SplineLens& s) { s.delta_u[7] = nan; }), HasSubstr("delta_u"));

  Camera pinhole{LensModel::pinhole, 64, 48, 50, 50, 32, 24, {}, {}};
  pinhole.spline.columns = 8;
  EXPECT_THROW(validate(pinhole), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
