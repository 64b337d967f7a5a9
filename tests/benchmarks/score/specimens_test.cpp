#include "benchmarks/score/specimens.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using Points = std::vector<Eigen::Vector3d>;

TEST(MatchSpecimens, FindsAPermutation) {
  Points truth;
  Rng rng(1);
  for (int i = 0; i < 40; ++i) truth.push_back({uniform(rng), uniform(rng), uniform(rng)});
  Points measured(truth.rbegin(), truth.rend());
  const SpecimenMatching matching = match_specimens(measured, truth, 0.01);
  ASSERT_EQ(matching.matches.size(), 40U);
  for (const SpecimenMatch& match : matching.matches) {
    EXPECT_EQ(match.truth, 39 - match.measured);
    EXPECT_EQ(match.distance_m, 0);
  }
}

// Nearest first would pair 0.6 with 1.0 and leave 0.0 with 1.9, outside the gate.
TEST(MatchSpecimens, PrefersMorePairsToCloserOnes) {
  const SpecimenMatching matching =
      match_specimens(Points{{0.6, 0, 0}, {1.9, 0, 0}}, Points{{0, 0, 0}, {1, 0, 0}}, 1.0);
  ASSERT_EQ(matching.matches.size(), 2U);
  EXPECT_EQ(matching.matches[0].truth, 0);
  EXPECT_EQ(matching.matches[1].truth, 1);
}

TEST(MatchSpecimens, IsTheBestOfAllPermutations) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Rng rng(seed);
    Points measured, truth;
    for (int i = 0; i < 6; ++i) {
      measured.push_back({uniform(rng), uniform(rng), 0});
      truth.push_back({uniform(rng), uniform(rng), 0});
    }
    double sum = 0;
    const SpecimenMatching matching = match_specimens(measured, truth, 10);
    for (const SpecimenMatch& match : matching.matches) sum += match.distance_m;
    std::vector<std::size_t> order(6);
    std::iota(order.begin(), order.end(), 0U);
    double best = std::numeric_limits<double>::infinity();
    do {
      double total = 0;
      for (std::size_t i = 0; i < 6; ++i) total += (measured[i] - truth[order[i]]).norm();
      best = std::min(best, total);
    } while (std::next_permutation(order.begin(), order.end()));
    ASSERT_EQ(matching.matches.size(), 6U);
    EXPECT_NEAR(sum, best, 1e-12);
  }
}

TEST(MatchSpecimens, NamesTheSpuriousAndTheMissed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SpecimenMatching matching = match_specimens(
      Points{{5, 0, 0}, {nan, nan, nan}, {0.01, 0, 0}}, Points{{0, 0, 0}, {9, 0, 0}}, 0.1);
  ASSERT_EQ(matching.matches.size(), 1U);
  EXPECT_EQ(matching.matches[0].measured, 2);
  EXPECT_EQ(matching.spurious, (std::vector<int>{0, 1}));
  EXPECT_EQ(matching.missed, (std::vector<int>{1}));
  EXPECT_TRUE(match_specimens({}, {}, 1).matches.empty());
  EXPECT_THROW(match_specimens({}, {}, 0), std::invalid_argument);
  EXPECT_THROW(match_specimens({}, {}, nan), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
