#include "sim/plant/centre_line.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace cousin {
namespace {

using Eigen::Vector3d;

AxisGrowth upright(double length, int segments) {
  AxisGrowth growth;
  growth.length_m = length;
  growth.segments = segments;
  return growth;
}

TEST(CentreLine, LengthIsThatAskedForHoweverItBends) {
  AxisGrowth growth = upright(0.3, 37);
  growth.tropisms.push_back({Vector3d(1, 0.4, 0).normalized(), 1.2, 0.2});
  growth.curls.push_back({Vector3d::UnitY(), 2.0, 0.5});
  // 37 steps of one length: rounding alone.
  EXPECT_NEAR(length_m(grow_axis(growth)), 0.3, 1e-15 * 37);
}

TEST(CentreLine, AnEvenCurlIsAnArcOfACircle) {
  AxisGrowth growth = upright(0.1, 200);
  growth.curls.push_back({Vector3d::UnitY(), std::numbers::pi, 0});
  const CentreLine line = grow_axis(growth);
  // A half circle ends a diameter away, in the plane it started from. The polygon's error is of
  // second order in the step, its heading off by half a step: pi / 200 / 2 of the diameter.
  const double diameter = 2 * 0.1 / std::numbers::pi;
  EXPECT_NEAR(line.points_m.back().x(), diameter, 1e-4 * diameter);
  EXPECT_NEAR(line.points_m.back().z(), 0, diameter * std::numbers::pi / 400 * 1.01);
  EXPECT_NEAR(line.points_m.back().y(), 0, 1e-15);
}

TEST(CentreLine, TropismTurnsTowardsAndNegativeAway) {
  for (const double turn : {0.3, -0.3}) {
    AxisGrowth growth = upright(0.1, 100);
    growth.tropisms.push_back({Vector3d::UnitX(), turn, 0});
    const CentreLine line = grow_axis(growth);
    const Vector3d heading = line.points_m.back() - line.points_m[99];
    // Turned by less than `turn`, which it would be if it stayed at right angles.
    const double angle = std::atan2(heading.x(), heading.z());
    EXPECT_GT(angle * turn, 0);
    EXPECT_LT(std::abs(angle), 0.3);
    EXPECT_GT(std::abs(angle), 0.3 * std::cos(0.3));
  }
}

TEST(CentreLine, FramesAreOrthonormalAndDoNotTwistInAPlane) {
  AxisGrowth growth = upright(0.2, 50);
  growth.curls.push_back({Vector3d::UnitY(), 2.5, 0.3});
  const CentreLine line = grow_axis(growth);
  const auto frames = frames_along(line.points_m, Vector3d::UnitY());
  for (const Eigen::Matrix3d& axes : frames) {
    EXPECT_LT((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(axes.determinant(), 1, 1e-12);
    EXPECT_NEAR(axes(1, 2), 1, 1e-12);  // the normal stays across the plane of bending
  }
}

TEST(CentreLine, WalkGoesOnAlongTheTangentBeyondTheEnds) {
  const LineWalk walk(grow_axis(upright(0.1, 10)), Vector3d::UnitX());
  EXPECT_LT((walk.at_m(0.15).point_m - Vector3d(0, 0, 0.15)).norm(), 1e-12);
  EXPECT_LT((walk.at_m(-0.05).point_m - Vector3d(0, 0, -0.05)).norm(), 1e-12);
  EXPECT_LT((walk.at_share(0.234).point_m - Vector3d(0, 0, 0.0234)).norm(), 1e-12);
}

TEST(CentreLine, RefusesWhatIsNoAxis) {
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(grow_axis(upright(bad, 10)), std::invalid_argument) << bad;
    AxisGrowth thin = upright(0.1, 10);
    thin.radius_tip_m = bad;
    EXPECT_THROW(grow_axis(thin), std::invalid_argument) << bad;
  }
  EXPECT_THROW(grow_axis(upright(0.1, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
