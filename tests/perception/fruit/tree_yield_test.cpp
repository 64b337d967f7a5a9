// Count and yield of a tree from the fruits that are seen.
#include "perception/fruit/tree_yield.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using testing::HasSubstr;

TEST(TreeYield, FruitsThatNoViewShowsAreCountedByChao) {
  // 10 fruits once, 5 twice, 5 three times, of 6 views: 20 + 5/6 x 10 x 9 / (2 x 6) = 26.25.
  std::vector<SeenFruit> fruits;
  for (int i = 0; i < 10; ++i) fruits.push_back({1, {0.2, 0.01}});
  for (int i = 0; i < 5; ++i) fruits.push_back({2, {0.2, 0.01}});
  for (int i = 0; i < 5; ++i) fruits.push_back({3, {0.2, 0.01}});
  const TreeYield tree = yield_of(fruits, 6, {.count_sigma = 0});
  EXPECT_EQ(tree.seen, 20);
  EXPECT_DOUBLE_EQ(tree.count.value, 26.25);
  EXPECT_NEAR(tree.yield_kg.value, 26.25 * 0.2, 1e-12);
  // The variance of the bias-corrected form: 6.25 + 25/36 x 10 x 19^2 / 144 + 25/36 x 100 x 5 x 81
  // / (4 x 6^4), and all of what is added.
  EXPECT_NEAR(tree.count.sigma, std::sqrt(6.25 + 17.4093 + 5.4254 + 6.25 * 6.25), 1e-3);
}

TEST(TreeYield, WhereAllAreSeenOftenNoneIsAdded) {
  const std::vector<SeenFruit> fruits(30, SeenFruit{4, {0.25, 0.01}});
  const TreeYield tree = yield_of(fruits, 6);
  EXPECT_DOUBLE_EQ(tree.count.value, 30);
  EXPECT_NEAR(tree.count.sigma, 0.02 * 30, 1e-12);
  // A box whose place is not known counts as a fruit, and is no sign of others.
  std::vector<SeenFruit> some = fruits;
  some.resize(40, SeenFruit{1, {0.25, 0.01}, false});
  EXPECT_DOUBLE_EQ(yield_of(some, 6).count.value, 40);
  // One view says nothing of what it does not show.
  const std::vector<SeenFruit> once(30, SeenFruit{1, {0.25, 0.01}});
  EXPECT_DOUBLE_EQ(yield_of(once, 1).count.value, 30);
}

TEST(TreeYield, IntervalsHoldWhereFruitsDifferInHowWellTheyAreSeen) {
  // 200 trees of 60 fruits; half are seen with a chance of 0.7 by each of 6 views, half with 0.25.
  Rng rng(3);
  int held = 0;
  double sum = 0;
  constexpr int kTrees = 200, kFruits = 60, kViews = 6;
  for (int t = 0; t < kTrees; ++t) {
    std::vector<SeenFruit> fruits;
    double truth_kg = 0;
    for (int f = 0; f < kFruits; ++f) {
      const double mass_kg = 0.24 * (1 + 0.2 * normal(rng));
      truth_kg += mass_kg;
      int views = 0;
      for (int v = 0; v < kViews; ++v) views += uniform(rng) < (f % 2 == 0 ? 0.7 : 0.25) ? 1 : 0;
      if (views > 0)
        fruits.push_back({views, {mass_kg * (1 + 0.05 * normal(rng)), 0.05 * mass_kg}});
    }
    const TreeYield tree = yield_of(fruits, kViews, {.mass_sigma = 0});
    sum += tree.count.value / (kTrees * kFruits);
    held += std::abs(tree.yield_kg.value - truth_kg) < 1.96 * tree.yield_kg.sigma ? 1 : 0;
  }
  EXPECT_NEAR(sum, 1, 0.03);
  EXPECT_GE(held, static_cast<int>(0.9 * kTrees));
}

TEST(TreeYield, FruitsWithoutMassHaveTheMeanOfTheOthers) {
  std::vector<SeenFruit> fruits(8, SeenFruit{3, {0.2, 0.01}});
  fruits.resize(10, SeenFruit{3, {}});
  const TreeYield tree = yield_of(fruits, 6);
  EXPECT_NEAR(tree.yield_kg.value, 2.0, 1e-12);
  const std::vector<SeenFruit> none(3, SeenFruit{3, {}});
  EXPECT_DOUBLE_EQ(yield_of(none, 6).count.value, 3);
  EXPECT_TRUE(std::isnan(yield_of(none, 6).yield_kg.value));
  EXPECT_DOUBLE_EQ(yield_of({}, 6).count.value, 0);
}

TEST(TreeYield, ViewsOfAFruitShareSomeOfTheirError) {
  const std::array<FruitMeasure, 4> views = {{{1.0, 0.1}, {1.02, 0.1}, {0.98, 0.1}, {1.0, 0.1}}};
  const FruitMeasure one = fused(views, 0.4);
  EXPECT_NEAR(one.value, 1, 1e-12);
  EXPECT_NEAR(one.sigma, 0.1 * std::sqrt(0.4 + 0.6 / 4), 1e-12);
  const std::array<FruitMeasure, 2> apart = {{{1.0, 0.1}, {2.0, 0.1}}};
  EXPECT_GT(fused(apart, 0).sigma, 0.4);  // they disagree: 50 times the variance expected
  EXPECT_TRUE(std::isnan(fused({}, 0.4).value));
}

TEST(TreeYield, ThePlaceIsAboutTheTrunk) {
  EXPECT_TRUE(is_in_place({0.5, 1.6, 2}, {}));
  EXPECT_FALSE(is_in_place({0.6, 0, 2}, {}));
  EXPECT_FALSE(is_in_place({0, -1.8, 2}, {}));
  EXPECT_THAT([] { validate(TreeYieldConfig{.along_m = 0}); },
              testing::ThrowsMessage<std::invalid_argument>(HasSubstr("yield.along_m")));
}

}  // namespace
}  // namespace cousin
