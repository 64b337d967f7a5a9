#include "perception/stem/node_matching.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/perception/stem/made_stem.h"

namespace cousin {
namespace {

TEST(EpipolarDistance, IsNothingForAPairAndTheRowsApartElse) {
  const EyePair eyes = made_eyes();
  const Eigen::Vector3d point(0.1, -0.05, 0.9);
  const Eigen::Vector2d left = *eyes.left.project(point);
  const Eigen::Vector2d right = *eyes.right.project(eyes.right_from_left * point);
  EXPECT_NEAR(epipolar_distance(eyes, left, right)->in_right_px, 0, 1e-9);
  const auto below = epipolar_distance(eyes, left, right + Eigen::Vector2d(5, 3));
  EXPECT_NEAR(below->in_right_px, 3, 1e-9);  // lines of this pair are level
  EXPECT_NEAR(std::abs(below->in_left_px), 3, 1e-9);
}

TEST(EpipolarDistance, OfAPointAtTheEpipoleIsNone) {
  // One eye behind the other: each sees the other at its middle.
  const Camera camera = made_eyes().left.camera();
  Pose right_from_left;
  right_from_left.translation_m = {0, 0, -0.12};
  const EyePair eyes(camera, camera, right_from_left);
  const Eigen::Vector2d epipole(639.5, 359.5);
  EXPECT_FALSE(epipolar_distance(eyes, epipole, epipole));
  EXPECT_FALSE(middle_of_rays(eyes, epipole, epipole));
  EyeNodes nodes;
  nodes.nodes = {{epipole, 1}};
  EXPECT_TRUE(match_in_order(eyes, nodes, nodes).empty());
  EXPECT_TRUE(match_by_paper(eyes, nodes, nodes).empty());
}

TEST(MiddleOfRays, GivesThePointAndNothingBehindTheEyes) {
  const EyePair eyes = made_eyes();
  const Eigen::Vector3d point(0.1, -0.05, 0.9);
  const Eigen::Vector2d left = *eyes.left.project(point);
  const Eigen::Vector2d right = *eyes.right.project(eyes.right_from_left * point);
  EXPECT_LT((*middle_of_rays(eyes, left, right) - point).norm(), 1e-9);
  EXPECT_FALSE(middle_of_rays(eyes, right, left));  // images that are swapped
}

TEST(MatchInOrder, FindsAllNodesWhateverTheirOrder) {
  const EyePair eyes = made_eyes();
  MadeView view = made_view(eyes, made_stem(0.9), 0.3, 0, Rng(1));
  std::reverse(view.left.nodes.begin(), view.left.nodes.end());
  std::rotate(view.right.nodes.begin(), view.right.nodes.begin() + 2, view.right.nodes.end());
  const auto plants = match_in_order(eyes, view.left, view.right);
  ASSERT_EQ(plants.size(), 1U);
  ASSERT_TRUE(plants[0].has_root);
  ASSERT_EQ(plants[0].pairs.size(), view.sightings.size());
  for (std::size_t i = 0; i < view.sightings.size(); ++i) {
    EXPECT_EQ(plants[0].pairs[i].left.pixel_px, view.sightings[i].left.pixel_px);
    EXPECT_EQ(plants[0].pairs[i].right.pixel_px, view.sightings[i].right.pixel_px);
  }
}

TEST(MatchInOrder, LeavesMissedAndFalseNodesAlone) {
  const EyePair eyes = made_eyes();
  MadeView view = made_view(eyes, made_stem(0.9), 0.3, 0, Rng(2));
  view.left.nodes.erase(view.left.nodes.begin() + 1);
  view.right.nodes.push_back({{700, 300}, 0.3});  // on no left node's line
  const auto plants = match_in_order(eyes, view.left, view.right);
  ASSERT_EQ(plants.size(), 1U);
  EXPECT_EQ(plants[0].pairs.size(), view.sightings.size() - 1);
  for (const NodePair& pair : plants[0].pairs) EXPECT_LT(std::abs(pair.epipolar_px), 2);
}

TEST(MatchInOrder, GivesANodeToThePlantAtItsDepth) {
  const EyePair eyes = made_eyes();
  // Behind the first plant, seen beside and partly above it.
  const MadeView near = made_view(eyes, made_stem(0.9), 0.3, 0, Rng(3));
  const MadeView far = made_view(eyes, made_stem(1.7, 0.02), 0.3, 0, Rng(4));
  MadeView both = near;
  for (const auto& [from, to] : {std::pair(&far.left, &both.left), {&far.right, &both.right}}) {
    to->roots.insert(to->roots.begin(), from->roots.begin(), from->roots.end());
    to->nodes.insert(to->nodes.begin(), from->nodes.begin(), from->nodes.end());
  }
  const auto plants = match_in_order(eyes, both.left, both.right);
  ASSERT_EQ(plants.size(), 2U);
  for (const MatchedPlant& plant : plants) {
    double low = 1e9, high = 0;
    for (const NodePair& pair : plant.pairs) {
      const double depth = middle_of_rays(eyes, pair.left.pixel_px, pair.right.pixel_px)->z();
      low = std::min(low, depth);
      high = std::max(high, depth);
    }
    EXPECT_LT(high - low, 0.15);  // a stem leans by 0.04 m, and a pixel of disparity is 0.03 m
    EXPECT_EQ(plant.pairs.size(), near.sightings.size());
  }
}

TEST(MatchInOrder, TakesTwentyNodesAndNone) {
  const EyePair eyes = made_eyes();
  std::vector<Eigen::Vector3d> nodes;
  for (int i = 0; i < 20; ++i) nodes.emplace_back(0, 0.25 - 0.025 * i, 0.9);
  const MadeView view = made_view(eyes, nodes, 0.3, 0, Rng(5));
  const auto plants = match_in_order(eyes, view.left, view.right);
  ASSERT_EQ(plants.size(), 1U);
  EXPECT_EQ(plants[0].pairs.size(), 20U);
  EXPECT_TRUE(match_in_order(eyes, {}, {}).empty());
  EXPECT_TRUE(match_in_order(eyes, view.left, {}).empty());
}

TEST(MatchInOrder, OfSwappedImagesHasNothing) {
  const EyePair eyes = made_eyes();
  const MadeView view = made_view(eyes, made_stem(0.9), 0.3, 0, Rng(6));
  EXPECT_TRUE(match_in_order(eyes, view.right, view.left).empty());
  EXPECT_TRUE(match_by_paper(eyes, view.right, view.left).empty());
}

TEST(EpipolarOffset, IsFoundFromMatchesAndShrinksWithFew) {
  const EyePair eyes = made_eyes();
  std::vector<MatchedPlant> plants;
  for (int i = 0; i < 40; ++i) {
    MadeView view = made_view(eyes, made_stem(0.9), 0.5, 0, Rng(static_cast<std::uint64_t>(i)));
    for (EyeNode& node : view.right.roots) node.pixel_px.y() += 1.2;
    for (EyeNode& node : view.right.nodes) node.pixel_px.y() += 1.2;
    const auto found = match_in_order(eyes, view.left, view.right);
    plants.insert(plants.end(), found.begin(), found.end());
  }
  const EpipolarOffset offset = epipolar_offset(plants);
  // 240 matches of 0.71 px: the median's deviation is 0.06 px; allow four.
  EXPECT_NEAR(offset.offset_px, 1.2, 0.24);
  EXPECT_LT(offset.sigma_px, 0.1);
  EXPECT_NEAR(epipolar_offset({}).sigma_px, NodeMatchConfig{}.calibration_px, 1e-12);
}

}  // namespace
}  // namespace cousin
