#include "scenes/maize/maize_plant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "sim/geometry/measure.h"
#include "tests/places/source_words.h"

namespace cousin {
namespace {

MaizePlant grown(double stage, std::uint64_t seed = 1) {
  return grow_maize(maize(), stage, Rng(seed));
}

std::optional<double> trait(const MaizePlant& plant, const std::string& name) {
  for (const TrueTrait& t : plant.traits) {
    if (t.name == name) return t.value;
  }
  return {};
}

std::optional<Eigen::Vector3d> keypoint(const Plant& plant, const std::string& name) {
  for (const Keypoint& k : plant.keypoints) {
    if (k.name == name) return k.in_object_m;
  }
  return {};
}

TEST(MaizePlant, EveryNumberHasItsSourceWord) { expect_sourced("maize/maize.toml"); }

TEST(MaizePlant, LeavesOfPlantsDifferByTheirSpreadAlone) {
  MaizeConfig config = maize();
  config.plant.spread = config.blade.size_spread = 0;
  const auto length_m = [&](std::uint64_t seed) {
    const Plant plant = grow_maize(config, 12, Rng(seed)).plant;
    for (const Organ& organ : plant.organs) {
      if (organ.name == "leaf 9") return line_length_m(organ);
    }
    return 0.0;
  };
  const double same_m = length_m(1);
  EXPECT_GT(same_m, 0.5);
  EXPECT_NEAR(length_m(2), same_m, 1e-9);
  config.blade.size_spread = 0.05;
  EXPECT_GT(std::abs(length_m(2) - same_m), 1e-4);
}

TEST(MaizePlant, OrgansKeepIdsNamesAndParentsFromStageToStage) {
  const Plant last = grown(19).plant;
  for (double stage = 3; stage <= 19; stage += 0.5) {
    const Plant plant = grown(stage).plant;
    ASSERT_EQ(plant.organs.size(), last.organs.size()) << stage;
    for (std::size_t i = 0; i < plant.organs.size(); ++i) {
      EXPECT_EQ(plant.organs[i].name, last.organs[i].name);
      EXPECT_EQ(plant.organs[i].parent, last.organs[i].parent);
    }
  }
}

TEST(MaizePlant, AStageHasAsManyCollarsAsItsNumberUntilTheLowestLeavesFall) {
  for (int stage = 3; stage <= 11; ++stage)
    EXPECT_EQ(trait(grown(stage), "leaf_count"), stage) << stage;
  // Tips stand ahead of collars.
  EXPECT_GT(*trait(grown(6), "visible_leaf_count"), 8);
  EXPECT_EQ(*trait(grown(19), "visible_leaf_count"), *trait(grown(19), "leaf_count"));
}

TEST(MaizePlant, InternodesAreTheDistancesBetweenNodesAlongTheAxis) {
  const MaizePlant plant = grown(14);
  int checked = 0;
  for (int rank = 2; rank <= 16; ++rank) {
    char name[24];
    std::snprintf(name, sizeof name, "internode_%02d", rank);
    const auto length = trait(plant, name);
    if (!length) continue;
    const auto low = keypoint(plant.plant, "node " + std::to_string(rank - 1));
    const auto high = keypoint(plant.plant, "node " + std::to_string(rank));
    ASSERT_TRUE(low && high) << rank;
    // An internode is straight: the length along it is the distance.
    EXPECT_NEAR((*high - *low).norm(), *length, 1e-9 + 1e-9 * *length);
    ++checked;
  }
  EXPECT_GE(checked, 8);
}

TEST(MaizePlant, LeafAnglesAreAboutThoseOfItsTable) {
  const MaizeConfig& config = maize();
  const MaizePlant plant = grown(16);
  for (const int rank : {8, 10, 12}) {
    char name[24];
    std::snprintf(name, sizeof name, "leaf_angle_%02d", rank);
    const double up = (rank - 1.0) / (config.plant.leaves - 1);
    const double mean = config.blade.angle_low_rad +
                        up * (config.blade.angle_high_rad - config.blade.angle_low_rad);
    // The leaf's own factor is within 2.5 sigmas of 14 %; the first of 40 steps has not drooped.
    EXPECT_NEAR(*trait(plant, name), mean, 2.5 * 0.14 * mean + 0.03) << rank;
  }
}

TEST(MaizePlant, TheLowestNodesStayInTheGroundAndTheRootIsOnIt) {
  const MaizePlant plant = grown(12);
  EXPECT_FALSE(keypoint(plant.plant, "node 1"));
  EXPECT_TRUE(keypoint(plant.plant, "node 9"));
  // The surface is found along the leaning axis: a second-order error in the lean of 0.07 rad.
  EXPECT_NEAR(keypoint(plant.plant, "root")->z(), 0, 1e-3);
}

TEST(MaizePlant, GrowsTallerFromStageToStageAndTasselsLast) {
  double before = 0;
  for (int stage = 3; stage <= 19; ++stage) {
    const double height = *trait(grown(stage), "height");
    EXPECT_GT(height, before) << stage;
    before = height;
    EXPECT_EQ(keypoint(grown(stage).plant, "tassel tip").has_value(), stage >= 18) << stage;
  }
  // Medium hybrids end between 2 and 3 m with the tassel.
  EXPECT_GT(before, 1.8);
  EXPECT_LT(before, 3.0);
}

TEST(MaizePlant, LeavesStandInTwoRows) {
  const Plant plant = grown(12).plant;
  const auto collar7 = *keypoint(plant, "collar 7"), tip7 = *keypoint(plant, "tip 7");
  const auto collar8 = *keypoint(plant, "collar 8"), tip8 = *keypoint(plant, "tip 8");
  const Eigen::Vector2d a = (tip7 - collar7).head<2>(), b = (tip8 - collar8).head<2>();
  EXPECT_LT(a.normalized().dot(b.normalized()), -0.5);
}

TEST(MaizePlant, StalkSheathsAndRootsAreClosed) {
  for (const double stage : {3.0, 8.0, 19.0}) {
    for (const Organ& organ : grown(stage, 3).plant.organs) {
      if (!is_there(organ) || organ.kind == OrganKind::blade) continue;
      const MeshCheck check = check_watertight(organ.surface.mesh);
      EXPECT_TRUE(check.ok) << organ.name << ", stage " << stage << ": " << check.problem;
    }
  }
}

TEST(MaizePlant, AFullLeafIsNearlyAsLongAsItsMidribSays) {
  const MaizeConfig& config = maize();
  const Plant plant = grown(16).plant;
  for (const Organ& organ : plant.organs) {
    if (organ.kind != OrganKind::blade || organ.rank < 7 || organ.rank > 14) continue;
    const double mean = config.blade.length_m[static_cast<std::size_t>(organ.rank - 1)];
    // Vigour and the leaf's own size, each within 2.5 of its sigmas.
    const double reach = (1 + 2.5 * config.plant.spread) * (1 + 2.5 * 0.05);
    EXPECT_GT(line_length_m(organ), mean / reach / 1.05) << organ.name;
    EXPECT_LT(line_length_m(organ), mean * reach) << organ.name;
  }
}

TEST(MaizeStage, NamesAreReadAndOthersRefused) {
  EXPECT_EQ(maize_stage("V3", 18), 3);
  EXPECT_EQ(maize_stage("V18", 18), 18);
  EXPECT_EQ(maize_stage("VT", 18), 19);
  for (const char* text : {"V2", "V19", "R1", "", "V", "v6", "day 1000"}) {
    try {
      maize_stage(text, 18);
      FAIL() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("is not one of V3 .. V18, VT"));
    }
  }
  EXPECT_THROW(grown(-1), std::invalid_argument);
  EXPECT_THROW(grown(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
