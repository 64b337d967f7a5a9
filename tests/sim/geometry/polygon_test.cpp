#include "sim/geometry/polygon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace cousin::geometry {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

std::vector<std::uint32_t> counted(std::size_t corners, std::size_t first = 0) {
  std::vector<std::uint32_t> list(corners);
  std::iota(list.begin(), list.end(), 0U);
  std::rotate(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(first), list.end());
  return list;
}

struct Areas {
  double sum = 0;    ///< of the triangles, each positive
  double along = 0;  ///< the same along z: less where one is turned over
};

Areas areas_of(const std::vector<Vector3d>& points, const Triangles& triangles) {
  Areas areas;
  for (const auto& [a, b, c] : triangles) {
    const Vector3d twice = (points[b] - points[a]).cross(points[c] - points[a]);
    areas.sum += 0.5 * twice.norm();
    areas.along += 0.5 * twice.z();
  }
  return areas;
}

const std::vector<Vector3d> kL = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};

TEST(Polygon, AConvexOneIsTheFanFromItsFirstCorner) {
  const std::vector<Vector3d> points = {{0, 0, 1}, {2, 0, 1}, {3, 1, 1},
                                        {2, 2, 1}, {1, 2, 1}, {0, 2, 1}};
  for (std::size_t first = 0; first < points.size(); ++first) {
    const auto corners = counted(points.size(), first);
    Triangles fan;
    for (std::size_t k = 2; k < corners.size(); ++k)
      fan.push_back({corners[0], corners[k - 1], corners[k]});
    EXPECT_EQ(triangles_of_polygon(points, corners).triangles, fan) << first;
  }
}

TEST(Polygon, AConcaveOneHasItsAreaWhicheverCornerIsFirst) {
  for (std::size_t first = 0; first < kL.size(); ++first) {
    const PolygonTriangles cut = triangles_of_polygon(kL, counted(kL.size(), first));
    EXPECT_EQ(cut.problem, "");
    ASSERT_EQ(cut.triangles.size(), 4U);
    EXPECT_NEAR(areas_of(kL, cut.triangles).sum, 4, 1e-12) << first;
    EXPECT_NEAR(areas_of(kL, cut.triangles).along, 4, 1e-12) << first;
  }
}

TEST(Polygon, TheOtherWayRoundFacesTheOtherWay) {
  std::vector<std::uint32_t> corners = counted(kL.size(), 3);
  std::reverse(corners.begin(), corners.end());
  const PolygonTriangles cut = triangles_of_polygon(kL, corners);
  EXPECT_NEAR(areas_of(kL, cut.triangles).along, -4, 1e-12);
}

TEST(Polygon, AQuadOfAnArrowIsCutAtItsNotch) {
  const std::vector<Vector3d> arrow = {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {1, 1, 0}};
  for (std::size_t first = 0; first < 4; ++first)
    EXPECT_NEAR(areas_of(arrow, triangles_of_polygon(arrow, counted(4, first)).triangles).sum, 1,
                1e-12);
}

TEST(Polygon, ACombOfManyTeethIsCut) {
  std::vector<Vector3d> comb;
  double area = 0;
  for (int i = 0; i < 400; ++i) {  // teeth of 1 x 3 over a back of 1
    comb.emplace_back(i, i % 2 == 0 ? 1 : 4, 0);
    comb.emplace_back(i + 1, i % 2 == 0 ? 1 : 4, 0);
    area += i % 2 == 0 ? 1 : 4;
  }
  comb.emplace_back(400, 0, 0);
  comb.emplace_back(0, 0, 0);
  for (const std::size_t first : {0, 1, 17, 300}) {
    const PolygonTriangles cut = triangles_of_polygon(comb, counted(comb.size(), first));
    EXPECT_EQ(cut.triangles.size(), comb.size() - 2);
    EXPECT_NEAR(areas_of(comb, cut.triangles).sum, area, 1e-9);
    EXPECT_NEAR(areas_of(comb, cut.triangles).along, -area, 1e-9);
  }
}

TEST(Polygon, AHoleReachedOverABridgeStaysAHole) {
  // The square of 4 with a hole of 2: the bridge from its corner to the hole's is walked twice.
  const std::vector<Vector3d> points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0},
                                        {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}};
  const std::vector<std::uint32_t> corners = {0, 1, 2, 3, 0, 4, 5, 6, 7, 4};
  for (std::size_t first = 0; first < corners.size(); ++first) {
    std::vector<std::uint32_t> turned = corners;
    std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(first), turned.end());
    const PolygonTriangles cut = triangles_of_polygon(points, turned);
    EXPECT_EQ(cut.problem, "") << first;
    EXPECT_NEAR(areas_of(points, cut.triangles).sum, 12, 1e-12) << first;
  }
}

TEST(Polygon, EveryEdgeOfTheOutlineIsThatOfOneTriangle) {
  // Corners in a line too: a neighbour has them, so none may be left out.
  const std::vector<Vector3d> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                        {1, 1, 0}, {1, 2, 0}, {1, 3, 0}, {0, 3, 0}};
  for (std::size_t first = 0; first < points.size(); ++first) {
    const auto corners = counted(points.size(), first);
    const PolygonTriangles cut = triangles_of_polygon(points, corners);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      int found = 0;
      for (const auto& t : cut.triangles) {
        for (std::size_t k = 0; k < 3; ++k)
          found += t[k] == corners[i] && t[(k + 1) % 3] == corners[(i + 1) % corners.size()];
      }
      EXPECT_EQ(found, 1) << first << " " << i;
    }
  }
}

TEST(Polygon, AnOutlineThatCrossesItselfIsRefused) {
  const std::vector<Vector3d> bow = {{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}};
  const std::vector<Vector3d> uneven = {{0, 0, 0}, {3, 3, 0}, {3, 0, 0}, {0, 2, 0}};
  std::vector<Vector3d> star;
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * M_PI * 2 * i / 5;
    star.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  for (const auto& points : {bow, uneven, star}) {
    for (std::size_t first = 0; first < points.size(); ++first) {
      const PolygonTriangles cut = triangles_of_polygon(points, counted(points.size(), first));
      EXPECT_TRUE(cut.triangles.empty());
      EXPECT_THAT(cut.problem, HasSubstr("crosses itself"));
    }
  }
}

TEST(Polygon, OneWithoutAreaKeepsItsFan) {
  const std::vector<Vector3d> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(triangles_of_polygon(line, counted(4)).triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
  const std::vector<Vector3d> point(5, Vector3d(1, 2, 3));
  EXPECT_EQ(triangles_of_polygon(point, counted(5)).triangles.size(), 3U);
}

TEST(Polygon, AConcaveOneOfTooManyCornersIsRefusedWithTheLimit) {
  std::vector<Vector3d> teeth;
  for (int i = 0; i < 5000; ++i) teeth.emplace_back(i, i % 2, 0);
  teeth.emplace_back(2500, -5, 0);
  EXPECT_THAT(triangles_of_polygon(teeth, counted(teeth.size())).problem,
              HasSubstr("5001 corners; the limit is 4096"));
}

}  // namespace
}  // namespace cousin::geometry
