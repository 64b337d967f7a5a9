#include "sim/geometry/surface_crossing.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <stdexcept>

#include "tests/sim/geometry/solids.h"

namespace cousin {
namespace {

/// A square sheet of cells x cells, spanned by two sides.
Mesh sheet(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
           std::uint32_t cells) {
  Mesh mesh;
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i)
      mesh.vertices_m.push_back(corner + i * u / cells + j * v / cells);
  }
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i, c = a + cells + 1;
      mesh.triangles.push_back({a, a + 1, c + 1});
      mesh.triangles.push_back({a, c + 1, c});
    }
  }
  return mesh;
}

SurfaceCrossing crossing_of(const Mesh& a, const Mesh& b, double resolution_m = 0.002) {
  std::vector<int> sheets(a.triangles.size(), 0);
  sheets.resize(a.triangles.size() + b.triangles.size(), 1);
  const Mesh both[] = {a, b};
  Mesh all = both[0];
  for (const auto& t : b.triangles) {
    const auto n = static_cast<std::uint32_t>(a.vertices_m.size());
    all.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  all.vertices_m.insert(all.vertices_m.end(), b.vertices_m.begin(), b.vertices_m.end());
  return surface_crossing(all, sheets, resolution_m);
}

const Mesh kFlat = sheet({0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, 100);

TEST(SurfaceCrossing, OfTwoSheetsAtRightAnglesIsARowOfCellsInEach) {
  // It stands in the middle of a row of cells of 1 mm, and meets the other in the middle of one.
  const Mesh upright = sheet({-0.0103, 0.0505, -0.0495}, {0.1206, 0, 0}, {0, 0, 0.1}, 100);
  const SurfaceCrossing found = crossing_of(kFlat, upright);
  EXPECT_EQ(found.pairs, 1);
  EXPECT_NEAR(found.area_m2, 0.01 + 0.01206, 1e-12);
  // 100 cells of 1 mm2, and 84 of the upright's 1.206 mm x 1 mm that the flat's 0.1 m reach,
  // less the parts of cells that it does not: to two of them.
  EXPECT_NEAR(found.crossed_m2, 1e-4 + 1e-4, 2 * 1.206e-6);
}

TEST(SurfaceCrossing, IsNothingWhereSheetsStayApartOrBelongTogether) {
  const Mesh above = sheet({0, 0, 1e-5}, {0.1, 0, 0}, {0, 0.1, 0}, 30);
  EXPECT_EQ(crossing_of(kFlat, above).crossed_m2, 0);
  EXPECT_EQ(crossing_of(kFlat, kFlat).crossed_m2, 0);  // in one plane
  const Mesh upright = sheet({0, 0.0505, -0.05}, {0.1, 0, 0}, {0, 0, 0.1}, 10);
  Mesh both = kFlat;
  for (const auto& t : upright.triangles) {
    const auto n = static_cast<std::uint32_t>(kFlat.vertices_m.size());
    both.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  }
  both.vertices_m.insert(both.vertices_m.end(), upright.vertices_m.begin(),
                         upright.vertices_m.end());
  const std::vector<int> one(both.triangles.size(), 5);
  EXPECT_EQ(surface_crossing(both, one).crossed_m2, 0);
  const std::vector<int> none(both.triangles.size(), -1);
  EXPECT_EQ(surface_crossing(both, none).area_m2, 0);
}

TEST(SurfaceCrossing, OfLargeTrianglesIsABandOfTheResolution) {
  const Mesh large = sheet({0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, 1);
  const Mesh upright = sheet({0, 0.0512, -0.0512}, {0.1, 0, 0}, {0, 0, 0.1}, 1);
  for (const double resolution_m : {0.004, 0.002, 0.001}) {
    const double crossed_m2 = crossing_of(large, upright, resolution_m).crossed_m2;
    // Right triangles halved at their longest side: legs of 0.7 to 0.35 of the resolution and more,
    // whose rows a line crosses whole, or two of them.
    EXPECT_GT(crossed_m2, 2 * 0.1 * 0.25 * resolution_m) << resolution_m;
    EXPECT_LT(crossed_m2, 2 * 0.1 * 2.0 * resolution_m) << resolution_m;
  }
}

TEST(SurfaceCrossing, IsTheSameOnAnyNumberOfThreads) {
  const Mesh upright = sheet({0, 0.05, -0.05}, {0.1, 0.01, 0.003}, {0, 0.02, 0.1}, 40);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return crossing_of(kFlat, upright).crossed_m2;
  };
  EXPECT_EQ(run(1), run(8));
}

TEST(SurfaceCrossing, RefusesOtherNumbersOfSheets) {
  const std::vector<int> few(3, 0);
  EXPECT_THROW(surface_crossing(kFlat, few), std::invalid_argument);
  const std::vector<int> all(kFlat.triangles.size(), 0);
  EXPECT_THROW(surface_crossing(kFlat, all, 0), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
