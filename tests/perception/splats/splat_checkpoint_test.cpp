#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "benchmarks/suites/splats/kept_training.h"
#include "perception/splats/splat_checkpoint_io.h"
#include "perception/splats/splat_ply.h"
#include "perception/splats/train_splats.h"
#include "sim/dataset/atomic_file.h"
#include "tests/perception/splats/small_training.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

class SplatCheckpointTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(SplatCheckpointTest, AStoppedTrainingEndsInTheSameBytes) {
  const std::vector<SplatView> views = views_of(true_model(), 5);
  for (const SplatGrowth growth : {SplatGrowth::budgeted, SplatGrowth::mcmc}) {
    const SplatTrainConfig config = quick_config(growth);
    const SplatTraining whole = train_splats(views, start_model(150), config);
    const SplatCheckpoint checkpoint = {folder_ / std::to_string(static_cast<int>(growth)), 33};
    const auto stop_at = [](int step) {
      return [step](const SplatTrainPoint& point) { return point.step < step; };
    };
    const SplatTraining part =
        train_splats(views, start_model(150), config, stop_at(80), checkpoint);
    EXPECT_EQ(part.status, SplatTrainStatus::stopped);
    const SplatTraining rest = train_splats(views, start_model(150), config, {}, checkpoint);
    EXPECT_EQ(rest.status, SplatTrainStatus::ok);
    EXPECT_TRUE(same_bytes(whole.model, rest.model));
    ASSERT_EQ(rest.curve.size(), whole.curve.size());
    for (std::size_t i = 0; i < rest.curve.size(); ++i) {
      EXPECT_EQ(rest.curve[i].loss, whole.curve[i].loss);
    }
  }
}

// Its extent and what is too near follow from Gaussians of earlier steps.
TEST_F(SplatCheckpointTest, OneViewOfAFixedNumberGoesOnInTheSameBytes) {
  const std::vector<SplatView> views = views_of(true_model(), 1);
  const SplatTrainConfig config = quick_config(SplatGrowth::fixed);
  const SplatTraining whole = train_splats(views, start_model(150), config);
  const SplatCheckpoint checkpoint = {folder_ / "c", 33};
  const auto stop = [](const SplatTrainPoint& point) { return point.step < 80; };
  const SplatTraining part = train_splats(views, start_model(150), config, stop, checkpoint);
  EXPECT_EQ(part.status, SplatTrainStatus::stopped);
  EXPECT_TRUE(
      same_bytes(whole.model, train_splats(views, start_model(150), config, {}, checkpoint).model));
}

// The reference's schedule is left early: whoever asks again after that gets the same model.
TEST_F(SplatCheckpointTest, ATrainingThatWasLeftTakesNoMoreSteps) {
  const std::vector<SplatView> views = views_of(true_model(), 5);
  const SplatTrainConfig config = quick_config(SplatGrowth::budgeted);
  const SplatCheckpoint checkpoint = {folder_ / "c", 33};
  const auto leave = [](const SplatTrainPoint& point) { return point.step < 80; };
  const SplatTraining left = train_splats(views, start_model(150), config, leave, checkpoint);
  const SplatTraining again = train_splats(views, start_model(150), config, leave, checkpoint);
  EXPECT_EQ(again.status, SplatTrainStatus::stopped);
  EXPECT_EQ(again.seconds.total, 0);
  ASSERT_EQ(again.curve.size(), left.curve.size());
  EXPECT_EQ(again.curve.back().step, left.curve.back().step);
  EXPECT_EQ(again.curve.back().wall_s, left.curve.back().wall_s);
  EXPECT_EQ(again.curve.back().cpu_s, left.curve.back().cpu_s);
  ASSERT_EQ(again.model.splats.size(), left.model.splats.size());
  for (std::size_t i = 0; i < left.model.splats.size(); ++i) {
    EXPECT_EQ(again.model.splats[i].centre_m, left.model.splats[i].centre_m);
    EXPECT_EQ(again.model.splats[i].sh_rest, left.model.splats[i].sh_rest);
  }
}

// Whoever asks for fewer steps than were taken gets no model of more.
TEST_F(SplatCheckpointTest, ATrainingThatIsToBeLeftEarlierBeginsAnew) {
  const std::vector<SplatView> views = views_of(true_model(), 5);
  const SplatTrainConfig config = quick_config(SplatGrowth::budgeted);
  const auto leave_at = [](int step) {
    return [step](const SplatTrainPoint& point) { return point.step < step; };
  };
  const SplatCheckpoint checkpoint = {folder_ / "c", 33, true, 40};
  const SplatTraining alone = train_splats(views, start_model(150), config, leave_at(40));
  (void)train_splats(views, start_model(150), config, leave_at(80), {folder_ / "c", 33});
  EXPECT_THROW(
      train_splats(views, start_model(150), config, leave_at(40), {folder_ / "c", 33, false, 40}),
      std::runtime_error);
  const SplatTraining again =
      train_splats(views, start_model(150), config, leave_at(40), checkpoint);
  EXPECT_EQ(again.curve.back().step, 40);
  EXPECT_TRUE(same_bytes(alone.model, again.model));
}

// Its models are not those of the training before it in the same folder.
TEST_F(SplatCheckpointTest, AnotherTrainingForgetsWhatWasKept) {
  SplatTrainConfig config = quick_config(SplatGrowth::fixed);
  const std::vector<int> at = {20, 60, 100};
  const KeptTraining kept(folder_ / "kept");
  (void)train_splats(views_of(true_model(), 4), start_model(60), config, {}, kept.checkpoint(),
                     kept.snapshots(at));
  EXPECT_EQ(kept.models(at).size(), 3U);
  config.steps = 40;
  const SplatTraining second = train_splats(views_of(true_model(), 3), start_model(60), config, {},
                                            kept.checkpoint(), kept.snapshots(at));
  EXPECT_EQ(kept.models(at).size(), 1U);
  EXPECT_GT(second.seconds.kept, 0);
}

TEST_F(SplatCheckpointTest, ForeignAndDamagedOnesAreReplacedWhereThatIsAskedFor) {
  const std::vector<SplatView> views = views_of(true_model(), 3);
  SplatTrainConfig config = quick_config(SplatGrowth::fixed);
  config.steps = 6;
  const SplatTraining alone = train_splats(views, start_model(20), config);
  const SplatCheckpoint checkpoint = {folder_ / "c", 2, true};
  config.steps = 4;
  (void)train_splats(views, start_model(20), config, {}, checkpoint);
  config.steps = 6;
  EXPECT_TRUE(
      same_bytes(train_splats(views, start_model(20), config, {}, checkpoint).model, alone.model));
  std::ofstream(checkpoint.file, std::ios::binary) << "half a file";
  EXPECT_TRUE(
      same_bytes(train_splats(views, start_model(20), config, {}, checkpoint).model, alone.model));
  // What was written in its place is a checkpoint of this training.
  EXPECT_EQ(train_splats(views, start_model(20), config, {}, {checkpoint.file, 2}).seconds.total,
            0);
}

// A process that dies between two steps: what it had kept and what the next one keeps are together
// what one process would have.
TEST_F(SplatCheckpointTest, KeptModelsOfTwoProcessesAreThoseOfOne) {
  const std::vector<SplatView> views = views_of(true_model(), 4);
  SplatTrainConfig config = quick_config(SplatGrowth::budgeted);
  const std::vector<int> at = {20, 60, 100};
  const KeptTraining memory({});
  EXPECT_TRUE(memory.checkpoint().file.empty());
  (void)train_splats(views, start_model(60), config, {}, memory.checkpoint(), memory.snapshots(at));
  const std::vector<KeptModel> whole = memory.models(at);
  const auto stop = [](const SplatTrainPoint& point) { return point.step < 60; };
  const KeptTraining first(folder_ / "kept");
  (void)train_splats(views, start_model(60), config, stop, first.checkpoint(), first.snapshots(at));
  EXPECT_EQ(first.models(at).size(), 2u);
  const KeptTraining second(folder_ / "kept");
  (void)train_splats(views, start_model(60), config, {}, second.checkpoint(), second.snapshots(at));
  const std::vector<KeptModel> parts = second.models(at);
  ASSERT_EQ(whole.size(), 3u);
  ASSERT_EQ(parts.size(), 3u);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(parts[i].step, at[i]);
    EXPECT_GT(parts[i].seconds.wall_s, i == 0 ? 0 : parts[i - 1].seconds.wall_s);
    EXPECT_GE(parts[i].seconds.cpu_s, i == 0 ? 0 : parts[i - 1].seconds.cpu_s);
    EXPECT_GT(parts[i].seconds.peak_rss_mb, 0);
    write_splat_ply(folder_ / "whole.ply", whole[i].model);
    write_splat_ply(folder_ / "parts.ply", parts[i].model);
    EXPECT_EQ(read_file(folder_ / "whole.ply"), read_file(folder_ / "parts.ply"));
  }
  fs::remove_all(folder_ / "kept" / "60");
  EXPECT_THROW((void)second.models(at), std::runtime_error);  // 100 is there
}

// Sealed anew, so that not the hash but the reader must notice.
TEST_F(SplatCheckpointTest, CountsThatNoTrainingHasAreRefused) {
  SplatTrainConfig config = quick_config(SplatGrowth::fixed);
  config.steps = 6;
  const fs::path file = folder_ / "c";
  (void)train_splats(views_of(true_model(), 3), start_model(20), config, {}, {file, 2});
  const SavedTraining good = read_training(file, 20);
  EXPECT_EQ(good.state.step, 6);
  const auto refused = [&](auto change) {
    SavedTraining other = good;
    change(other);
    write_training(file, other);
    try {
      (void)read_training(file, 20);
    } catch (const std::runtime_error& error) {
      return std::string(error.what()).find(file.string()) != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.step = -1000000; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.step = 0; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.step = 2000000; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.rest_updates = 7; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.started_with = 21; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.loss_count = -1; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.near_m[0] = -1; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.near_m[1] = std::nan(""); }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.extent_m = HUGE_VAL; }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.state.origin_in_world_m.y() = std::nan(""); }));
  EXPECT_TRUE(refused([](SavedTraining& s) { s.blind = 7; }));
  EXPECT_FALSE(refused([](SavedTraining&) {}));
}

// The same status again and again, not another after each call.
TEST_F(SplatCheckpointTest, ATrainingThatSawOrLeftNothingSaysSoAgain) {
  std::vector<SplatView> views = views_of(true_model(), 3);
  SplatTrainConfig config = quick_config(SplatGrowth::budgeted);
  std::vector<SplatView> away = views;
  for (SplatView& view : away) view.camera_from_world = look_at({5, 0, 0}, {9, 0, 0});
  for (int call = 0; call < 3; ++call) {
    const SplatTraining seen =
        train_splats(away, start_model(9), config, {}, {folder_ / "away", 1000});
    EXPECT_EQ(seen.status, SplatTrainStatus::nothing_seen) << call;
    if (call > 0) EXPECT_EQ(seen.seconds.total, 0);
  }
  // Black photographs, of which nothing is the best model.
  for (SplatView& view : views) {
    for (Image<float>& channel : view.full.color.channel)
      std::fill(channel.begin(), channel.end(), 0.0F);
  }
  SplatModel start = start_model(9);
  for (Splat& splat : start.splats) splat.opacity_logit = -5.2F;
  config.steps = 4000;
  const auto train = [&] {
    return train_splats(views, start, config, {}, {folder_ / "black", 100000}).status;
  };
  const SplatTrainStatus first = train();
  EXPECT_EQ(first, SplatTrainStatus::nothing_left);
  EXPECT_EQ(train(), first);
}

TEST_F(SplatCheckpointTest, DamagedAndForeignOnesAreRefused) {
  const std::vector<SplatView> views = views_of(true_model(), 3);
  SplatTrainConfig config = quick_config(SplatGrowth::fixed);
  config.steps = 4;
  const SplatCheckpoint checkpoint = {folder_ / "c", 2};
  (void)train_splats(views, start_model(20), config, {}, checkpoint);
  config.steps = 5;
  EXPECT_THROW((void)train_splats(views, start_model(20), config, {}, checkpoint),
               std::runtime_error);
  config.steps = 4;
  std::string bytes;
  {
    std::ifstream in(checkpoint.file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (const std::size_t cut :
       {std::size_t{0}, std::size_t{30}, bytes.size() / 2, bytes.size() - 1}) {
    std::ofstream(checkpoint.file, std::ios::binary) << bytes.substr(0, cut);
    EXPECT_THROW((void)train_splats(views, start_model(20), config, {}, checkpoint),
                 std::runtime_error);
  }
  std::string altered = bytes;
  altered[bytes.size() / 2] ^= 1;
  std::ofstream(checkpoint.file, std::ios::binary) << altered;
  EXPECT_THROW((void)train_splats(views, start_model(20), config, {}, checkpoint),
               std::runtime_error);
}

}  // namespace
}  // namespace cousin
