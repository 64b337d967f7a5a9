#include "benchmarks/suites/seeds/capture_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_run.h"
#include "sim/dataset/atomic_file.h"
#include "sim/geometry/mesh_io.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

RunConfig small_scene(const std::vector<std::string>& more = {}) {
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
  /// Progress that counts the views that are rendered.
  Progress counter() {
    return [this](const std::string& what, int, int) { rendered_ += what == "render" ? 1 : 0; };
  }
  std::vector<fs::path> stored() const {
    std::vector<fs::path> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path());
    return names;
  }

  TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path() / "store";
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
  EXPECT_FALSE(first.timings.empty());
  EXPECT_TRUE(again.timings.empty());  // nothing was simulated
  // Scores of the same estimate are the same.
  Estimate estimate;
  for (const TrueView& view : first.truth.views) {
    FramePose pose;
    pose.frame = view.frame;
    pose.status = PoseStatus::ok;
    pose.camera_from_world = view.camera_from_world;
    estimate.poses.push_back(pose);
  }
  const auto rows = [&](const SimulatedRun& run) {
    return to_json({.header = {}, .scores = score_run(run.truth, estimate, {}).rows});
  };
  EXPECT_EQ(rows(again), rows(first));
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

TEST_F(CaptureStore, AnotherMeshInTheSameFileIsRenderedAnew) {
  const fs::path file = temporary_.path() / "mine.ply";
  Mesh mesh{{{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}},
            {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  write_ply(file, mesh);
  const RunConfig config = small_scene({"specimen=mesh:" + file.string()});
  stored_seeds(folder_, config, 5, 1, {}, counter());
  stored_seeds(folder_, config, 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 2);
  mesh.vertices_m[3].z() = 0.008;
  write_ply(file, mesh);
  stored_seeds(folder_, config, 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 4);
}

TEST_F(CaptureStore, WhatIsDamagedOrMissingIsNamed) {
  TruthNeeds depth;
  depth.depth = true;
  const auto stored_error = [&](const TruthNeeds& needs) {
    return error_of([&] { stored_seeds(folder_, small_scene(), 5, 1, needs, counter()); });
  };
  stored_seeds(folder_, small_scene(), 5, 1, depth, counter());
  const fs::path capture = stored().at(0);
  const fs::path image = capture / "rgb" / "000001.png";
  const std::string whole = read_file(image);
  write_file(image, whole.substr(0, whole.size() / 2));
  EXPECT_THAT(stored_error(depth), HasSubstr("000001.png"));
  write_file(image, whole);
  EXPECT_EQ(stored_error(depth), "");
  const fs::path truth = capture / "truth" / "depth" / "000001.exr";
  ASSERT_TRUE(fs::exists(truth));
  fs::remove(truth);
  EXPECT_THAT(stored_error(depth), HasSubstr(capture.string() + ": lacks a truth image"));
  fs::remove_all(capture);
  EXPECT_EQ(stored_error(depth), "");
  EXPECT_EQ(rendered_, 4);
}

TEST_F(CaptureStore, OthersMayRenderTheSameAtTheSameTime) {
  // While this run renders, another one finishes the same capture; a third was killed half way.
  const fs::path others = temporary_.path() / "others";
  stored_seeds(others, small_scene(), 5, 1, {});
  const std::string name = fs::directory_iterator(others)->path().filename().string();
  const fs::path killed = folder_ / (name + ".1_0.part");
  fs::create_directories(killed / "rgb");
  bool copied = false;
  const SimulatedRun run =
      stored_seeds(folder_, small_scene(), 5, 1, {}, [&](const std::string& what, int, int) {
        if (what != "render" || copied) return;
        fs::copy(others / name, folder_ / name, fs::copy_options::recursive);
        copied = true;
      });
  EXPECT_TRUE(copied);
  EXPECT_EQ(run.capture.frames.size(), 2U);
  EXPECT_THAT(stored(), testing::UnorderedElementsAre(folder_ / name, killed));
  const SimulatedRun again = stored_seeds(folder_, small_scene(), 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 0);
  EXPECT_EQ(again.capture.frames[1].sensors[0].color, run.capture.frames[1].sensors[0].color);
}

TEST_F(CaptureStore, WithoutAFolderNothingIsKept) {
  stored_seeds({}, small_scene(), 5, 1, {}, counter());
  stored_seeds({}, small_scene(), 5, 1, {}, counter());
  EXPECT_EQ(rendered_, 4);
  EXPECT_FALSE(fs::exists(folder_));
}

}  // namespace
}  // namespace cousin
