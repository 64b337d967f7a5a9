// Boxes of several images become fruits, each once.
#include "perception/fruit/fruit_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

PlacedBox box_at(int id, int frame, const Vector3d& at_m, double sigma_m = 0.006) {
  return {id, frame, {at_m, sigma_m * sigma_m * Matrix3d::Identity()}};
}

/// A camera 2 m before the origin, looking along y.
Pose camera_before() { return look_at({0, -2, 0}, {0, 0, 0}); }

Camera small_camera() {
  Camera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 400;
  camera.cx_px = 319.5;
  camera.cy_px = 239.5;
  return camera;
}

/// A disc of pixels about a place, of which the left part may be hidden.
DetectedBox disc(int x, int y, int radius_px, double hidden = 0) {
  DetectedBox box;
  box.mask = Image<std::uint8_t>(2 * radius_px + 1, 2 * radius_px + 1);
  box.mask_at_px = {x - radius_px, y - radius_px};
  box.image_px = {640, 480};
  const double from = -radius_px + 2 * radius_px * hidden;
  for (int v = -radius_px; v <= radius_px; ++v) {
    for (int u = -radius_px; u <= radius_px; ++u)
      box.mask(u + radius_px, v + radius_px) =
          u * u + v * v <= radius_px * radius_px && u >= from ? 255 : 0;
  }
  box.low_px = {x - radius_px - 0.5, y - radius_px - 0.5};
  box.high_px = {x + radius_px + 0.5, y + radius_px + 0.5};
  return box;
}

TEST(FruitTracks, BoxesOfOneFruitAreOneAndNeighboursStayTwo) {
  const std::vector<PlacedBox> boxes = {
      box_at(0, 0, {0, 0, 1}), box_at(1, 0, {0.075, 0, 1}), box_at(2, 1, {0.004, 0.005, 1}),
      box_at(3, 1, {0.07, 0.003, 1.0}), box_at(4, 2, {0.6, 0, 1})};
  const Tracks tracks = join_boxes(boxes);
  ASSERT_EQ(tracks.size(), 3U);
  EXPECT_THAT(tracks[0].boxes, ElementsAre(0, 2));
  EXPECT_THAT(tracks[1].boxes, ElementsAre(1, 3));
  EXPECT_THAT(tracks[2].boxes, ElementsAre(4));
  EXPECT_NEAR(tracks[0].centre_in_world_m.x(), 0.002, 1e-9);
  EXPECT_NEAR(tracks[0].covariance_m2(0, 0), 0.5 * 0.006 * 0.006, 1e-12);
}

TEST(FruitTracks, TwoBoxesOfOneImageAreNeverOneFruit) {
  const std::vector<PlacedBox> boxes = {box_at(0, 0, {0, 0, 1}), box_at(1, 0, {0.001, 0, 1}),
                                        box_at(2, 1, {0.0008, 0, 1})};
  const Tracks tracks = join_boxes(boxes);
  ASSERT_EQ(tracks.size(), 2U);
  EXPECT_THAT(tracks[1].boxes, ElementsAre(1, 2));  // the nearer one
}

TEST(FruitTracks, AHundredFruitsFromSixSidesAreAHundredInAnyOrder) {
  Rng rng(7);
  std::vector<PlacedBox> boxes;
  for (int fruit = 0; fruit < 100; ++fruit) {
    // On a lattice of 0.2 m with 20 mm of scatter.
    const Vector3d lattice(fruit % 5, fruit / 5 % 5, fruit / 25);
    const Vector3d at = 0.2 * lattice + 0.02 * Vector3d(normal(rng), normal(rng), normal(rng));
    for (int frame = 0; frame < 6; ++frame) {
      const Vector3d off(normal(rng), normal(rng), normal(rng));
      boxes.push_back(box_at(static_cast<int>(boxes.size()), frame, at + 0.008 * off, 0.008));
    }
  }
  const Tracks tracks = join_boxes(boxes);
  // Of 500 boxes that are joined, three per mille are more than 3.7 sigmas off.
  EXPECT_GE(tracks.size(), 100U);
  EXPECT_LE(tracks.size(), 104U);
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    std::set<int> fruits;
    for (const int box : tracks[t].boxes) fruits.insert(box / 6);
    EXPECT_EQ(fruits.size(), 1U) << t;
  }
  std::reverse(boxes.begin(), boxes.end());
  const Tracks again = join_boxes(boxes);
  ASSERT_EQ(again.size(), tracks.size());
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    EXPECT_EQ(again[t].boxes, tracks[t].boxes);
    EXPECT_EQ(again[t].centre_in_world_m, tracks[t].centre_in_world_m);
  }
}

TEST(FruitTracks, TheMiddleIsBehindTheDepthsAndHiddenFruitsAreLessSure) {
  const Camera camera = small_camera();
  const FruitPrior prior;
  // At 2 m: 400 px / 2 m x 44 mm = 8.8 px of radius.
  FrameDepth depth{0, Image<float>(640, 480), {}, {}};
  std::fill(depth.depth_m.begin(), depth.depth_m.end(), 1.974F);
  const auto whole = rough_place(disc(320, 240, 9), camera, depth, prior);
  ASSERT_TRUE(whole.has_value());
  EXPECT_NEAR(whole->point_m.z(), 2, 0.002);
  EXPECT_NEAR(whole->point_m.x(), 0.5 / 400 * 2, 1e-3);
  const auto part = rough_place(disc(320, 240, 9, 0.6), camera, depth, prior);
  ASSERT_TRUE(part.has_value());
  EXPECT_GT(part->covariance_m2(0, 0), 4 * whole->covariance_m2(0, 0));
  FrameDepth none{0, Image<float>(640, 480), {}, {}};
  std::fill(none.depth_m.begin(), none.depth_m.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(rough_place(disc(320, 240, 9), camera, none, prior).has_value());
}

TEST(FruitTracks, ABoxWithoutDepthIsPlacedByItsSizeAndJoinsTheFruitThere) {
  const Camera camera = small_camera();
  const FruitTracksConfig config;
  const DetectedBox box = disc(360, 240, 9);  // 19 px across: 400 x 0.088 / 19 = 1.853 m
  const LocatedPoint place = place_by_size(box, camera, {});
  EXPECT_NEAR(place.point_m.z(), 1.853, 0.001);
  EXPECT_NEAR(std::sqrt(place.covariance_m2(2, 2)), 0.2, 0.05);
  EXPECT_GT(place_by_size(disc(360, 240, 9, 0.6), camera, {}).covariance_m2(2, 2),
            2 * place.covariance_m2(2, 2));
  const PlacedBox in_world = placed(box, place, camera_before(), config.pose_sigma_m);
  const Vector3d eye(0, -2, 0);
  const Vector3d on_ray = eye + 1.08 * (in_world.in_world.point_m - eye);
  std::vector<PlacedBox> boxes = {in_world, box_at(5, 1, on_ray)};
  EXPECT_EQ(join_boxes(boxes, config).size(), 1U);
  boxes[1] = box_at(5, 1, on_ray + Vector3d(0.1, 0, 0));  // a fruit beside the ray
  EXPECT_EQ(join_boxes(boxes, config).size(), 2U);
}

TEST(FruitTracks, ABoxWithoutDepthHangsInTheRowIfItCan) {
  const Vector3d along(0, 1, 0);
  PlacedBox box = box_at(0, 0, {0.1, 0.4, 1.5}, 0.01);
  box.in_world.covariance_m2 += 0.35 * 0.35 * along * along.transpose();
  const PlacedBox here = in_row(box, 0.35);
  EXPECT_NEAR(here.in_world.point_m.y(), 0.2, 0.001);
  EXPECT_NEAR(here.in_world.point_m.x(), 0.1, 1e-9);
  EXPECT_NEAR(std::sqrt(here.in_world.covariance_m2(1, 1)), 0.35 / std::sqrt(2.0), 0.001);
  EXPECT_NEAR(here.in_world.covariance_m2(0, 0), 1e-4, 1e-9);
  box.in_world.point_m.y() = 3.4;  // of the next row
  EXPECT_EQ(in_row(box, 0.35).in_world.point_m.y(), 3.4);
}

TEST(FruitTracks, DepthOfWhatIsBehindAFruitIsNotItsOwn) {
  FrameDepth depth{0, Image<float>(640, 480), {}, {}};
  std::fill(depth.depth_m.begin(), depth.depth_m.end(), 3.4F);  // 19 px there are 161 mm
  EXPECT_FALSE(rough_place(disc(320, 240, 9), small_camera(), depth, {}).has_value());
}

TEST(FruitTracks, WhatCannotBeIsRefused) {
  EXPECT_TRUE(join_boxes({}).empty());
  const std::vector<PlacedBox> many(20'001, box_at(0, 0, {0, 0, 0}));
  EXPECT_THAT([&] { join_boxes(many); }, testing::ThrowsMessage<std::invalid_argument>(
                                             HasSubstr("20001 boxes; at most 20000")));
  EXPECT_THAT([] { validate(FruitTracksConfig{.per_m3 = 0}); },
              testing::ThrowsMessage<std::invalid_argument>(HasSubstr("tracks.per_m3")));
}

}  // namespace
}  // namespace cousin
