// Seeds of every cultivar dropped onto each other: how deep they end in each other and in the
// board.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "benchmarks/score/surface_distance.h"
#include "scenes/seeds/seeds_scene.h"
#include "sim/physics/settle.h"

namespace cousin {
namespace {

constexpr double kDeepest_m = 2e-5;

struct Pile {
  std::vector<Mesh> meshes;  ///< of the seeds, exact, in the world
  SettleResult settled;
};

/// Four seeds released one above the other into air as thick as honey: they stay where they meet.
Pile drop_pile(const std::string& cultivar) {
  std::vector<SeedModel> seeds;
  for (std::uint64_t i = 0; i < 4; ++i) {
    seeds.push_back(make_seed(cultivar, SizeSpread::literature, Rng(7).fork(i)));
  }
  std::vector<SettleBody> bodies;
  for (const SeedModel& seed : seeds) {
    Pose pose;
    pose.rotation = Eigen::AngleAxisd(1.1 * static_cast<double>(bodies.size()),
                                      Eigen::Vector3d(0.2, 0.1, 1).normalized());
    bodies.push_back({&seed.model.mesh, seed.mass_kg, pose});
  }
  Pile pile;
  pile.settled = settle(bodies, {.drag_per_s = 50, .drop_height_m = 0.0005});
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    pile.meshes.push_back(seeds[i].model.mesh);
    for (Eigen::Vector3d& v : pile.meshes[i].vertices_m) v = pile.settled.world_from_body[i] * v;
  }
  return pile;
}

/// The least signed distance of the corners of `a` from the exact surface of `b`; negative: so deep
/// in it. Corners lie up to 0.15 mm apart: where a seed's radius of curvature is 0.5 mm, its
/// surface stands out by up to 0.15^2 / (8 x 0.5) = 0.006 mm between them.
double least_distance_m(const Mesh& a, const Mesh& b) {
  const DistanceTree surface(b);
  double least_m = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& corner : a.vertices_m) {
    least_m = std::min(least_m, surface.signed_distance_m(corner));
  }
  return least_m;
}

class SeedPiles : public testing::TestWithParam<std::string> {};

// From the exact meshes alone: the engine, and the depth that settle() reports, know the convex
// parts.
TEST_P(SeedPiles, NoSeedStandsDeeperThanAFiftiethOfAMillimetreInAnotherOrInTheBoard) {
  const Pile pile = drop_pile(GetParam());
  ASSERT_EQ(pile.settled.status, SettleStatus::ok);
  EXPECT_EQ(pile.settled.warnings, 0);
  EXPECT_LT(pile.settled.kinetic_energy_j, SettleConfig{}.rest_energy_j);
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < pile.meshes.size(); ++i) {
    double lowest_m = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& v : pile.meshes[i].vertices_m) lowest_m = std::min(lowest_m, v.z());
    EXPECT_GE(lowest_m, -kDeepest_m) << "seed " << i << " in the board";
    for (std::size_t j = 0; j < pile.meshes.size(); ++j) {
      if (i == j) continue;
      const double least_m = least_distance_m(pile.meshes[i], pile.meshes[j]);
      EXPECT_GE(least_m, -kDeepest_m) << "seed " << i << " in seed " << j;
      nearest_m = std::min(nearest_m, least_m);
    }
  }
  std::printf("%s: least distance of two seeds %.4f mm\n", GetParam().c_str(), 1e3 * nearest_m);
  EXPECT_LT(nearest_m, kDeepest_m) << "no two seeds touch, so nothing is tested";
}

INSTANTIATE_TEST_SUITE_P(Cultivars, SeedPiles, testing::ValuesIn(cultivar_names()),
                         [](const auto& cultivar) { return cultivar.param; });

}  // namespace
}  // namespace cousin
