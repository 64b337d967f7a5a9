#include "scenes/seedlings/watermelon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/geometry/measure.h"
#include "tests/places/source_words.h"

namespace cousin {
namespace {

Seedling grown(double day, std::uint64_t seed = 1, const SeedlingPlace& place = {}) {
  WatermelonConfig config = watermelon();
  config.emergence.failed_share = 0;
  return grow_watermelon(config, place, day, Rng(seed));
}

double trait(const Seedling& seedling, const std::string& name) {
  for (const TrueTrait& t : seedling.traits) {
    if (t.name == name) return t.value;
  }
  ADD_FAILURE() << name;
  return std::nan("");
}

TEST(Watermelon, EveryNumberHasItsSourceWord) {
  expect_sourced("seedlings/watermelon.toml");
  expect_sourced("seedlings/tray.toml");
}

TEST(Watermelon, OrgansKeepTheirIdsNamesAndParentsFromDayToDay) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Plant last = grown(kLastSeedlingDay, seed).plant;
    Plant before;
    for (double day = 0; day <= kLastSeedlingDay; day += 0.5) {
      const Plant plant = grown(day, seed).plant;
      ASSERT_EQ(plant.organs.size(), last.organs.size());
      for (std::size_t i = 0; i < plant.organs.size(); ++i) {
        EXPECT_EQ(plant.organs[i].id, last.organs[i].id);
        EXPECT_EQ(plant.organs[i].name, last.organs[i].name);
        EXPECT_EQ(plant.organs[i].parent, last.organs[i].parent);
        // What has come stays.
        if (!before.organs.empty() && is_there(before.organs[i])) {
          EXPECT_TRUE(is_there(plant.organs[i])) << plant.organs[i].name << ", day " << day;
          EXPECT_GE(line_length_m(plant.organs[i]), line_length_m(before.organs[i]) * (1 - 1e-12));
        }
      }
      before = plant;
    }
  }
}

TEST(Watermelon, NothingIsThereBeforeEmergenceAndAllTraitsAreZero) {
  const Seedling seed = grown(0);
  EXPECT_FALSE(seed.has_emerged);
  EXPECT_TRUE(plant_model(seed.plant).model.mesh.triangles.empty());
  for (const TrueTrait& t : seed.traits) EXPECT_EQ(t.value, 0) << t.name;
}

TEST(Watermelon, LeavesComeOneAfterAnotherAndCotyledonsDoNotCount) {
  const Seedling probe = grown(0);
  const double emergence = probe.emergence_day;
  EXPECT_EQ(trait(grown(emergence + 1.5), "leaf_count"), 0);
  EXPECT_GT(trait(grown(emergence + 1.5), "cotyledon_area"), 0);
  int before = 0;
  for (double day = emergence; day < 18; day += 0.25) {
    const int count = static_cast<int>(trait(grown(day), "leaf_count"));
    EXPECT_GE(count, before);
    EXPECT_LE(count, before + 1);
    before = count;
  }
  EXPECT_EQ(before, kSeedlingLeaves);
}

TEST(Watermelon, ZeroLeavesGrowsCotyledonsAlone) {
  SeedlingPlace place;
  place.leaves = 0;
  const Seedling seedling = grown(12, 1, place);
  EXPECT_EQ(trait(seedling, "leaf_count"), 0);
  EXPECT_DOUBLE_EQ(trait(seedling, "leaf_area"), trait(seedling, "cotyledon_area"));
  EXPECT_GT(trait(seedling, "leaf_area"), 0);
}

TEST(Watermelon, StemsAndPetiolesAreClosedOnEveryDay) {
  for (const double day : {3.0, 4.0, 6.0, 9.0, 12.0, 20.0}) {
    for (const Organ& organ : grown(day, 5).plant.organs) {
      if (!is_there(organ)) continue;
      if (organ.kind != OrganKind::stem && organ.kind != OrganKind::petiole) continue;
      const MeshCheck check = check_watertight(organ.surface.mesh);
      EXPECT_TRUE(check.ok) << organ.name << ", day " << day << ": " << check.problem;
    }
  }
}

TEST(Watermelon, AreaTraitsAreTheMeshesAreas) {
  const Seedling seedling = grown(11);
  const PlantModel made = plant_model(seedling.plant);
  double blades = 0;
  for (std::size_t i = 0; i < made.model.mesh.triangles.size(); ++i) {
    const std::string& part = made.model.part_names[made.model.triangle_part[i]];
    const bool is_sheet = part.find("petiole") == part.npos &&
                          (part.starts_with("leaf") || part.starts_with("cotyledon"));
    if (!is_sheet) continue;
    Mesh one;
    one.vertices_m = made.model.mesh.vertices_m;
    one.triangles = {made.model.mesh.triangles[i]};
    blades += surface_area_m2(one);
  }
  EXPECT_NEAR(blades, trait(seedling, "leaf_area"), 1e-12);  // sums in another order
}

TEST(Watermelon, TheHookOpensAndTheStemBendsToTheLight) {
  const double emergence = grown(0).emergence_day;
  const auto tip_heading = [](const Seedling& s) -> Eigen::Vector3d {
    const auto& points = s.plant.organs.front().line.points_m;
    return (points.back() - points[points.size() - 2]).normalized();
  };
  EXPECT_LT(tip_heading(grown(emergence + 0.1)).z(), -0.5);  // hangs
  EXPECT_GT(tip_heading(grown(emergence + 4)).z(), 0.9);
  SeedlingPlace east, west;
  east.to_light = Eigen::Vector3d(1, 0, 0.3).normalized();
  west.to_light = Eigen::Vector3d(-1, 0, 0.3).normalized();
  EXPECT_GT(tip_heading(grown(8, 1, east)).x(), tip_heading(grown(8, 1, west)).x() + 0.2);
}

TEST(Watermelon, AnEmergenceRateIsThatOfTheSeedLot) {
  WatermelonConfig config = watermelon();
  config.emergence.failed_share = 0.2;
  int failed = 0;
  constexpr int kSeeds = 2000;
  for (int i = 0; i < kSeeds; ++i) {
    const auto key = static_cast<std::uint64_t>(i);
    failed += !grow_watermelon(config, {}, 0, Rng(7).fork(key)).germinates;
  }
  // Binomial: five standard deviations.
  EXPECT_NEAR(failed, 0.2 * kSeeds, 5 * std::sqrt(kSeeds * 0.2 * 0.8));
}

TEST(Watermelon, RefusesDaysThatItIsNotGrownFor) {
  for (const double day : {-1.0, 1000.0, std::numeric_limits<double>::quiet_NaN()}) {
    try {
      grown(day);
      FAIL() << day;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("days that seedlings are grown for"));
    }
  }
  SeedlingPlace place;
  place.leaves = 5;
  EXPECT_THROW(grown(5, 1, place), std::invalid_argument);
}

TEST(Watermelon, RefusesAListOfTheWrongLength) {
  WatermelonConfig config = watermelon();
  config.leaf.lobes = {3};
  EXPECT_THROW(validate(config), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
