#include "perception/stereo/stereo_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>

#include "perception/stereo/stereo_pair.h"
#include "tests/perception/stereo/drawn_pair.h"

namespace cousin {
namespace {

using testing::HasSubstr;

/// What becomes of the left pixels' disparities.
struct Found {
  double measured = 0;   ///< share of the pixels that both images show
  double bad_1_px = 0;   ///< share of the measured ones
  double median_px = 0;  ///< of the absolute errors
  double within_95 = 0;  ///< share of errors within 1.96 sigma; wrong matches count
  double hidden = 0;     ///< share of the pixels that one image shows, that have a disparity
};

Found compare(const DrawnPair& pair, const Capture& capture, const FrameDepth& depth) {
  const double fb = capture.rig[0].camera.fx_px * 0.1;
  Found found;
  double visible = 0, hidden = 0, measured = 0, bad = 0, within = 0, hidden_known = 0;
  std::vector<double> errors_px;
  for (std::size_t i = 0; i < pair.disparity_px.size(); ++i) {
    const bool is_known = !std::isnan(depth.depth_m.data()[i]);
    if (pair.visible.data()[i] == 0) {
      ++hidden;
      hidden_known += is_known;
      continue;
    }
    ++visible;
    if (!is_known) continue;
    ++measured;
    const auto z_m = static_cast<double>(depth.depth_m.data()[i]);
    const double off_px = std::abs(fb / z_m - static_cast<double>(pair.disparity_px.data()[i]));
    errors_px.push_back(off_px);
    bad += off_px > 1;
    if (!depth.sigma_m.empty())
      within += off_px <= 1.96 * fb / (z_m * z_m) * static_cast<double>(depth.sigma_m.data()[i]);
  }
  std::sort(errors_px.begin(), errors_px.end());
  found.measured = measured / visible;
  found.bad_1_px = bad / measured;
  found.median_px = errors_px.empty() ? 0 : errors_px[errors_px.size() / 2];
  found.within_95 = within / measured;
  found.hidden = hidden > 0 ? hidden_known / hidden : 0;
  return found;
}

Found found_in(const std::vector<DrawnPiece>& pieces, const DrawnPairConfig& drawn,
               StereoDepthConfig config = {}) {
  config.calibration_px = 0.01;  // it is exact
  const DrawnPair pair = draw_pair(pieces, drawn);
  const Capture capture = capture_of(pair);
  return compare(pair, capture, measure_stereo(capture, 0, config).depth);
}

TEST(StereoDepth, ASlantedPlaneIsFoundWithinATenthOfAPixel) {
  const Found found = found_in({{.at_px = 20, .per_x = 0.02, .per_y = -0.03}}, {});
  EXPECT_GT(found.measured, 0.97);   // all but the rim of a matching window
  EXPECT_LT(found.median_px, 0.06);  // noise of 1.5 codes in windows of 81 pixels, twice
  EXPECT_LT(found.bad_1_px, 0.002);
}

TEST(StereoDepth, OfClutterFewPixelsAreWrongAndWhatIsHiddenIsSaidToBe) {
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    const DrawnPairConfig drawn{.seed = seed};
    const Found found = found_in(drawn_clutter(seed, drawn), drawn);
    EXPECT_GT(found.measured, 0.8) << seed;
    EXPECT_LT(found.bad_1_px, 0.04) << seed;
    EXPECT_LT(found.hidden, 0.3) << seed;
    StereoDepthConfig opencv;
    opencv.pair.matcher = PairMatcher::opencv;
    const Found other = found_in(drawn_clutter(seed, drawn), drawn, opencv);
    EXPECT_LT(found.median_px, other.median_px) << seed;
  }
}

TEST(StereoDepth, SigmasHoldOnPairsThatNobodyTunedOn) {
  for (const double noise : {0.5, 1.5, 5.0}) {
    double sum = 0;
    for (const std::uint64_t seed : {21U, 22U}) {
      const DrawnPairConfig drawn{.noise = noise, .right_gain = 0.9, .seed = seed};
      sum += found_in(drawn_clutter(seed, drawn), drawn).within_95;
    }
    // 95 % would be right. Wrong matches, which have no sigma, take some; all would be too wide.
    EXPECT_GT(sum / 2, 0.85) << noise;
    EXPECT_LT(sum / 2, 0.99) << noise;
    std::printf("noise %.1f: %.3f within 1.96 sigma\n", noise, sum / 2);
  }
}

TEST(StereoDepth, RowsThatAreOffAreFoundAndSaid) {
  const DrawnPairConfig drawn{.right_down_px = 1.4};
  const DrawnPair pair = draw_pair({{.at_px = 30, .per_x = 0.01}}, drawn);
  const Capture capture = capture_of(pair);
  const StereoMeasure measured = measure_stereo(capture, 0);
  EXPECT_NEAR(measured.findings.rows_off.rms_px, 1.4, 0.1);
  EXPECT_THAT(measured.findings.doubts, testing::Contains(HasSubstr("rows lie up to")));
  const Found aligned = compare(pair, capture, measured.depth);
  EXPECT_GT(aligned.measured, 0.9);
  StereoDepthConfig as_reported;
  as_reported.pair.align_rows = false;
  const StereoMeasure unmoved = measure_stereo(capture, 0, as_reported);
  EXPECT_EQ(unmoved.findings.rows_off.rms_px, 0);
  EXPECT_LT(aligned.median_px, 0.7 * compare(pair, capture, unmoved.depth).median_px);
}

TEST(StereoDepth, WhatIsNoPairHasNoDepthAndSaysWhy) {
  const DrawnPair pair = draw_pair(drawn_clutter(5), {.seed = 5});
  const auto why = [&](const DrawnPair& of, const auto& change) {
    Capture capture = capture_of(of);
    change(capture);
    const StereoMeasure measured = measure_stereo(capture, 0);
    EXPECT_TRUE(measured.depth.depth_m.empty());
    return measured.findings.why_none;
  };
  const auto as_it_is = [](Capture&) {};
  DrawnPair exchanged = pair;
  std::swap(exchanged.left, exchanged.right);
  EXPECT_THAT(why(exchanged, as_it_is), HasSubstr("exchange the two"));
  DrawnPair even = pair;
  even.left = even.right = Image<std::uint8_t>(320, 240, 90);
  EXPECT_THAT(why(even, as_it_is), HasSubstr("no texture"));
  DrawnPair strangers = pair;
  strangers.right = draw_pair(drawn_clutter(6), {.seed = 6}).right;
  EXPECT_THAT(why(strangers, as_it_is),
              testing::AnyOf(HasSubstr("least_matched"), HasSubstr("no part of one image")));
  EXPECT_THAT(why(pair,
                  [](Capture& capture) {
                    capture.frames[0].sensors[1].time_s = capture.frames[0].time_s + 0.2;
                  }),
              HasSubstr("apart"));
  EXPECT_THAT(why(pair,
                  [](Capture& capture) {
                    capture.frames[0].sensors[1].grey = Image<std::uint8_t>(160, 120, 90);
                  }),
              HasSubstr("160 x 120"));
}

TEST(StereoDepth, AColourImageBesideAGreyOneIsAPairToo) {
  const DrawnPair pair = draw_pair({{.at_px = 20}});
  Capture capture = capture_of(pair);
  SensorFrame& right = capture.frames[0].sensors[1];
  right.color = Image<Rgb8>(pair.right.width(), pair.right.height());
  for (std::size_t i = 0; i < pair.right.size(); ++i) {
    const std::uint8_t grey = pair.right.data()[i];
    right.color.data()[i] = {grey, grey, grey};
  }
  right.grey = {};
  EXPECT_GT(compare(pair, capture, measure_stereo(capture, 0).depth).measured, 0.9);
}

TEST(StereoDepth, TooSmallAPictureSaysSo) {
  const DrawnPair pair = draw_pair({{.at_px = 5}}, {.width_px = 200, .height_px = 16});
  EXPECT_THAT(measure_stereo(capture_of(pair), 0).findings.why_none, HasSubstr("fewer than 32"));
  StereoDepthConfig nothing_left;
  nothing_left.pair.refine.most_sigma_px = 0.01;
  EXPECT_THROW(validate(nothing_left), std::invalid_argument);
}

TEST(StereoDepth, OneCameraIsRefused) {
  Capture capture = capture_of(draw_pair(drawn_clutter(5), {.seed = 5}));
  capture.rig.pop_back();
  capture.frames[0].sensors.pop_back();
  EXPECT_THROW(measure_stereo(capture, 0), std::invalid_argument);
}

TEST(StereoDepth, AreTheSameBytesOnOneThread) {
  const Capture capture = capture_of(draw_pair(drawn_clutter(7), {.seed = 7}));
  const FrameDepth many = measure_stereo(capture, 0).depth;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const FrameDepth single = measure_stereo(capture, 0).depth;
  ASSERT_EQ(many.depth_m.size(), single.depth_m.size());
  EXPECT_EQ(
      std::memcmp(many.depth_m.data(), single.depth_m.data(), many.depth_m.size() * sizeof(float)),
      0);
  EXPECT_EQ(
      std::memcmp(many.sigma_m.data(), single.sigma_m.data(), many.sigma_m.size() * sizeof(float)),
      0);
}

}  // namespace
}  // namespace cousin
