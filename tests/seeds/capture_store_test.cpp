#include "benchmarks/seeds/capture_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

SeedsRunConfig small_scene(const std::vector<std::string>& more = {}) {
  std::vector<std::string> sets = {"sphere=true",
                                   "views=2",
                                   "rig.width_px=160",
                                   "rig.height_px=90",
                                   "render.irradiance_samples=16",
                                   "render.edge_samples=16",
                                   "render.board_texel_m=0.01"};
  sets.insert(sets.end(), more.begin(), more.end());
  return seeds_run_config(sets);
}

class CaptureStore : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("capture_store_") +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Progress that counts the views that are rendered.
  Progress counter() {
    return [this](const std::string& what, int, int) { rendered_ += what == "render" ? 1 : 0; };
  }
  std::vector<fs::path> stored() const {
    std::vector<fs::path> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path());
    return names;
  }

  fs::path folder_;
  int rendered_ = 0;
};

TEST_F(CaptureStore, ASecondRunReadsWhatTheFirstRendered) {
  const SimulatedRun first = stored_seeds(folder_, small_scene(), 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 2);
  // How it is measured does not name the capture.
  const SimulatedRun again =
      stored_seeds(folder_, small_scene({"pipeline.surface.subdivisions=3"}), 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 2);
  ASSERT_EQ(again.capture.frames.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.capture.frames[i].sensors[0].color, first.capture.frames[i].sensors[0].color);
    EXPECT_EQ(again.capture.frames[i].sensors[0].reported,
              first.capture.frames[i].sensors[0].reported);
  }
  EXPECT_EQ(again.truth.scene.instances.size(), first.truth.scene.instances.size());
  ASSERT_EQ(again.timings.size(), first.timings.size());
  EXPECT_EQ(again.timings[1].wall_s, first.timings[1].wall_s);  // what it took, not the reading
}

TEST_F(CaptureStore, WhatDecidesTheImagesOrTheTruthIsRenderedAnew) {
  stored_seeds(folder_, small_scene(), 5, 1, {}, counter());
  stored_seeds(folder_, small_scene(), 6, 1, {}, counter());
  stored_seeds(folder_, small_scene(), 5, 2, {}, counter());
  stored_seeds(folder_, small_scene({"rig.read_noise_e=9"}), 5, 1, {}, counter());
  TruthNeeds depth;
  depth.depth = true;
  const SimulatedRun with_depth = stored_seeds(folder_, small_scene(), 5, 1, depth, counter());
  EXPECT_EQ(rendered_, 10);
  EXPECT_EQ(stored().size(), 5U);
  EXPECT_FALSE(with_depth.truth.images.at(0).depth_m.empty());
  const SimulatedRun again = stored_seeds(folder_, small_scene(), 5, 1, depth, counter());
  EXPECT_EQ(rendered_, 10);
  EXPECT_EQ(again.truth.images.at(1).depth_m.width(), 160);
}

TEST_F(CaptureStore, ADamagedCaptureIsNamedAndAHalfWrittenOneIsNotTaken) {
  stored_seeds(folder_, small_scene(), 5, 1, {}, counter());
  const fs::path capture = stored().at(0);
  const fs::path image = capture / "rgb" / "000001.png";
  ASSERT_TRUE(fs::exists(image));
  const std::string whole = read_file(image);
  write_file(image, whole.substr(0, whole.size() / 2));
  try {
    stored_seeds(folder_, small_scene(), 5, 1, {}, counter());
    FAIL() << "a truncated image was read";
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("000001.png"));
  }
  EXPECT_EQ(rendered_, 2);
  // A killed run leaves a ".part" folder.
  fs::rename(capture, capture.string() + ".part");
  stored_seeds(folder_, small_scene(), 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 4);
  EXPECT_EQ(stored(), std::vector<fs::path>{capture});
}

TEST_F(CaptureStore, WithoutAFolderNothingIsKept) {
  stored_seeds({}, small_scene(), 5, 1, {}, counter());
  stored_seeds({}, small_scene(), 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 4);
  EXPECT_FALSE(fs::exists(folder_));
}

}  // namespace
}  // namespace cousin
