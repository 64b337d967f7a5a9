#include "sim/geometry/sessile_drops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/geometry/measure.h"
#include "tests/sim/geometry/solids.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// A horizontal sheet of 0.1 m of `cells` squares along a side.
Mesh sheet(int cells) {
  Mesh mesh;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i)
      mesh.vertices_m.emplace_back(0.1 * i / cells - 0.05, 0.1 * j / cells - 0.05, 0);
  }
  const auto n = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t j = 0; j + 1 < n; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i;
      mesh.triangles.push_back({a, a + 1, a + n + 1});
      mesh.triangles.push_back({a, a + n + 1, a + n});
    }
  }
  return mesh;
}

/// One of the drops as a mesh of its own.
Mesh part_of(const SessileDrops& drops, std::size_t part) {
  Mesh mesh;
  mesh.vertices_m = drops.mesh.vertices_m;
  for (std::size_t i = 0; i < drops.mesh.triangles.size(); ++i) {
    if (drops.triangle_part[i] == part) mesh.triangles.push_back(drops.mesh.triangles[i]);
  }
  return mesh;
}

TEST(SessileDrops, OnAFlatSheetAreCapsOfTheirContactAngle) {
  for (const double angle : {0.5, 1.4, 2.2}) {
    const SessileDropsConfig config{.count = 12,
                                    .radius_min_m = 0.002,
                                    .radius_max_m = 0.002,
                                    .contact_angle_rad = angle,
                                    .segments = 128};
    const SessileDrops drops = sessile_drops(sheet(10), config, Rng(1));
    ASSERT_EQ(drops.part_names.size(), 12U);
    const double ball = 0.002 / std::sin(angle), height = ball * (1 - std::cos(angle));
    const double cap = std::numbers::pi * height * height * (3 * ball - height) / 3;
    const double foot = std::numbers::pi * 0.002 * 0.002 * config.sink_m;
    for (std::size_t k = 0; k < drops.part_names.size(); ++k) {
      const Mesh drop = part_of(drops, k);
      EXPECT_TRUE(check_watertight(drop).ok) << check_watertight(drop).problem;
      // A regular 128-gon lacks 0.04 % of its circle; chords along the height as much again.
      EXPECT_NEAR(mass_properties(drop).volume_m3 / (cap + foot), 1, 1.5e-3) << angle;
    }
  }
}

TEST(SessileDrops, RimsFollowARoundBodyAndFeetAreInsideIt) {
  const double radius_m = 0.015;
  const Mesh body = ellipsoid_mesh(Vector3d::Constant(radius_m), 5);
  double nearest_m = radius_m;
  for (const auto& t : body.triangles) {
    const Vector3d a = body.vertices_m[t[0]];
    const Vector3d normal =
        (body.vertices_m[t[1]] - a).cross(body.vertices_m[t[2]] - a).normalized();
    nearest_m = std::min(nearest_m, normal.dot(a));
  }
  const SessileDropsConfig config{.count = 15, .radius_min_m = 0.001, .radius_max_m = 0.002};
  const SessileDrops drops = sessile_drops(body, config, Rng(2));
  ASSERT_GE(drops.part_names.size(), 10U);
  const auto segments = static_cast<std::size_t>(config.segments);
  const std::size_t rings = segments / 2, vertices = 1 + (rings + 1) * segments + 1;
  ASSERT_EQ(drops.mesh.vertices_m.size(), drops.part_names.size() * vertices);
  for (std::size_t d = 0; d < drops.part_names.size(); ++d) {
    const Vector3d* const first = drops.mesh.vertices_m.data() + d * vertices;
    for (std::size_t k = 0; k < segments; ++k) {
      const double rim_m = first[1 + (rings - 1) * segments + k].norm();
      const double foot_m = first[1 + rings * segments + k].norm();
      // On a facet: no nearer to the middle than the nearest facet's plane.
      EXPECT_GE(rim_m, nearest_m - 1e-12);
      EXPECT_LE(rim_m, radius_m + 1e-12);
      EXPECT_LT(foot_m, rim_m - 0.9 * config.sink_m * std::cos(0.2));
    }
    EXPECT_LT(first[vertices - 1].norm(), radius_m);
    EXPECT_GT(first[0].norm(), radius_m + 0.0005);
  }
}

TEST(SessileDrops, KeepApartAndDoNotDependOnHowManyComeAfterThem) {
  SessileDropsConfig config{.count = 40};
  const SessileDrops many = sessile_drops(sheet(10), config, Rng(3));
  config.count = 7;
  const SessileDrops few = sessile_drops(sheet(10), config, Rng(3));
  ASSERT_GE(many.part_names.size(), 30U);
  ASSERT_EQ(few.part_names.size(), 7U);
  for (std::size_t i = 0; i < few.mesh.vertices_m.size(); ++i)
    EXPECT_EQ(few.mesh.vertices_m[i], many.mesh.vertices_m[i]);
  const std::size_t vertices = few.mesh.vertices_m.size() / 7;
  for (std::size_t a = 0; a < many.part_names.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double apart_m =
          (many.mesh.vertices_m[a * vertices] - many.mesh.vertices_m[b * vertices]).norm();
      EXPECT_GT(apart_m, 2 * config.radius_min_m);
    }
  }
}

TEST(SessileDrops, FindNoPlaceWhereThereIsNone) {
  // A sheet seen from below, one smaller than a drop, and nothing at all.
  EXPECT_TRUE(sessile_drops(sheet(4), {.up = {0, 0, -1}}, Rng(1)).part_names.empty());
  EXPECT_TRUE(sessile_drops(sheet(4), {.radius_min_m = 0.2, .radius_max_m = 0.3}, Rng(1))
                  .mesh.triangles.empty());
  EXPECT_TRUE(sessile_drops({}, {}, Rng(1)).part_names.empty());
}

TEST(SessileDrops, RefuseMistakesByName) {
  const auto mistake = [](const SessileDropsConfig& config) -> std::string {
    try {
      sessile_drops(sheet(2), config, Rng(1));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(mistake({.count = -1}).find("count"), std::string::npos);
  EXPECT_NE(mistake({.radius_min_m = 0.003}).find("radius_min_m"), std::string::npos);
  EXPECT_NE(mistake({.contact_angle_rad = 3.2}).find("contact_angle_rad"), std::string::npos);
  EXPECT_NE(mistake({.up = {0, 0, 0}}).find("up"), std::string::npos);
  Mesh broken = sheet(2);
  broken.triangles[0][1] = 99;
  EXPECT_THROW(sessile_drops(broken, {}, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
