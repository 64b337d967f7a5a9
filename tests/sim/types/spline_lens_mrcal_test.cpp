// Our splined lens beside the library that defines it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/rng.h"

extern "C" {
#include <mrcal/mrcal.h>
}

namespace cousin {
namespace {

/// A lens as both see it: random knots, whole degrees, since mrcal's names hold no others.
struct Pair {
  Camera ours;
  mrcal_lensmodel_t model{};
  std::vector<double> intrinsics;
};

Pair random_lens(int order, Rng rng) {
  Pair pair;
  const auto whole = [&](int low, int high) {
    return low + static_cast<int>(uniform_index(rng, static_cast<std::uint64_t>(high - low + 1)));
  };
  const int columns = whole(order + 2, 30), rows = whole(order + 2, 20), degrees = whole(30, 200);
  const std::string name = "LENSMODEL_SPLINED_STEREOGRAPHIC_order=" + std::to_string(order) +
                           "_Nx=" + std::to_string(columns) + "_Ny=" + std::to_string(rows) +
                           "_fov_x_deg=" + std::to_string(degrees);
  EXPECT_TRUE(mrcal_lensmodel_from_name(&pair.model, name.c_str())) << name;
  pair.ours.model = LensModel::splined_stereographic;
  pair.ours.width_px = 4000;
  pair.ours.height_px = 3000;
  pair.ours.fx_px = uniform(rng, 500, 3000);
  pair.ours.fy_px = uniform(rng, 500, 3000);
  pair.ours.cx_px = uniform(rng, 1500, 2500);
  pair.ours.cy_px = uniform(rng, 1000, 2000);
  pair.ours.spline = {order, columns, rows, degrees * std::numbers::pi / 180, {}};
  for (int i = 0; i < 2 * columns * rows; ++i) {
    pair.ours.spline.delta_u.push_back(uniform(rng, -0.1, 0.1));
  }
  pair.intrinsics = {pair.ours.fx_px, pair.ours.fy_px, pair.ours.cx_px, pair.ours.cy_px};
  pair.intrinsics.insert(pair.intrinsics.end(), pair.ours.spline.delta_u.begin(),
                         pair.ours.spline.delta_u.end());
  EXPECT_EQ(mrcal_lensmodel_num_params(&pair.model), static_cast<int>(pair.intrinsics.size()));
  return pair;
}

class MrcalOrder : public testing::TestWithParam<int> {};

TEST_P(MrcalOrder, ProjectsAndDerivesAsMrcalDoes) {
  Rng rng(11);
  double largest_px = 0, largest_slope = 0;
  int points = 0;
  for (std::uint64_t lens = 0; lens < 100; ++lens) {
    const Pair pair = random_lens(GetParam(), rng.fork(lens));
    const Eigen::Vector2d extent = half_extent(pair.ours.spline);
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector2d u =
          extent.cwiseProduct(Eigen::Vector2d(uniform(rng, -1, 1), uniform(rng, -1, 1)));
      const Eigen::Vector3d point = uniform(rng, 0.1, 10) * direction_of_stereographic(u);
      // Beside straight behind, where |p| + z of the reference loses its digits.
      if (point.z() < -0.9 * point.norm()) continue;
      const auto ours = project_with_jacobian(pair.ours, point);
      ASSERT_TRUE(ours);
      mrcal_point3_t p, slope[2];
      p.x = point.x(), p.y = point.y(), p.z = point.z();
      mrcal_point2_t q;
      ASSERT_TRUE(mrcal_project(&q, slope, nullptr, &p, 1, &pair.model, pair.intrinsics.data()));
      largest_px = std::max(largest_px, (ours->pixel_px - Eigen::Vector2d(q.x, q.y)).norm());
      for (int row = 0; row < 2; ++row) {
        const Eigen::Vector3d d(slope[row].x, slope[row].y, slope[row].z);
        largest_slope = std::max(largest_slope,
                                 (ours->d_point.row(row).transpose() - d).norm() / (1 + d.norm()));
      }
      ++points;
    }
  }
  EXPECT_GT(points, 90000);
  EXPECT_LT(largest_px, 1e-9);     // the project's demand; both work in double at 1e4 px
  EXPECT_LT(largest_slope, 1e-9);  // relative
  std::printf("order %d: %d points, largest difference %.2g px\n", GetParam(), points, largest_px);
}

TEST_P(MrcalOrder, UnprojectsToWhatMrcalProjectsBack) {
  Rng rng(12);
  for (std::uint64_t lens = 0; lens < 20; ++lens) {
    Pair pair = random_lens(GetParam(), rng.fork(lens));
    // Gentle bends only, so that each pixel has one direction.
    const double knot = 2 * half_extent(pair.ours.spline).x() / pair.ours.spline.columns;
    for (std::size_t i = 0; i < pair.ours.spline.delta_u.size(); ++i) {
      pair.intrinsics[4 + i] = pair.ours.spline.delta_u[i] *= knot;
    }
    const Eigen::Vector2d extent = half_extent(pair.ours.spline);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d u =
          extent.cwiseProduct(Eigen::Vector2d(uniform(rng, -0.8, 0.8), uniform(rng, -0.8, 0.8)));
      const auto pixel = project(pair.ours, direction_of_stereographic(u));
      ASSERT_TRUE(pixel);
      const auto ray = unproject(pair.ours, *pixel);
      ASSERT_TRUE(ray);
      mrcal_point3_t p;
      p.x = ray->x(), p.y = ray->y(), p.z = ray->z();
      mrcal_point2_t q;
      ASSERT_TRUE(mrcal_project(&q, nullptr, nullptr, &p, 1, &pair.model, pair.intrinsics.data()));
      EXPECT_LT((*pixel - Eigen::Vector2d(q.x, q.y)).norm(), 1e-9);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, MrcalOrder, testing::Values(2, 3),
                         [](const auto& test) { return "Order" + std::to_string(test.param); });

}  // namespace
}  // namespace cousin
