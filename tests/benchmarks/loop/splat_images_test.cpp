#include "benchmarks/loop/splat_images.h"

#include <gtest/gtest.h>

#include <limits>

namespace cousin {
namespace {

/// A grey photograph whose columns brighten.
ScoredPhotograph photograph(int width, int height, bool held_out) {
  SplatViewLevel level;
  level.camera.width_px = width;
  level.camera.height_px = height;
  level.camera.fx_px = level.camera.fy_px = 50;
  level.camera.cx_px = 7;
  level.camera.cy_px = 4;
  for (Image<float>& channel : level.color.channel) {
    channel = Image<float>(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) channel(x, y) = 0.01F * static_cast<float>(x);
  }
  level.weight = Image<float>(width, height, 1);
  level.weight(0, 0) = 0;
  ScoredPhotograph result;
  result.view.full = level;
  result.held_out = held_out;
  return result;
}

double value_of(const std::vector<ScoreRow>& rows, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.metric == metric) return row.value;
  }
  return kNaN;
}

TEST(SplatImages, ASmallPhotographShowsTheSameRays) {
  const ScoredPhotograph large = photograph(14, 9, false);
  const ScoredPhotograph made = made_small(large);
  const SplatViewLevel& level = made.view.full;
  ASSERT_EQ(level.camera.width_px, 4);
  ASSERT_EQ(level.camera.height_px, 3);
  for (const Image<float>& channel : level.color.channel) {
    // Squares of three columns around 1, 4, 7 and 10.
    for (int x = 0; x < 4; ++x) EXPECT_NEAR(channel(x, 1), 0.01 * (1 + 3 * x), 1e-6);
  }
  const Lens before(large.view.full.camera), after(level.camera);
  EXPECT_TRUE(after.unproject({2, 1})->normalized().isApprox(before.unproject({7, 4})->normalized(),
                                                             1e-12));
  EXPECT_LT(level.weight(0, 0), 0.95F);
  EXPECT_FLOAT_EQ(level.weight(1, 0), 1);
}

TEST(SplatImages, PixelsOfNoWeightDoNotCount) {
  std::vector<ScoredPhotograph> photographs = {photograph(30, 30, false)};
  const auto render = [&](const Camera&, const Pose&) {
    FidelityPlanes image = photographs[0].view.full.color.channel;
    for (Image<float>& channel : image) {
      for (float& value : channel) value += 0.1F;
      channel(0, 0) = 1;
    }
    return image;
  };
  const std::vector<ScoreRow> rows = photograph_rows(photographs, render, {}, nullptr);
  EXPECT_NEAR(value_of(rows, "train.psnr"), 20, 1e-4);
  EXPECT_NEAR(value_of(rows, "train.psnr_whole_small"), 20, 1e-4);
  // Neither do windows and filters see what is drawn there.
  const auto other = [&](const Camera& camera, const Pose& pose) {
    FidelityPlanes image = render(camera, pose);
    for (Image<float>& channel : image) channel(0, 0) = 0;
    return image;
  };
  const std::vector<ScoreRow> same = photograph_rows(photographs, other, {}, nullptr);
  EXPECT_EQ(value_of(rows, "train.ssim"), value_of(same, "train.ssim"));
  EXPECT_EQ(value_of(rows, "train.flip"), value_of(same, "train.flip"));
}

TEST(SplatImages, WhatIsOfTheObjectDoesNotSeeTheScreen) {
  std::vector<ScoredPhotograph> photographs = {photograph(30, 30, false)};
  SplatViewLevel& level = photographs[0].view.full;
  level.behind = Image<float>(30, 30, 0.0F);
  for (int y = 0; y < 30; ++y)
    for (int x = 15; x < 30; ++x) level.behind(x, y) = 1;
  const auto drawn = [&](float on_object, float on_screen) {
    return photograph_rows(
        photographs,
        [=](const Camera& camera, const Pose&) {
          FidelityPlanes image;
          for (Image<float>& channel : image) {
            channel = Image<float>(camera.width_px, camera.height_px);
            for (int y = 0; y < camera.height_px; ++y)
              for (int x = 0; x < camera.width_px; ++x)
                channel(x, y) = 0.01F * static_cast<float>(x) + (x < 15 ? on_object : on_screen);
          }
          return image;
        },
        {}, nullptr);
  };
  const std::vector<ScoreRow> clean = drawn(0.1F, 0), noisy_screen = drawn(0.1F, 0.4F);
  EXPECT_NEAR(value_of(clean, "train.psnr_object"), 20, 1e-3);
  for (const char* metric : {"train.psnr_object", "train.ssim_object", "train.flip_object"})
    EXPECT_EQ(value_of(clean, metric), value_of(noisy_screen, metric)) << metric;
  EXPECT_LT(value_of(noisy_screen, "train.ssim"), value_of(clean, "train.ssim"));
  EXPECT_GT(value_of(noisy_screen, "train.flip"), value_of(clean, "train.flip"));
  const std::vector<ScoreRow> worse = drawn(0.3F, 0);
  EXPECT_LT(value_of(worse, "train.ssim_object"), value_of(clean, "train.ssim_object"));
  EXPECT_GT(value_of(worse, "train.flip_object"), value_of(clean, "train.flip_object"));
}

TEST(SplatImages, ViewsHeldOutHaveRowsOfTheirOwn) {
  std::vector<ScoredPhotograph> photographs = {photograph(30, 30, false)};
  // An image that is 0.1 too bright everywhere: 20 dB.
  const auto render = [](const Camera& camera, const Pose&) {
    FidelityPlanes image;
    for (Image<float>& channel : image) {
      channel = Image<float>(camera.width_px, camera.height_px);
      for (int y = 0; y < camera.height_px; ++y)
        for (int x = 0; x < camera.width_px; ++x)
          channel(x, y) = 0.1F + 0.01F * static_cast<float>(x);
    }
    return image;
  };
  // Of a photograph three times as high the rest is drawn too, and charged with as much.
  const ScoredPhotograph high = photograph(30, 90, false);
  photographs[0].whole = high.view;
  const auto bright_below = [&](const Camera& camera, const Pose& pose) {
    FidelityPlanes image = render(camera, pose);
    for (Image<float>& channel : image)
      for (int y = 30; y < camera.height_px; ++y)
        for (int x = 0; x < camera.width_px; ++x) channel(x, y) += 0.4F;
    return image;
  };
  const double charged =
      value_of(photograph_rows(photographs, bright_below, {}, nullptr), "train.psnr_whole");
  EXPECT_NEAR(charged, -10 * std::log10((899 * 0.01 + 1800 * 0.25) / 2699.0), 1e-4);
  const std::vector<ScoreRow> beyond = photograph_rows(photographs, bright_below, {}, nullptr);
  EXPECT_LT(value_of(beyond, "train.ssim_whole"), value_of(beyond, "train.ssim") - 0.01);
  EXPECT_GT(value_of(beyond, "train.flip_whole"), value_of(beyond, "train.flip") + 0.01);
  const std::vector<ScoreRow> trained = photograph_rows(photographs, render, {}, nullptr);
  EXPECT_NEAR(value_of(trained, "train.psnr"), 20, 1e-4);
  EXPECT_NEAR(value_of(trained, "train.psnr_whole"), 20, 1e-4);
  EXPECT_NEAR(value_of(trained, "train.psnr_whole_small"), 20, 1e-4);
  EXPECT_TRUE(std::isnan(value_of(trained, "held_out.psnr")));
  // An image with a pixel that is no number has no score, and is not left out of the mean either.
  std::vector<ScoredPhotograph> two = {photograph(30, 30, false), photograph(30, 30, false)};
  int drawn = 0;
  const auto holed = [&](const Camera& camera, const Pose& pose) {
    FidelityPlanes image = render(camera, pose);
    if (drawn++ == 0) image[0](3, 3) = std::numeric_limits<float>::quiet_NaN();
    return image;
  };
  const std::vector<ScoreRow> nothing = photograph_rows(two, holed, {}, nullptr);
  EXPECT_TRUE(std::isnan(value_of(nothing, "train.psnr")));
  photographs.push_back(photograph(30, 30, true));
  const std::vector<ScoreRow> both = photograph_rows(photographs, render, {}, nullptr);
  EXPECT_NEAR(value_of(both, "train.psnr_whole"), 20, 1e-4);
  EXPECT_NEAR(value_of(both, "held_out.psnr_whole"), 20, 1e-4);
}

}  // namespace
}  // namespace cousin
