#include "benchmarks/tools/fit_sensor/photon_transfer_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/tools/fit_sensor/hidden_device.h"

namespace cousin {
namespace {

using testing::HasSubstr;

HiddenDevice camera_of(double full_well_e, double read_noise_e, int bits) {
  HiddenDevice device = draw_hidden_device("d457", Rng(2));
  PhotositesConfig& p = device.camera.photosites;
  p.full_well_e = full_well_e;
  p.read_noise_e = read_noise_e;
  p.bits = bits;
  p.black_level = bits == 8 ? 8 : 100;
  return device;
}

RecordedFrames flats_of(const HiddenDevice& device, double brightest = 0.8) {
  RecordingPlan plan;
  plan.distances_m = {1};
  plan.brightest = brightest;
  return record(device, plan, Rng(3));
}

TEST(GainFit, FindsGainAndReadNoise) {
  const HiddenDevice device = camera_of(9000, 6, 12);
  const RecordedFrames frames = flats_of(device);
  const GainFit fit = fit_gain(*frames.dark, frames.flats, frames.max_code);
  EXPECT_TRUE(fit.problems.empty());
  const double k = codes_per_electron(device.camera.photosites);
  // 153 600 pairs at 6 brightnesses: the variances are known to 0.4 %, the slope to 0.2 %.
  EXPECT_NEAR(fit.gain.value / k, 1, 0.008);
  EXPECT_NEAR(fit.black_code, 100, 0.1);
  ASSERT_TRUE(fit.read_noise_solved);
  EXPECT_NEAR(fit.read_noise_e.value, 6, 0.1);
}

TEST(GainFit, DoesNotTellAReadNoiseBelowTheRounding) {
  const HiddenDevice device = camera_of(10000, 6, 8);  // 0.15 codes
  const RecordedFrames frames = flats_of(device);
  const GainFit fit = fit_gain(*frames.dark, frames.flats, frames.max_code);
  EXPECT_TRUE(fit.problems.empty());
  EXPECT_FALSE(fit.read_noise_solved);
  EXPECT_NEAR(fit.gain.value / codes_per_electron(device.camera.photosites), 1, 0.01);
}

TEST(GainFit, SaturatedFieldsAreLeftOutAndTooFewAreRejected) {
  const HiddenDevice device = camera_of(9000, 6, 12);
  const RecordedFrames frames = flats_of(device, 4);  // the first is at 0.67 of full well
  const GainFit fit = fit_gain(*frames.dark, frames.flats, frames.max_code);
  ASSERT_EQ(fit.problems.size(), 1U);
  EXPECT_THAT(fit.problems[0], HasSubstr("1 usable brightnesses; at least 3"));
  EXPECT_THAT(fit.problems[0], HasSubstr("saturated"));
}

TEST(GainFit, AToneCurveIsRejected) {
  const HiddenDevice device = camera_of(9000, 6, 12);
  RecordedFrames frames = flats_of(device);
  for (FlatFrames& flat : frames.flats) {
    flat.frame = [raw = flat.frame](int k) {
      Image<std::uint16_t> codes = raw(k);
      for (std::uint16_t& c : codes)
        c = static_cast<std::uint16_t>(std::lround(4095 * std::pow(c / 4095.0, 1 / 2.2)));
      return codes;
    };
  }
  const GainFit fit = fit_gain(*frames.dark, frames.flats, frames.max_code);
  ASSERT_FALSE(fit.problems.empty());
}

TEST(GainFit, DarkFramesCutOffAtBlackAreRejected) {
  HiddenDevice device = camera_of(9000, 6, 12);
  device.camera.photosites.black_level = 0;
  const RecordedFrames frames = flats_of(device);
  const GainFit fit = fit_gain(*frames.dark, frames.flats, frames.max_code);
  ASSERT_EQ(fit.problems.size(), 1U);
  EXPECT_THAT(fit.problems[0], HasSubstr("cuts the noise off"));
}

TEST(GainFit, NamesAFolderWithTooFewFramesOrAnotherSize) {
  const HiddenDevice device = camera_of(9000, 6, 12);
  RecordedFrames frames = flats_of(device);
  frames.flats[2].count = 1;
  try {
    fit_gain(*frames.dark, frames.flats, frames.max_code);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("flat_2: 1 frames; at least 2"));
  }
  frames.flats[2].count = 2;
  frames.flats[2].frame = [](int k) { return Image<std::uint16_t>(8 + k, 8); };
  EXPECT_THROW(fit_gain(*frames.dark, frames.flats, frames.max_code), std::runtime_error);
}

}  // namespace
}  // namespace cousin
