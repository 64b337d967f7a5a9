#include "perception/sfm/image_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace cousin {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::Not;

TEST(ImagePairs, ExhaustiveAreAllPairsOnce) {
  const auto pairs = image_pairs(5, {.choice = PairChoice::exhaustive});
  EXPECT_EQ(pairs.size(), 10U);
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
}

TEST(ImagePairs, OrderedAreAscendingWithoutRepeats) {
  for (const int images : {0, 1, 2, 3, 7, 48, 270}) {
    const auto pairs = image_pairs(images);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      EXPECT_LT(pairs[i][0], pairs[i][1]);
      EXPECT_GE(pairs[i][0], 0);
      EXPECT_LT(pairs[i][1], images);
      if (i > 0) EXPECT_LT(pairs[i - 1], pairs[i]);
    }
    EXPECT_EQ(pairs.empty(), images < 2);
  }
}

TEST(ImagePairs, EachImageHasItsNeighboursAndTheRingIsClosed) {
  const auto pairs = image_pairs(10, {.neighbours = 2, .far_per_image = 0});
  EXPECT_EQ(pairs.size(), 20U);
  EXPECT_THAT(pairs, Contains(ImagePair{3, 5}));
  EXPECT_THAT(pairs, Contains(ImagePair{0, 9}));
  EXPECT_THAT(pairs, Contains(ImagePair{1, 9}));
  const auto open = image_pairs(10, {.neighbours = 2, .ring = false, .far_per_image = 0});
  EXPECT_EQ(open.size(), 17U);
  EXPECT_THAT(open, Not(Contains(ImagePair{0, 9})));
}

TEST(ImagePairs, FarPairsGrowWithTheImagesAndNotWithTheirSquare) {
  const auto far = [](int images) {
    const auto with = image_pairs(images), without = image_pairs(images, {.far_per_image = 0});
    return static_cast<double>(with.size() - without.size()) / images;
  };
  // Two far pairs an image, less those that are neighbours, rounded up to whole images.
  for (const int images : {48, 270, 2000}) {
    EXPECT_GT(far(images), 1.4) << images;
    EXPECT_LT(far(images), 2.4) << images;
  }
}

TEST(ImagePairs, Of48ImagesLessThanAQuarterIsMatched) {
  EXPECT_LT(4 * image_pairs(48).size(), image_pairs(48, {.choice = PairChoice::exhaustive}).size());
}

TEST(ImagePairs, RingsAtThreeHeightsAreTiedTogether) {
  // 90 images of a turn each: a pair that is less than a ninth of a turn apart on two rings.
  bool low = false, high = false;
  for (const auto& [a, b] : image_pairs(270)) {
    const int apart = std::abs(a % 90 - b % 90);
    if (std::min(apart, 90 - apart) > 10) continue;
    low = low || (a / 90 == 0 && b / 90 == 1);
    high = high || (a / 90 == 1 && b / 90 == 2);
  }
  EXPECT_TRUE(low);
  EXPECT_TRUE(high);
}

TEST(ImagePairs, WrongNumbersAreRefused) {
  EXPECT_THROW(image_pairs(-1), std::invalid_argument);
  EXPECT_THROW(image_pairs(5, {.neighbours = 0}), std::invalid_argument);
  EXPECT_THROW(image_pairs(5, {.far_per_image = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
