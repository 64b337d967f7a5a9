#include "sim/dataset/export/splits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace cousin {
namespace {

using testing::HasSubstr;

std::vector<ExportScene> scenes(int count) {
  std::vector<ExportScene> result(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    ExportScene& scene = result[static_cast<std::size_t>(i)];
    scene.number = i;
    scene.capture.frames.resize(4);
    scene.truth.emplace();
  }
  return result;
}

int count_of(const std::vector<Split>& splits, Split split) {
  return static_cast<int>(std::count(splits.begin(), splits.end(), split));
}

TEST(Splits, GiveEachSideItsShareToWithinAScene) {
  const std::vector<Split> splits = splits_of(scenes(50), {0.7, 0.2, 0.1});
  EXPECT_NEAR(count_of(splits, Split::train), 35, 1);
  EXPECT_NEAR(count_of(splits, Split::val), 10, 1);
  EXPECT_NEAR(count_of(splits, Split::test), 5, 1);
  EXPECT_EQ(splits, splits_of(scenes(50), {0.7, 0.2, 0.1}));
}

TEST(Splits, ScenesThatShareAPlantStayTogether) {
  std::vector<ExportScene> all = scenes(30);
  // Ten plants of three pictures each, and one scene that shows two of them.
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i].truth->shared_plants = {"plant " + std::to_string(i % 10)};
  all[3].truth->shared_plants.push_back("plant 4");
  const std::vector<Split> splits = splits_of(all, {0.6, 0.2, 0.2});
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(splits[i], splits[i % 10]) << i;
  EXPECT_EQ(splits[3], splits[4]);
  for (const Split split : kSplits) EXPECT_GT(count_of(splits, split), 0);
}

TEST(Splits, OneGroupIsForTrainingAndTheRestIsSaid) {
  std::vector<ExportScene> series = scenes(5);
  for (ExportScene& scene : series) scene.truth->shared_plants = {"tray"};
  const std::vector<Split> splits = splits_of(series, {0.8, 0.1, 0.1});
  EXPECT_EQ(count_of(splits, Split::train), 5);
  EXPECT_THAT(empty_splits(splits, {0.8, 0.1, 0.1}), HasSubstr("val and test are empty"));
  EXPECT_EQ(empty_splits(splits, {1, 0, 0}), "");
  EXPECT_EQ(count_of(splits_of(series, {0, 0, 1}), Split::test), 5);
  const std::vector<Split> three = splits_of(scenes(3), {0.8, 0.1, 0.1});
  for (const Split split : kSplits) EXPECT_EQ(count_of(three, split), 1);
}

TEST(Splits, OfTwoScenesOneIsForWhatTheReadersNeed) {
  for (const Split needed : {Split::val, Split::test}) {
    const std::vector<Split> splits = splits_of(scenes(2), {0.8, 0.1, 0.1}, needed);
    EXPECT_EQ(count_of(splits, Split::train), 1);
    EXPECT_EQ(count_of(splits, needed), 1);
    EXPECT_EQ(splits, splits_of(scenes(2), {0.8, 0.1, 0.1}, needed));
  }
  EXPECT_EQ(splits_of(scenes(9), {0.8, 0.1, 0.1}, Split::val),
            splits_of(scenes(9), {0.8, 0.1, 0.1}, Split::test));
}

TEST(Splits, WrongSharesAreRefused) {
  EXPECT_EQ(split_from_string("0.5,0.25,0.25"), (std::array<double, 3>{0.5, 0.25, 0.25}));
  for (const char* text :
       {"", "1", "0.5,0.5", "0.5,0.5,0.5", "-1,1,1", "nan,0,0", "1,0,0,0", "1;0;0"})
    EXPECT_THROW(split_from_string(text), std::invalid_argument) << text;
}

}  // namespace
}  // namespace cousin
