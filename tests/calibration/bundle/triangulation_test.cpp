#include "calibration/bundle/triangulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

Camera camera() {
  Camera c;
  c.model = LensModel::opencv5;
  c.width_px = 1280;
  c.height_px = 720;
  c.fx_px = c.fy_px = 700;
  c.cx_px = 640;
  c.cy_px = 360;
  c.distortion = {-0.1, 0.02, 1e-3, -5e-4, 0};
  return c;
}

/// Two cameras that see a point 1 m away under `parallax_rad`.
std::vector<PointSighting> pair_of(const Vector3d& point, double parallax_rad, double sigma_px,
                                   Rng& rng) {
  std::vector<PointSighting> sightings;
  for (const double side : {-0.5, 0.5}) {
    PointSighting s;
    s.lens = camera();
    s.camera_from_world.translation_m.x() = -side * 2 * std::tan(0.5 * parallax_rad);
    s.pixel_px = *project(s.lens, s.camera_from_world * point) +
                 sigma_px * Vector2d(normal(rng), normal(rng));
    s.covariance_px2 = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
    sightings.push_back(s);
  }
  return sightings;
}

TEST(Triangulation, ExactSightingsGiveThePointThroughADistortedLens) {
  Rng rng(1);
  const Vector3d point(0.2, -0.1, 1);
  for (const double degrees : {30.0, 5.0, 0.5}) {
    auto sightings = pair_of(point, degrees * kDegree, 0, rng);
    for (PointSighting& s : sightings) s.covariance_px2 = 1e-4 * Eigen::Matrix2d::Identity();
    const Triangulation found = triangulate(sightings);
    ASSERT_EQ(found.status, TriangulationStatus::ok) << degrees;
    EXPECT_LT((found.in_world_m - point).norm(), 1e-9 / degrees) << degrees;
  }
}

TEST(Triangulation, ErrorsAreAsLargeAsPredictedFromTenDegreesToAHundredth) {
  const Vector3d point(0.1, 0.05, 1);
  for (const double degrees : {10.0, 1.0, 0.1, 0.01}) {
    Rng rng = Rng(2).fork("pairs");
    // So little noise that the depth is told from infinity at the smallest angle, too.
    const double sigma_px = 0.05 * std::min(1.0, degrees / 0.5) * 0.2;
    std::vector<double> normalised;
    for (int i = 0; i < 400; ++i) {
      const Triangulation found = triangulate(pair_of(point, degrees * kDegree, sigma_px, rng));
      ASSERT_EQ(found.status, TriangulationStatus::ok) << degrees;
      normalised.push_back(std::abs(found.in_world_m.z() - 1) /
                           std::sqrt(found.covariance_m2(2, 2)));
    }
    std::sort(normalised.begin(), normalised.end());
    // Of |normal|: .674 and 1.96; 400 draws tell the first to .06, the second to .15 (2 sigmas).
    EXPECT_NEAR(normalised[200], 0.674, 0.09) << degrees;
    EXPECT_NEAR(normalised[380], 1.96, 0.3) << degrees;
  }
}

TEST(Triangulation, SaysWhenTheRaysDoNotTellTheDistance) {
  Rng rng(3);
  const auto far = pair_of({0, 0, 1}, 1e-5, 0.3, rng);
  const Triangulation found = triangulate(far);
  EXPECT_EQ(found.status, TriangulationStatus::parallel);
  EXPECT_TRUE(std::isnan(found.in_world_m.x()));
  TriangulationConfig gate;
  gate.min_parallax_rad = 1.5 * kDegree;
  EXPECT_EQ(triangulate(pair_of({0, 0, 1}, kDegree, 0.01, rng), gate).status,
            TriangulationStatus::parallel);
}

TEST(Triangulation, SaysWhenRaysMeetBehindOrDisagree) {
  Rng rng(4);
  auto behind = pair_of({0, 0, 1}, 5 * kDegree, 0.1, rng);
  std::swap(behind[0].pixel_px, behind[1].pixel_px);
  EXPECT_EQ(triangulate(behind).status, TriangulationStatus::behind);
  auto wrong = pair_of({0, 0, 1}, 5 * kDegree, 0.1, rng);
  wrong[0].pixel_px.y() += 20;
  EXPECT_EQ(triangulate(wrong).status, TriangulationStatus::disagree);
  wrong.pop_back();
  EXPECT_EQ(triangulate(wrong).status, TriangulationStatus::too_few);
}

TEST(Triangulation, AFarOriginOfTheWorldCostsNoDigits) {
  Rng rng(5);
  auto near = pair_of({0.1, 0.2, 1}, 8 * kDegree, 0.1, rng);
  const Triangulation reference = triangulate(near);
  const Vector3d shift(1e6, -2e6, 5e5);
  for (PointSighting& s : near)
    s.camera_from_world.translation_m -= s.camera_from_world.rotation * shift;
  const Triangulation found = triangulate(near);
  ASSERT_EQ(found.status, TriangulationStatus::ok);
  // A double at 2e6 m is exact to 2e-10 m; the baseline is .14 m.
  EXPECT_LT((found.in_world_m - shift - reference.in_world_m).norm(), 1e-7);
}

}  // namespace
}  // namespace cousin
