#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "tests/sim/geometry/solids.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double volume(const OrientedBox& box) { return box.size_m.prod(); }

void expect_box_holds(const OrientedBox& box, const std::vector<Vector3d>& points, double slack_m) {
  EXPECT_TRUE((box.axes.transpose() * box.axes).isIdentity(1e-12));
  EXPECT_NEAR(box.axes.determinant(), 1, 1e-12);
  EXPECT_GE(box.size_m.x(), box.size_m.y());
  EXPECT_GE(box.size_m.y(), box.size_m.z());
  for (const Vector3d& p : points) {
    const Vector3d local = box.axes.transpose() * (p - box.centre_m);
    EXPECT_TRUE(((local.cwiseAbs() - 0.5 * box.size_m).array() < slack_m).all());
  }
}

/// Least volume by rotations spread at random and walked downhill by ever smaller random turns:
/// slow and independent.
double brute_force_volume(const std::vector<Vector3d>& points, Rng rng) {
  const auto volume_along = [&](const Matrix3d& axes) {
    Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Vector3d& p : points) {
      const Vector3d local = axes.transpose() * p;
      low = low.cwiseMin(local);
      high = high.cwiseMax(local);
    }
    return (high - low).prod();
  };
  struct Start {
    double volume;
    Matrix3d axes;
  };
  std::vector<Start> starts;
  for (int i = 0; i < 4000; ++i) {
    const Matrix3d axes = random_rotation(rng);
    starts.push_back({volume_along(axes), axes});
  }
  std::sort(starts.begin(), starts.end(),
            [](const Start& a, const Start& b) { return a.volume < b.volume; });
  starts.resize(60);
  double best = starts.front().volume;
  for (Start& start : starts) {
    for (double scale = 0.1; scale > 1e-6; scale *= 0.7) {
      for (int trial = 0; trial < 30; ++trial) {
        const Vector3d turn = scale * Vector3d(normal(rng), normal(rng), normal(rng));
        const Matrix3d axes = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * start.axes;
        const double v = volume_along(axes);
        if (v < start.volume) start = {v, axes};
      }
    }
    best = std::min(best, start.volume);
  }
  return best;
}

TEST(MinimumVolumeBox, RecoversABoxEvenAKilometreAway) {
  Rng rng(1);
  const Vector3d size(0.008, 0.005, 0.003);
  for (int trial = 0; trial < 20; ++trial) {
    const Vector3d centre = trial % 2 ? Vector3d(700, -500, 510) : Vector3d(0.1, 0.2, -0.3);
    const auto points = moved(box_mesh(size).vertices_m, random_rotation(rng), centre);
    const OrientedBox box = minimum_volume_box(points);
    // A kilometre away coordinates are rounded to 1e-13 m, that is 4e-11 of the shortest side.
    EXPECT_LT((box.size_m - size).norm() / size.norm(), 1e-9);
    EXPECT_LT((box.centre_m - centre).norm(), 1e-12);
    expect_box_holds(box, points, 1e-12);
  }
}

TEST(MinimumVolumeBox, RegularTetrahedronSitsInACube) {
  // No face of the tetrahedron is flush with the cube, only edges: searches over faces give 9.24.
  Rng rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    const auto points = moved(tetrahedron_mesh().vertices_m, random_rotation(rng), {1, 2, 3});
    const OrientedBox box = minimum_volume_box(points);
    EXPECT_NEAR(volume(box), 8, 1e-9);
    EXPECT_LT((box.size_m - Vector3d(2, 2, 2)).norm(), 1e-9);
  }
}

TEST(MinimumVolumeBox, EllipsoidHasItsAxes) {
  const Vector3d r(0.0045, 0.003, 0.002);
  Rng rng(3);
  const Matrix3d rotation = random_rotation(rng);
  const auto points = moved(ellipsoid_mesh(r, 5).vertices_m, rotation, {0.01, 0.02, 0.03});
  const OrientedBox box = minimum_volume_box(points);
  // The mesh holds the ends of the axes, so no smaller box than the ellipsoid's exists to the
  // mesh's sag of 6e-4.
  EXPECT_LE(volume(box), 8 * r.prod() * (1 + 1e-12));
  EXPECT_LT((box.size_m - 2 * r).cwiseQuotient(2 * r).norm(), 1e-3);
  expect_box_holds(box, points, 1e-15);
}

TEST(MinimumVolumeBox, NoRotationFoundByBruteForceIsBetter) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const Vector3d scale(1, seed % 3 == 1 ? 0.3 : 1.0, seed % 3 == 2 ? 0.1 : 0.8);
    const auto points = random_points(4 + static_cast<int>(seed), scale, Rng(seed).fork("points"));
    const OrientedBox box = minimum_volume_box(points);
    EXPECT_LE(volume(box), brute_force_volume(points, Rng(seed).fork("search")) * (1 + 1e-9))
        << seed;
    expect_box_holds(box, points, 1e-12);
  }
}

TEST(MinimumVolumeBox, TwoAdjacentSidesAreFlushWithEdges) {
  // The theorem that gives the method its creases, on the result: at least two sides touch two
  // points each.
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto points = random_points(12, {1, 0.7, 0.5}, Rng(seed));
    const OrientedBox box = minimum_volume_box(points);
    int flush_axes = 0;
    for (int k = 0; k < 3; ++k) {
      int low = 0, high = 0;
      for (const Vector3d& p : points) {
        const double x = box.axes.col(k).dot(p - box.centre_m);
        low += x < -0.5 * box.size_m[k] + 1e-7;
        high += x > 0.5 * box.size_m[k] - 1e-7;
      }
      flush_axes += low >= 2 || high >= 2;
    }
    EXPECT_GE(flush_axes, 2) << seed;
  }
}

TEST(MinimumVolumeBox, DoesNotDependOnPoseOrOrder) {
  Rng rng(5);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto points = random_points(60, {4, 3, 2}, Rng(seed));
    const OrientedBox box = minimum_volume_box(points);
    const OrientedBox other = minimum_volume_box(
        shuffled(moved(points, random_rotation(rng), {9, 8, 7}), rng.fork(seed)));
    EXPECT_NEAR(volume(other) / volume(box), 1, 1e-9);
    EXPECT_LT((other.size_m - box.size_m).norm(), 1e-6);
  }
}

TEST(MinimumVolumeBox, InnerAndRepeatedPointsChangeNothing) {
  auto points = random_points(30, {4, 3, 2}, Rng(8));
  const OrientedBox box = minimum_volume_box(points);
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back(points[i]);
    points.push_back(0.2 * points[i] + 0.3 * points[(i + 7) % count]);
  }
  EXPECT_NEAR(volume(minimum_volume_box(points)) / volume(box), 1, 1e-9);
}

TEST(MinimumVolumeBox, FromANearBoxItIsTheSame) {
  Rng rng(6);
  const auto points = moved(ellipsoid_mesh({0.0045, 0.003, 0.002}, 5).vertices_m,
                            random_rotation(rng), {0.1, 0, 0});
  const OrientedBox box = minimum_volume_box(points);
  OrientedBox near = box;
  near.axes = Eigen::AngleAxisd(0.01, Vector3d(1, 1, 1).normalized()) * near.axes;
  // A dense hull has minima side by side, whose depths differ by less than the mesh's sag of 6e-4.
  EXPECT_NEAR(volume(minimum_volume_box(points, near)) / volume(box), 1, 6e-4);
  EXPECT_NEAR(volume(minimum_volume_box(points, box)) / volume(box), 1, 1e-12);
  near.axes *= 2;
  EXPECT_THROW(minimum_volume_box(points, near), std::invalid_argument);
}

TEST(RivalBoxes, OfABlockAreMuchLarger) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i)
    points.emplace_back(i & 1 ? 3.0 : 0.0, i & 2 ? 2.0 : 0.0, i & 4 ? 1.0 : 0.0);
  const OrientedBox least = minimum_volume_box(points);
  const std::vector<OrientedBox> boxes = rival_boxes(points, least);
  ASSERT_FALSE(boxes.empty());
  EXPECT_EQ(boxes.front().size_m, least.size_m);
  for (std::size_t i = 1; i < boxes.size(); ++i) EXPECT_GT(boxes[i].size_m.prod(), 6.5);
}

TEST(RivalBoxes, ARegularOctagonHasTwo) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) {
    const double angle = (i + 0.5) * std::numbers::pi / 4;
    for (const double z : {0.0, 0.4}) points.emplace_back(std::cos(angle), std::sin(angle), z);
  }
  const std::vector<OrientedBox> boxes = rival_boxes(points, minimum_volume_box(points));
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_NEAR(boxes[1].size_m.prod(), boxes[0].size_m.prod(), 1e-9);
  const double between = std::acos(std::abs(boxes[0].axes.col(0).dot(boxes[1].axes.col(0))));
  EXPECT_NEAR(between, std::numbers::pi / 4, 1e-6);
}

TEST(MinimumVolumeBox, FlatPointsGiveZeroSizesNeverNan) {
  for (const FlatCase& c : flat_cases()) {
    for (const OrientedBox& box : {minimum_volume_box(c.points), pca_box(c.points)}) {
      EXPECT_EQ(box.size_m.z(), 0) << c.name;
      EXPECT_TRUE(box.size_m.allFinite() && box.axes.allFinite() && box.centre_m.allFinite())
          << c.name;
      expect_box_holds(box, c.points, 1e-9);
    }
  }
  const Matrix3d tilt = Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const OrientedBox square = minimum_volume_box(moved(flat_cases()[6].points, tilt, {0, 0, 0}));
  EXPECT_LT((square.size_m - Vector3d(7, 4, 0)).norm(), 1e-9);  // 5 x 8 points a unit apart
}

TEST(MinimumVolumeBox, BadPointsAreTheCallersMistake) {
  EXPECT_THROW(minimum_volume_box({}), std::invalid_argument);
  const std::vector<Vector3d> bad = {{0, 0, 0}, {1, std::numeric_limits<double>::quiet_NaN(), 0}};
  EXPECT_THROW(minimum_volume_box(bad), std::invalid_argument);
  EXPECT_THROW(pca_box(bad), std::invalid_argument);
}

TEST(PcaBox, OfABoxIsTheBoxAndOtherwiseLarger) {
  Rng rng(9);
  const Vector3d size(0.008, 0.005, 0.003);
  const auto corners = moved(box_mesh(size).vertices_m, random_rotation(rng), {1, 2, 3});
  EXPECT_LT((pca_box(corners).size_m - size).norm(), 1e-12);
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto points = random_points(30, {3, 2, 1}, Rng(seed));
    EXPECT_GE(volume(pca_box(points)), volume(minimum_volume_box(points)) * (1 - 1e-12));
    expect_box_holds(pca_box(points), points, 1e-12);
  }
}

}  // namespace
}  // namespace cousin
