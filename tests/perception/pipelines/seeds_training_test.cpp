// Trainings of Gaussians in the seeds' chain: what they learn, what they leave out, how they end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/pipelines/seeds.h"
#include "perception/splats/splat_render.h"
#include "tests/perception/pipelines/plate_capture.h"

namespace cousin {
namespace {

/// A chequered plate photographed from eight sides, before a green screen.
struct ChequeredPlate {
  Poses poses;
  Capture capture;
};
ChequeredPlate chequered_plate(const std::array<float, 3>& dark) {
  SplatModel truth = plate(0.01);
  for (Splat& splat : truth.splats) {
    const auto cell = [](float at_m) { return static_cast<int>(std::floor(at_m / 0.004F)); };
    const bool white = ((cell(splat.centre_m.x()) + cell(splat.centre_m.y())) & 1) != 0;
    splat.sh_dc = white ? std::array<float, 3>{1.5F, 1.5F, 1.5F} : dark;
  }
  ChequeredPlate result;
  for (int i = 0; i < 8; ++i) {
    FramePose pose = slanted(i, i * M_PI / 4);
    pose.camera.model = LensModel::pinhole;
    pose.camera.distortion = {};
    result.poses.push_back(pose);
  }
  result.capture = capture_of(result.poses, {});
  const std::array<float, 3> green = {kGreen.r / 255.0F, kGreen.g / 255.0F, kGreen.b / 255.0F};
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    const FramePose& pose = result.poses[i];
    const ColorPlanes image =
        render_splats(truth, pose.camera, pose.camera_from_world, {.background = green}).color;
    for (std::size_t p = 0; p < image.channel[0].size(); ++p) {
      const auto code = [&](std::size_t c) {
        return static_cast<std::uint8_t>(
            std::lround(255 * std::clamp(image.channel[c].data()[p], 0.0F, 1.0F)));
      };
      result.capture.frames[i].sensors[0].color.data()[p] = {code(0), code(1), code(2)};
    }
  }
  return result;
}

SplatModel trained_on(const std::vector<SplatView>& views, bool any_background) {
  SplatTrainConfig training;
  training.steps = 400;
  training.most_splats = 6000;
  training.any_background = any_background;
  training.rates.centre_first = SeedsSplatConfig{}.centre_rate;
  training.rates.centre_last = 0.01 * training.rates.centre_first;
  return train_on_views(
      views, random_start_points({-0.03, -0.03, 0.0097}, {0.03, 0.03, 0.0103}, 4000, Rng(3)), {},
      training, training.steps);
}

// Seven small photographs, and one that 17,000 wide Gaussians fill: 70 million pairs. The training
// ends at that one; what it had learned is handed over to whoever asks to be told, else there is
// none.
TEST(SeedsSplats, ATrainingLeftEarlyTellsAndKeepsItsModel) {
  std::vector<SplatView> views(8);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const int size_px = i + 1 < views.size() ? 16 : 1024;
    const double middle_px = 0.5 * (size_px - 1);
    views[i].full.camera = {LensModel::pinhole, size_px,   size_px,   0.6 * size_px,
                            0.6 * size_px,      middle_px, middle_px, {}};
    for (Image<float>& channel : views[i].full.color.channel)
      channel = Image<float>(size_px, size_px, 0.5F);
  }
  const std::vector<StartPoint> from(17'000, StartPoint{{0, 0, 3}});  // in one place
  SplatStartConfig wide;
  wide.alone_m = 20;
  SplatTrainConfig training;
  training.steps = 8;
  training.report_every = 1;
  training.growth = SplatGrowth::fixed;
  training.quarter_until = training.half_until = 0;
  std::string why;
  SplatWatch watch;
  watch.left_early = [&](const std::string& reason) { why = reason; };
  const SplatModel kept = train_on_views(views, from, wide, training, 8, watch);
  EXPECT_EQ(kept.splats.size(), from.size());
  EXPECT_THAT(why, testing::HasSubstr("of 8: "));
  const SplatModel none = train_on_views(views, from, wide, training, 8);
  EXPECT_TRUE(none.splats.empty());
  EXPECT_FALSE(none.why_none.empty());
}

TEST(SeedsSplats, TrainedGaussiansShowThePhotographs) {
  const ChequeredPlate made = chequered_plate({-1, -1, 0});
  const std::vector<SplatView> views = seed_views(made.capture, made.poses, kPlateVolume, {}, 4);
  const SplatModel model = trained_on(views, false);
  ASSERT_FALSE(model.splats.empty());
  double off = 0;
  std::size_t values = 0;
  for (const SplatView& view : views) {
    const SplatViewLevel& level = view.full;
    const ColorPlanes image = render_splats(model, level.camera, view.camera_from_world).color;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t p = 0; p < image.channel[c].size(); ++p, ++values) {
        const double d = image.channel[c].data()[p] - level.color.channel[c].data()[p];
        off += d * d;
      }
    }
  }
  EXPECT_GT(-10 * std::log10(off / static_cast<double>(values)), 28) << "dB";
}

/// Mean opacity of a model where the photographs show dark parts of the scene.
double dark_opacity(const SplatModel& model, const std::vector<SplatView>& views) {
  double sum = 0, count = 0;
  for (const SplatView& view : views) {
    const SplatViewLevel& level = view.full;
    const Image<float> alpha = render_splats(model, level.camera, view.camera_from_world).alpha;
    for (std::size_t i = 0; i < alpha.size(); ++i) {
      const bool is_dark = level.behind.data()[i] == 0 && level.color.channel[1].data()[i] < 0.1F;
      if (!is_dark) continue;
      sum += alpha.data()[i];
      ++count;
    }
  }
  return sum / count;
}

TEST(SeedsSplats, WhatIsBlackIsOpaqueBeforeAnyBackground) {
  const ChequeredPlate made = chequered_plate({-1.7F, -1.7F, -1.7F});
  const std::vector<SplatView> views = seed_views(made.capture, made.poses, kPlateVolume, {}, 4);
  EXPECT_GT(dark_opacity(trained_on(views, true), views), 0.93);
  // Before black alone nothing asks for it.
  EXPECT_LT(dark_opacity(trained_on(views, false), views), 0.85);
}

TEST(SeedsSplats, OneViewInSoManyIsHeldOut) {
  SeedsSplatConfig config;
  const Poses poses = {slanted(0, 0), slanted(1, 1), slanted(2, 2), slanted(3, 3), slanted(4, 4)};
  for (const int none : {0, 1}) {
    config.hold_out_every = none;
    for (const FramePose& pose : training_poses(config, poses))
      EXPECT_EQ(pose.status, PoseStatus::ok) << none;
  }
  config.hold_out_every = 3;
  const Poses kept = training_poses(config, poses);
  for (const int frame : {0, 1, 2, 3, 4}) {
    const bool held_out = frame == 1 || frame == 4;
    EXPECT_EQ(is_held_out(config, frame), held_out) << frame;
    EXPECT_EQ(kept[static_cast<std::size_t>(frame)].status == PoseStatus::ok, !held_out) << frame;
  }
}

TEST(SeedsSplats, WhatIsHeldOutChangesNothing) {
  ChequeredPlate made = chequered_plate({-1, -1, 0});
  SeedsPipelineConfig config;
  config.method = SeedsMethod::splats_paper;
  config.splats.hold_out_every = 3;
  config.splats.reference_steps = 20;
  config.splats.reference_points = 500;
  Estimate so_far;
  so_far.poses = made.poses;
  std::vector<int> taken;
  const auto model_of = [&] {
    const SplatSnapshots snapshots{{10}, [&](const SplatTrainPoint& point, const SplatModel&) {
                                     taken.push_back(point.step);
                                   }};
    return seeds_stages(config, 1, {{}, snapshots}).splats(made.capture, so_far);
  };
  const auto bytes_of = [](const SplatModel& model) {
    std::vector<float> numbers;
    for (const Splat& splat : model.splats) {
      for (const float x : splat.centre_m) numbers.push_back(x);
      for (const float x : splat.sh_dc) numbers.push_back(x);
      numbers.push_back(splat.opacity_logit);
    }
    return numbers;
  };
  const std::vector<float> before = bytes_of(model_of());
  ASSERT_FALSE(before.empty());
  for (Rgb8& pixel : made.capture.frames[1].sensors[0].color) pixel = {255, 0, 255};
  EXPECT_EQ(bytes_of(model_of()), before);
  for (Rgb8& pixel : made.capture.frames[0].sensors[0].color) pixel = {255, 0, 255};
  EXPECT_NE(bytes_of(model_of()), before);
  EXPECT_EQ(taken, (std::vector<int>{10, 10, 10}));
}

TEST(SeedsSplats, TheReferenceIsLeftAfterTheStepsThatAreAskedFor) {
  const ChequeredPlate made = chequered_plate({-1, -1, 0});
  SeedsPipelineConfig config;
  config.method = SeedsMethod::splats_paper;
  config.splats.reference_steps = 17;
  config.splats.reference_points = 100;
  Estimate so_far;
  so_far.poses = made.poses;
  SplatWatch watch;
  int last = 0;
  watch.progress = [&](int step, int of) {
    EXPECT_EQ(of, 17);
    last = step;
  };
  seeds_stages(config, 1, watch).splats(made.capture, so_far);
  EXPECT_EQ(last, 17);
}

}  // namespace
}  // namespace cousin
