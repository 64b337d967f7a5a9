// What of a box is a fruit's surface, and what its outline is beside.
#include "perception/fruit/fruit_surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "tests/perception/fruit/drawn_fruit.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

int places_with(const FruitSurface& surface, Beyond beyond) {
  return static_cast<int>(
      std::count_if(surface.outline.begin(), surface.outline.end(),
                    [&](const OutlinePlace& place) { return place.beyond == beyond; }));
}

TEST(FruitSurface, AFreeFruitsOutlineIsItsOwn) {
  const FruitShape shape = apple_at_half_a_metre(0.2);
  const DrawnFruit drawn = draw_fruit(shape, 0, Rng(1));
  const FruitSurface surface = fruit_surface(drawn.depth, kFruitCamera, drawn.box);
  ASSERT_EQ(surface.why_none, "");
  EXPECT_FALSE(surface.is_cut);
  EXPECT_EQ(surface.share_with_depth, 1);
  for (const SeenPoint& p : surface.points)
    EXPECT_NEAR(distance_to(shape, p.point_m, true).distance_m, 0, 2e-6);
  EXPECT_EQ(places_with(surface, Beyond::farther), static_cast<int>(surface.outline.size()));
}

TEST(FruitSurface, WhereALeafHangsBeforeItTheOutlineIsNotItsOwn) {
  DrawnFruit drawn = draw_fruit(apple_at_half_a_metre(0.2), 0, Rng(1));
  hide_from_column(drawn, 105, 0.42);
  const FruitSurface surface = fruit_surface(drawn.depth, kFruitCamera, drawn.box);
  ASSERT_EQ(surface.why_none, "");
  EXPECT_GT(places_with(surface, Beyond::nearer), 10);
  EXPECT_GT(places_with(surface, Beyond::farther), 20);
}

TEST(FruitSurface, WhatIsNoSurfaceHasAReason) {
  DrawnFruit drawn = draw_fruit(apple_at_half_a_metre(0.2), 0, Rng(1));
  DetectedBox other = drawn.box;
  other.image_px = {640, 480};
  EXPECT_THAT(fruit_surface(drawn.depth, kFruitCamera, other).why_none,
              HasSubstr("image of 640 x 480; the depth is of 200 x 160"));
  other = drawn.box;
  other.mask = {};
  other.low_px = {500, 500};
  other.high_px = {520, 520};
  EXPECT_THAT(fruit_surface(drawn.depth, kFruitCamera, other).why_none, HasSubstr("no pixel"));
  other.low_px = {-1e9, -1e9};
  other.high_px = {1e9, 1e9};  // as large as the image, and no larger
  EXPECT_LE(fruit_surface(drawn.depth, kFruitCamera, other).mask_px, 200 * 160);
  DrawnFruit sliver = drawn;
  hide_from_column(sliver, 70, 0.42);
  hide_from_column(sliver, 130, 0.42);
  EXPECT_NE(fruit_surface(sliver.depth, kFruitCamera, sliver.box).why_none, "");
  for (float& z : drawn.depth.depth_m) z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(fruit_surface(drawn.depth, kFruitCamera, drawn.box).why_none,
              HasSubstr("inner pixels have depth"));
  drawn.depth.depth_m = {};
  EXPECT_EQ(fruit_surface(drawn.depth, kFruitCamera, drawn.box).why_none, "the frame has no depth");
}

TEST(FruitSurface, ItsConfigurationIsChecked) {
  EXPECT_THAT([] { validate(FruitSurfaceConfig{.least_depths = 0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("least_depths")));
}

}  // namespace
}  // namespace cousin
