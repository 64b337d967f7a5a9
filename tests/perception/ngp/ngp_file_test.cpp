#include "perception/ngp/ngp_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "benchmarks/suites/splats/kept_training.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/sealed_file.h"
#include "sim/types/rng.h"
#include "tests/perception/ngp/small_field.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

struct Killed {};

class NgpFileTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    config_.iterations = 50;
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
  NgpConfig config_ = small_field_config();
};

/// A process that dies after an iteration.
std::function<void(int, int)> killed_after(int iteration) {
  return [iteration](int done, int /*all*/) {
    if (done == iteration) throw Killed{};
  };
}

void expect_same(const NgpModel& a, const NgpModel& b) {
  EXPECT_EQ(a.table, b.table);
  EXPECT_EQ(a.weights, b.weights);
  EXPECT_EQ(a.occupancy.thickness, b.occupancy.thickness);
  EXPECT_EQ(a.occupancy.filled, b.occupancy.filled);
  EXPECT_EQ(a.volume.centre_in_world_m, b.volume.centre_in_world_m);
  EXPECT_EQ(a.volume.side_m, b.volume.side_m);
  EXPECT_EQ(a.volume.cascades, b.volume.cascades);
}

TEST_F(NgpFileTest, AStoppedTrainingEndsInTheSameBytes) {
  const std::vector<NgpView> views = ball_views(5);
  const NgpTraining whole = train_ngp(views, config_);
  const NgpCheckpoint checkpoint = {folder_ / "c", 12};
  EXPECT_THROW(train_ngp(views, config_, {}, killed_after(29), checkpoint), Killed);
  int first = 0;
  const auto see = [&](int done, int /*all*/) { first = first == 0 ? done : first; };
  const NgpTraining rest = train_ngp(views, config_, {}, see, checkpoint);
  EXPECT_EQ(first, 25);  // 24 were kept
  EXPECT_EQ(rest.status, NgpStatus::ok);
  expect_same(whole.model, rest.model);
  EXPECT_EQ(whole.samples, rest.samples);
  ASSERT_EQ(rest.curve.size(), whole.curve.size());
  EXPECT_EQ(rest.curve.back().loss, whole.curve.back().loss);
  // One that is complete takes no more iterations, and still says how long it took.
  const NgpTraining again = train_ngp(views, config_, {}, killed_after(50), checkpoint);
  expect_same(whole.model, again.model);
  EXPECT_EQ(again.curve.back().wall_s, rest.curve.back().wall_s);
}

TEST_F(NgpFileTest, KeptFieldsOfTwoProcessesAreThoseOfOne) {
  const std::vector<NgpView> views = ball_views(4);
  const std::vector<int> at = {10, 30, 50};
  const KeptFieldTraining memory({});
  EXPECT_TRUE(memory.checkpoint().file.empty());
  train_ngp(views, config_, memory.snapshots(at));
  const std::vector<KeptField> whole = memory.models(at);
  const KeptFieldTraining first(folder_ / "kept");
  NgpCheckpoint often = first.checkpoint();
  often.every = 20;
  EXPECT_THROW(train_ngp(views, config_, first.snapshots(at), killed_after(25), often), Killed);
  const KeptFieldTraining second(folder_ / "kept");
  train_ngp(views, config_, second.snapshots(at), {}, often);
  const std::vector<KeptField> parts = second.models(at);
  ASSERT_EQ(whole.size(), 3u);
  ASSERT_EQ(parts.size(), 3u);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_EQ(parts[i].step, at[i]);
    EXPECT_GT(parts[i].seconds.wall_s, i == 0 ? 0 : parts[i - 1].seconds.wall_s);
    expect_same(whole[i].model, parts[i].model);
  }
  fs::remove_all(folder_ / "kept" / "30");
  EXPECT_THROW((void)second.models(at), std::runtime_error);  // 50 is there
}

TEST_F(NgpFileTest, AFieldThatWasReadDrawsTheSamePicture) {
  const std::vector<NgpView> views = ball_views(4);
  const NgpTraining training = train_ngp(views, config_);
  write_ngp(folder_ / "field", training.model);
  const NgpModel back = read_ngp(folder_ / "field");
  expect_same(training.model, back);
  const NgpImage one = render_ngp(training.model, views[1].camera, views[1].camera_from_world);
  const NgpImage two = render_ngp(back, views[1].camera, views[1].camera_from_world);
  EXPECT_TRUE(std::equal(one.color.begin(), one.color.end(), two.color.begin()));
  NgpModel endless = training.model;
  endless.volume.side_m = HUGE_VAL;
  write_ngp(folder_ / "endless", endless);
  EXPECT_THROW(read_ngp(folder_ / "endless"), std::runtime_error);
}

TEST_F(NgpFileTest, CheckpointsOfOtherTrainingsAreRefusedOrReplaced) {
  std::vector<NgpView> views = ball_views(3);
  config_.iterations = 6;
  const NgpTraining alone = train_ngp(views, config_);
  const NgpCheckpoint checkpoint = {folder_ / "c", 2};
  NgpConfig other = config_;
  other.seed = 7;
  train_ngp(views, other, {}, {}, checkpoint);
  EXPECT_THROW(train_ngp(views, config_, {}, {}, checkpoint), std::runtime_error);
  expect_same(train_ngp(views, config_, {}, {}, {checkpoint.file, 2, true}).model, alone.model);
  views[1].color(3, 4).g ^= 1;
  EXPECT_THROW(train_ngp(views, config_, {}, {}, checkpoint), std::runtime_error);
  write_file(checkpoint.file, "half a file");
  EXPECT_THROW(train_ngp(views, config_, {}, {}, checkpoint), std::runtime_error);
  EXPECT_THROW(train_ngp(views, config_, {}, {}, {checkpoint.file, 0}), std::invalid_argument);
}

// The sizes of its arrays are those of its own configuration.
TEST_F(NgpFileTest, ACheckpointOfAnotherModelUnderTheSameFingerprintIsRefused) {
  const std::vector<NgpView> views = ball_views(3);
  config_.iterations = 4;
  const NgpCheckpoint checkpoint = {folder_ / "c", 2};
  train_ngp(views, config_, {}, {}, checkpoint);
  const std::string fingerprint = read_ngp_training(checkpoint.file).fingerprint;
  NgpConfig small = config_;
  small.grid.levels -= 1;
  fs::remove(checkpoint.file);
  train_ngp(views, small, {}, {}, checkpoint);
  SavedNgpTraining other = read_ngp_training(checkpoint.file);
  other.fingerprint = fingerprint;
  write_ngp_training(checkpoint.file, other);
  EXPECT_THROW(train_ngp(views, config_, {}, {}, checkpoint), std::runtime_error);
  // One that has not begun has no checkpoint.
  other.state.iteration = 0;
  write_ngp_training(checkpoint.file, other);
  EXPECT_THROW((void)read_ngp_training(checkpoint.file), std::runtime_error);
}

// Sealed anew, so that not the hash but the reader must notice.
TEST_F(NgpFileTest, HostileBytesAreAnErrorThatNamesTheFile) {
  config_.iterations = 2;
  config_.grid = {2, 8, 4, 8};
  config_.occupancy_cells = 8;
  const fs::path file = folder_ / "c";
  train_ngp(ball_views(2), config_, {}, {}, {file, 1});
  const std::string line = "cousin radiance field training 1";
  const std::string body = read_sealed(file, line, "checkpoint", std::size_t{1} << 24);
  Rng rng(5);
  int refused = 0;
  constexpr int kTries = 300;
  for (int i = 0; i < kTries; ++i) {
    std::string other = body;
    // Most of the file is numbers that may have any value: sizes and the text are at the front.
    const std::size_t at = uniform_index(rng, i % 2 ? 1200 : body.size());
    other[at] = static_cast<char>(uniform_index(rng, 256));
    if (i % 5 == 0) other.resize(uniform_index(rng, body.size()));
    write_sealed(file, line + "\n" + other);
    try {
      (void)read_ngp_training(file);
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(file.string()));
      ++refused;
    }
  }
  EXPECT_GT(refused, kTries / 5);
  EXPECT_LT(refused, kTries);
  write_sealed(file, line + "\n" + body + "x");
  EXPECT_THROW(read_ngp_training(file), std::runtime_error);
}

}  // namespace
}  // namespace cousin
