// True boxes as a detector would find them.
#include "benchmarks/loop/box_noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cousin {
namespace {

using testing::HasSubstr;

/// A disc at a place of an image of 640 x 480.
DetectedBox disc_box(int id, int frame, int x, int y, int radius_px) {
  DetectedBox box;
  box.id = id;
  box.frame = frame;
  box.image_px = {640, 480};
  box.mask_at_px = {x - radius_px, y - radius_px};
  box.mask = Image<std::uint8_t>(2 * radius_px + 1, 2 * radius_px + 1);
  for (int v = -radius_px; v <= radius_px; ++v) {
    for (int u = -radius_px; u <= radius_px; ++u)
      box.mask(u + radius_px, v + radius_px) = u * u + v * v <= radius_px * radius_px ? 255 : 0;
  }
  box.low_px = {x - radius_px - 0.5, y - radius_px - 0.5};
  box.high_px = {x + radius_px + 0.5, y + radius_px + 0.5};
  return box;
}

double pixels(const DetectedBox& box) {
  return static_cast<double>(std::count(box.mask.begin(), box.mask.end(), 255));
}

Boxes many_discs(int radius_px) {
  Boxes boxes;
  for (int i = 0; i < 400; ++i)
    boxes.push_back(disc_box(i, i / 20, 40 + 25 * (i % 20), 100 + i / 20, radius_px));
  return boxes;
}

TEST(BoxNoise, WithoutNoiseAllIsAsItWas) {
  const Boxes truth = many_discs(6);
  const Boxes found = detected_boxes(truth, {}, 1);
  ASSERT_EQ(found.size(), truth.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].id, truth[i].id);
    EXPECT_EQ(found[i].low_px, truth[i].low_px);
    EXPECT_TRUE(std::equal(found[i].mask.begin(), found[i].mask.end(), truth[i].mask.begin()));
  }
}

TEST(BoxNoise, SmallBoxesAreMissedMoreOften) {
  const double px = pixels(disc_box(0, 0, 100, 100, 6));  // 113
  const Boxes truth = many_discs(6);
  EXPECT_NEAR(static_cast<double>(detected_boxes(truth, {.half_px = px}, 1).size()), 200, 35);
  EXPECT_NEAR(static_cast<double>(detected_boxes(truth, {.half_px = px / 3}, 1).size()), 360, 25);
  EXPECT_NEAR(static_cast<double>(detected_boxes(truth, {.missed = 0.25}, 1).size()), 300, 30);
  EXPECT_EQ(detected_boxes(truth, {.missed = 0.25}, 1).size(),
            detected_boxes(truth, {.missed = 0.25}, 1).size());
}

TEST(BoxNoise, MasksGrowAndShrinkAllRound) {
  const Boxes truth = many_discs(10);
  const Boxes found = detected_boxes(truth, {.edge_sigma_px = 1}, 2);
  ASSERT_EQ(found.size(), truth.size());
  double sum = 0, squares = 0;
  for (const DetectedBox& box : found) {
    const double radius_px = std::sqrt(pixels(box) / std::numbers::pi);
    sum += radius_px / 400;
    squares += (radius_px - 10.05) * (radius_px - 10.05) / 400;
    EXPECT_NEAR(box.high_px.x() - box.low_px.x(), box.mask.width(), 1e-12);
    EXPECT_NEAR(box.high_px.x() - box.low_px.x(), 2 * radius_px, 1.6);
  }
  EXPECT_NEAR(sum, 10.05, 0.2);
  EXPECT_NEAR(std::sqrt(squares), 1, 0.2);
}

TEST(BoxNoise, BoxesOfNothingHaveTheSizeOfOthersAndStayInTheImage) {
  const Boxes truth = many_discs(8);
  const Boxes found = detected_boxes(truth, {.missed = 1, .false_boxes = 3}, 5);
  EXPECT_NEAR(static_cast<double>(found.size()), 60, 25);  // of 20 images
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].id, static_cast<int>(i));
    EXPECT_EQ(found[i].instance, -1);
    EXPECT_GE(found[i].low_px.minCoeff(), -0.5);
    EXPECT_LE(found[i].high_px.x(), 639.5);
    EXPECT_LE(found[i].high_px.y(), 479.5);
    EXPECT_LE(pixels(found[i]), 1.1 * pixels(truth[0]));
  }
  EXPECT_TRUE(detected_boxes({}, {.false_boxes = 3}, 5).empty());
}

TEST(BoxNoise, LimitsAreNamed) {
  EXPECT_THAT([] { validate(BoxNoiseConfig{.missed = 1.5}); },
              testing::ThrowsMessage<std::invalid_argument>(HasSubstr("boxes.missed")));
}

}  // namespace
}  // namespace cousin
