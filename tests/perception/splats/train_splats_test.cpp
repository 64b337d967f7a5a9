#include "perception/splats/train_splats.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "perception/splats/splat_render.h"
#include "tests/perception/splats/random_splats.h"
#include "tests/perception/splats/small_training.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

bool all_finite(const SplatModel& model) {
  return std::all_of(model.splats.begin(), model.splats.end(), is_finite);
}

constexpr SplatGrowth kKinds[] = {SplatGrowth::fixed, SplatGrowth::adaptive, SplatGrowth::budgeted,
                                  SplatGrowth::mcmc};

// Black pixels would leave most of the loss that the first point of the curve has.
TEST(TrainSplats, EveryKindOfGrowthBringsTheLossDown) {
  const std::vector<SplatView> views = views_of(true_model(), 9);
  for (const SplatGrowth growth : kKinds) {
    const SplatTraining training = train_splats(views, start_model(150), quick_config(growth));
    EXPECT_EQ(training.status, SplatTrainStatus::ok);
    ASSERT_EQ(training.curve.size(), 8u);
    EXPECT_LT(training.curve.back().loss, 0.6 * training.curve.front().loss)
        << static_cast<int>(growth);
    EXPECT_TRUE(all_finite(training.model));
    EXPECT_LE(training.model.splats.size(), 300u);
    EXPECT_EQ(training.model.views_seen.size(), training.model.splats.size());
  }
}

// Steps, sizes that part and noise are shares of the scene's extent.
TEST(TrainSplats, TheUnitOfLengthChangesNoKindOfGrowth) {
  constexpr float kUnits = 1000;
  std::vector<SplatView> views = views_of(true_model(), 6);
  std::vector<SplatView> large = views;
  for (SplatView& view : large) view.camera_from_world.translation_m *= kUnits;
  SplatModel start = start_model(150), large_start = start_model(150);
  for (Splat& splat : large_start.splats) {
    splat.centre_m *= kUnits;
    splat.log_scale.array() += std::log(kUnits);
  }
  for (const SplatGrowth growth : kKinds) {
    const SplatTrainConfig config = quick_config(growth);
    const double metres = train_splats(views, start, config).curve.back().loss;
    const double units = train_splats(large, large_start, config).curve.back().loss;
    EXPECT_NEAR(units / metres, 1, 0.1) << static_cast<int>(growth);
  }
}

TEST(TrainSplats, GrowthReachesItsBudget) {
  const std::vector<SplatView> views = views_of(true_model(), 6);
  for (const SplatGrowth growth : {SplatGrowth::budgeted, SplatGrowth::mcmc}) {
    SplatTrainConfig config = quick_config(growth);
    config.most_splats = 180;
    const SplatTraining training = train_splats(views, start_model(150), config);
    EXPECT_GT(training.model.splats.size(), 165u) << static_cast<int>(growth);
    EXPECT_LE(training.model.splats.size(), 180u) << static_cast<int>(growth);
  }
}

// Nothing in any photograph speaks for them: only the pulls can make them faint, and where those
// held at what a view shows alone, a third of what was born was born out of sight.
TEST(TrainSplats, ByMcmcWhatNoViewSeesDies) {
  const std::vector<SplatView> views = views_of(true_model(), 9);
  SplatModel start = start_model(150);
  for (Splat s : start_model(150).splats) {
    s.centre_m.z() += 8;  // above all cameras
    start.splats.push_back(s);
  }
  SplatTrainConfig config = quick_config(SplatGrowth::mcmc);
  config.steps = 400;
  config.most_splats = 500;
  config.grow_until = 0.9;
  config.noise = 0;  // else faint ones stray there from where they were seen
  const SplatTraining training = train_splats(views, start, config);
  int unseen = 0;
  for (const Splat& s : training.model.splats) unseen += s.centre_m.z() > 5 ? 1 : 0;
  EXPECT_GT(training.model.splats.size(), 400u);
  EXPECT_EQ(unseen, 0);
}

TEST(TrainSplats, SnapshotsChangeNoByteAndTheirSecondsDoNotCount) {
  const std::vector<SplatView> views = views_of(true_model(), 5);
  constexpr double kPause_s = 0.2;
  for (const SplatGrowth growth : kKinds) {
    const SplatTrainConfig config = quick_config(growth);
    const SplatTraining alone = train_splats(views, start_model(80), config);
    std::vector<int> steps;
    std::vector<double> seconds;
    SplatModel last;
    const SplatTraining watched =
        train_splats(views, start_model(80), config, {}, {},
                     {{7, 160, 900}, [&](const SplatTrainPoint& point, const SplatModel& model) {
                        steps.push_back(point.step);
                        seconds.push_back(point.wall_s);
                        EXPECT_EQ(point.splats, static_cast<int>(model.splats.size()));
                        EXPECT_GT(point.cpu_s, 0);
                        last = model;
                        std::this_thread::sleep_for(std::chrono::duration<double>(kPause_s));
                      }});
    EXPECT_TRUE(same_bytes(alone.model, watched.model)) << static_cast<int>(growth);
    EXPECT_EQ(steps, (std::vector<int>{7, 160}));
    ASSERT_EQ(last.splats.size(), watched.model.splats.size());
    for (std::size_t i = 0; i < last.splats.size(); ++i) {
      EXPECT_EQ(last.splats[i].centre_m, watched.model.splats[i].centre_m);
      EXPECT_EQ(last.splats[i].sh_rest, watched.model.splats[i].sh_rest);
    }
    // Of its own clock: the pause after step 7 is not in the seconds of step 160.
    EXPECT_GT(seconds.front(), 0);
    EXPECT_EQ(seconds.back(), watched.seconds.total);
    EXPECT_EQ(seconds.back(), watched.curve.back().wall_s);
  }
}

// The reference scores its images before it parts Gaussians and resets opacities.
TEST(TrainSplats, SnapshotsAreTakenBeforeGrowthAndReset) {
  const std::vector<SplatView> views = views_of(true_model(), 5);
  SplatTrainConfig config = quick_config(SplatGrowth::adaptive);
  config.steps = 60;
  config.grow_from = 0.1;
  config.grow_until = 1;
  config.reset_every = 0.5;
  std::vector<std::size_t> counts;
  std::vector<float> largest;
  (void)train_splats(views, start_model(80), config, {}, {},
                     {{20, 21, 30, 31}, [&](const SplatTrainPoint&, const SplatModel& model) {
                        counts.push_back(model.splats.size());
                        float logit = -99;
                        for (const Splat& s : model.splats)
                          logit = std::max(logit, s.opacity_logit);
                        largest.push_back(1 / (1 + std::exp(-logit)));
                      }});
  ASSERT_EQ(counts.size(), 4u);
  EXPECT_EQ(counts[0], 80u);
  EXPECT_GT(counts[1], 80u);
  EXPECT_GT(largest[2], 0.1F);
  EXPECT_LT(largest[3], 0.012F);  // a hundredth, and one step
}

// What goes on from a checkpoint is told the seconds of before too.
TEST(TrainSplats, SnapshotsGoOnWithTheTraining) {
  const std::vector<SplatView> views = views_of(true_model(), 5);
  const SplatTrainConfig config = quick_config(SplatGrowth::budgeted);
  const fs::path file = fs::path(testing::TempDir()) / "splat_snapshots.checkpoint";
  fs::remove(file);
  const auto stop = [](const SplatTrainPoint& point) { return point.step < 80; };
  (void)train_splats(views, start_model(80), config, stop, {file, 40});
  std::vector<double> seconds;
  const SplatTraining rest = train_splats(
      views, start_model(80), config, {}, {file, 40},
      {{40, 100},
       [&](const SplatTrainPoint& point, const SplatModel&) { seconds.push_back(point.wall_s); }});
  ASSERT_EQ(seconds.size(), 1u);  // step 40 was before
  ASSERT_EQ(rest.curve.size(), 8u);
  EXPECT_GE(seconds[0], rest.curve[3].wall_s);
  EXPECT_LE(seconds[0], rest.curve[4].wall_s);
  fs::remove(file);
}

TEST(TrainSplats, BytesDoNotDependOnThreads) {
  const std::vector<SplatView> views = views_of(true_model(), 5);
  for (const SplatGrowth growth : kKinds) {
    const auto with_threads = [&](std::size_t threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      SplatTrainConfig config = quick_config(growth);
      config.steps = 60;
      return train_splats(views, start_model(150), config).model;
    };
    EXPECT_TRUE(same_bytes(with_threads(1), with_threads(8))) << static_cast<int>(growth);
  }
}

TEST(TrainSplats, WhatCannotBeTrainedSaysSo) {
  const SplatTrainConfig config = quick_config(SplatGrowth::budgeted);
  std::vector<SplatView> views = views_of(true_model(), 3);
  EXPECT_EQ(train_splats({}, start_model(9), config).status, SplatTrainStatus::no_views);
  EXPECT_EQ(train_splats(views, {}, config).status, SplatTrainStatus::no_start);
  SplatModel broken = start_model(3);
  for (Splat& s : broken.splats) s.centre_m[1] = NAN;
  EXPECT_EQ(train_splats(views, broken, config).status, SplatTrainStatus::no_start);
  // Cameras that look away.
  std::vector<SplatView> away = views;
  for (SplatView& view : away) view.camera_from_world = look_at({5, 0, 0}, {9, 0, 0});
  EXPECT_EQ(train_splats(away, start_model(9), config).status, SplatTrainStatus::nothing_seen);
  SplatTrainConfig short_one = config;  // each view once and no more
  short_one.steps = 3;
  EXPECT_EQ(train_splats(away, start_model(9), short_one).status, SplatTrainStatus::nothing_seen);
  EXPECT_EQ(train_splats(views, start_model(9), short_one).status, SplatTrainStatus::ok);
  // Masks that hide all.
  for (SplatView& view : views) {
    view.full.weight = Image<float>(view.full.camera.width_px, view.full.camera.height_px, 0.0F);
  }
  EXPECT_EQ(train_splats(views, start_model(9), config).status, SplatTrainStatus::nothing_to_learn);
}

// 70 million pairs: lists and derivatives would be 4 GB, and are not made before they are refused.
TEST(TrainSplats, GaussiansThatCoverTooManyTilesAreAStatus) {
  SplatView view;
  view.camera_from_world = look_at({0, 0, 0}, {1, 0, 0});
  view.full.camera = pinhole(1024, 1024, 600);
  for (Image<float>& channel : view.full.color.channel) channel = Image<float>(1024, 1024, 0.5F);
  SplatModel start;
  start.splats.resize(17'000);
  for (Splat& splat : start.splats) {
    splat.centre_m = {3, 0, 0};
    splat.log_scale.setConstant(3);
  }
  SplatTrainConfig config = quick_config(SplatGrowth::fixed);
  config.half_until = 0;
  const SplatTraining training = train_splats(std::vector<SplatView>{view}, start, config);
  EXPECT_EQ(training.status, SplatTrainStatus::too_many_pairs);
  EXPECT_EQ(training.model.splats.size(), start.splats.size());
  EXPECT_TRUE(training.model.views_seen.empty());
}

TEST(TrainSplats, ExtremeViewsGiveFiniteModels) {
  const std::vector<SplatView> good = views_of(true_model(), 4);
  std::vector<std::vector<SplatView>> cases;
  cases.push_back({good[0]});                             // one view
  cases.push_back({good[1], good[1], good[1], good[1]});  // the same one again
  std::vector<SplatView> black = good;
  for (SplatView& view : black) {
    for (Image<float>& channel : view.full.color.channel)
      std::fill(channel.begin(), channel.end(), 0.0F);
  }
  cases.push_back(black);
  std::vector<SplatView> wrong = good;  // photographs with each other's poses
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    wrong[i].camera_from_world = good[(i + 1) % 4].camera_from_world;
  }
  cases.push_back(wrong);
  std::vector<SplatView> one_hidden = good;  // one mask is empty
  SplatViewLevel& hidden = one_hidden[2].full;
  hidden.weight = Image<float>(hidden.camera.width_px, hidden.camera.height_px, 0.0F);
  cases.push_back(one_hidden);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (const SplatGrowth growth : kKinds) {
      SplatTrainConfig config = quick_config(growth);
      config.reset_every = 0.3;
      const SplatTraining training = train_splats(cases[i], start_model(100), config);
      const bool is_black = i == 2;  // no Gaussian at all is right
      EXPECT_TRUE(training.status == SplatTrainStatus::ok ||
                  (is_black && training.status == SplatTrainStatus::nothing_left))
          << i << to_string(training.status);
      EXPECT_TRUE(all_finite(training.model)) << i;
    }
  }
}

TEST(TrainSplats, PixelsOfNoWeightAreNotLearned) {
  // Half of every photograph is white noise that the weights hide.
  std::vector<SplatView> views = views_of(true_model(), 6);
  const std::vector<SplatView> clean = views;
  Rng rng(3);
  for (SplatView& view : views) {
    SplatViewLevel& full = view.full;
    full.weight = Image<float>(full.camera.width_px, full.camera.height_px, 1.0F);
    for (int y = 0; y < full.camera.height_px; ++y) {
      for (int x = full.camera.width_px / 2; x < full.camera.width_px; ++x) {
        full.weight(x, y) = 0;
        for (Image<float>& channel : full.color.channel)
          channel(x, y) = static_cast<float>(uniform(rng));
      }
    }
  }
  std::vector<SplatView> weighted = clean;
  for (std::size_t i = 0; i < views.size(); ++i) {
    weighted[i].full.weight = views[i].full.weight;
  }
  const SplatTrainConfig config = quick_config(SplatGrowth::fixed);
  EXPECT_TRUE(same_bytes(train_splats(views, start_model(100), config).model,
                         train_splats(weighted, start_model(100), config).model));
}

TEST(TrainSplats, ViewsAreCountedThatSeeAGaussian) {
  // One before the first camera, one behind it and so before the second, one hidden, one above.
  SplatModel model;
  model.splats.resize(4);
  const Eigen::Vector3f centres[] = {{2, 0, 0}, {-2, 0, 0}, {2.5F, 0, 0}, {0, 0, 9}};
  for (std::size_t i = 0; i < 4; ++i) {
    model.splats[i].centre_m = centres[i];
    model.splats[i].log_scale.setConstant(i == 2 ? std::log(0.01F) : 0.0F);
    model.splats[i].opacity_logit = std::log(0.97F / 0.03F);
  }
  // Two more discs before the hidden one: 0.03^3 is less than 1e-4.
  for (const float x : {2.1F, 2.2F}) {
    model.splats.push_back(model.splats[0]);
    model.splats.back().centre_m.x() = x;
  }
  std::vector<SplatView> views(3);
  for (std::size_t i = 0; i < 3; ++i) {
    views[i].camera_from_world = look_at({0, 0, 0}, {i == 1 ? -1.0 : 1.0, 0, 0});
    views[i].full = photograph(model, pinhole(64, 48, 60), views[i].camera_from_world);
  }
  SplatTrainConfig config;
  config.steps = 1;
  config.growth = SplatGrowth::fixed;
  EXPECT_EQ(train_splats(views, model, config).model.views_seen,
            (std::vector<int>{2, 1, 0, 0, 2, 2}));
}

TEST(TrainSplats, TheReferencesSettingsAreValidAndStart) {
  SplatTrainConfig config = reference_training();
  validate(config);
  // The published ones: degrees every 1000 steps, resets every 3000, growth from 500 to 15,000.
  EXPECT_EQ(config.steps / 30, 1000);
  EXPECT_DOUBLE_EQ(config.reset_every * config.steps, 3000);
  EXPECT_DOUBLE_EQ(config.grow_from * config.steps, 500);
  EXPECT_DOUBLE_EQ(config.grow_until * config.steps, 15000);
  const std::vector<SplatView> views = views_of(true_model(), 4);
  const auto stop = [](const SplatTrainPoint& point) { return point.step < 100; };
  const SplatTraining training = train_splats(views, start_model(100), config, stop);
  EXPECT_EQ(training.status, SplatTrainStatus::stopped);
  EXPECT_LT(training.curve.back().loss, training.curve.front().loss);
  EXPECT_EQ(training.model.low_pass_px2, 0.3);
}

/// Loss of a model on its own photographs, drawn with one low pass and learned with another.
double first_loss(double drawn_px2, double learned_px2) {
  SplatModel model;
  model.splats = random_splats(60, 11, 0.02);
  for (Splat& splat : model.splats) splat.sh_rest.fill(0);
  std::vector<SplatView> views = views_of(model, 1);
  SplatViewLevel& level = views[0].full;
  level.color =
      render_splats(model, level.camera, views[0].camera_from_world, {.low_pass_px2 = drawn_px2})
          .color;
  SplatTrainConfig config;
  config.steps = config.report_every = 1;
  config.growth = SplatGrowth::fixed;
  config.quarter_until = config.half_until = 0;
  config.low_pass_px2 = learned_px2;
  return train_splats(views, model, config).curve.at(0).loss;
}

TEST(TrainSplats, TheLowPassIsThatOfThePhotographs) {
  for (const double drawn_px2 : {0.03, 0.3}) {
    const double same = first_loss(drawn_px2, drawn_px2);
    const double other = first_loss(drawn_px2, 0.33 - drawn_px2);
    EXPECT_GT(other, 10 * same + 1e-3) << drawn_px2;  // 0.04: Gaussians are a pixel wide
  }
}

TEST(TrainSplats, WrongInputsAreNamed) {
  std::vector<SplatView> views = views_of(true_model(), 2);
  SplatTrainConfig config;
  config.steps = 0;
  try {
    (void)train_splats(views, start_model(5), config);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("steps = 0"), std::string::npos) << error.what();
  }
  config = {};
  config.low_pass_px2 = 0;
  EXPECT_THROW((void)train_splats(views, start_model(5), config), std::invalid_argument);
  views[1].full.color.channel[1] = Image<float>(3, 4);
  try {
    (void)train_splats(views, start_model(5), SplatTrainConfig{});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("view 1: a channel is 3 x 4"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace cousin
