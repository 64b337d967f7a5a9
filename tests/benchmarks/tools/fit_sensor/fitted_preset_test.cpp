// What a fit of raw frames writes into a depth camera's preset: gain, read noise, black level,
// bits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/tools/fit_sensor/hidden_device.h"
#include "sim/dataset/atomic_file.h"
#include "sim/sensors/device.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

/// Raw frames alone of a camera of 12 bits, 9 ke and 6 e.
RecordedFrames raw_frames(HiddenDevice& device) {
  device = draw_hidden_device("d457", Rng(2));
  PhotositesConfig& p = device.camera.photosites;
  p.full_well_e = 9000;
  p.read_noise_e = 6;
  p.bits = 12;
  p.black_level = 100;
  RecordingPlan plan;
  plan.distances_m = {1};
  RecordedFrames frames = record(device, plan, Rng(3));
  frames.walls.clear();
  return frames;
}

TEST(FittedPreset, OfEveryDepthCameraLoadsAndHasTheGainAndReadNoiseThatWereFitted) {
  HiddenDevice device;
  const RecordedFrames frames = raw_frames(device);
  const TemporaryFolder folder;
  for (const std::string& name : active_stereo_preset_names()) {
    const SensorFit fit = fit_frames(frames, {}, rig_choice(name), "a hidden camera");
    ASSERT_TRUE(fit.problems.empty()) << name << ": " << fit.problems.front();
    ASSERT_TRUE(fit.gain && fit.gain->read_noise_solved) << name;
    const auto file = folder.path() / (name + "_fitted.toml");
    write_file(file, fit.preset_toml);

    const auto loaded = std::get<ActiveStereoConfig>(device_preset(file.string()));
    const PhotositesConfig& p = loaded.color.photosites;
    EXPECT_EQ(p.bits, 12) << name;
    EXPECT_EQ(p.black_level, 100) << name;
    // The full well is written to 0.1 e of 9 ke; the black level, rounded, is off by up to 0.1
    // codes of a span of 4000.
    EXPECT_NEAR(codes_per_electron(p) / fit.gain->gain.value, 1, 1e-4) << name;
    EXPECT_NEAR(p.read_noise_e, fit.gain->read_noise_e.value, 5e-4) << name;  // three decimals
    // And they are the camera's: as GainFit.FindsGainAndReadNoise.
    EXPECT_NEAR(codes_per_electron(p) / codes_per_electron(device.camera.photosites), 1, 0.008);
    EXPECT_NEAR(p.read_noise_e, 6, 0.1) << name;

    const ActiveStereoConfig preset = active_stereo_preset(name);
    EXPECT_NE(p.full_well_e, preset.color.photosites.full_well_e) << name;
    EXPECT_EQ(p.prnu, preset.color.photosites.prnu) << name;
    EXPECT_EQ(loaded.model.spatial_px, preset.model.spatial_px) << name;
    EXPECT_EQ(loaded.mode_focal_px, preset.mode_focal_px) << name;
    EXPECT_THAT(fit.preset_toml, testing::HasSubstr("# fitted: to a hidden camera")) << name;
  }
}

TEST(FittedPreset, IsARigThatTakesPicturesByItsFilesPath) {
  HiddenDevice device;
  const SensorFit fit = fit_frames(raw_frames(device), {}, rig_choice("d405"), "a hidden camera");
  ASSERT_TRUE(fit.problems.empty());
  const TemporaryFolder folder;
  const auto file = folder.path() / "mine.toml";
  write_file(file, fit.preset_toml);
  const DeviceConfig mine = device_preset(file.string());
  EXPECT_EQ(streams_of(mine), streams_of(device_preset("d405")));
  // Fitted again from where it stands: nothing moves.
  const SensorFit again =
      fit_frames(raw_frames(device), {}, rig_choice(file.string()), "a hidden camera");
  ASSERT_TRUE(again.problems.empty());
  write_file(folder.path() / "again.toml", again.preset_toml);
  const auto& a = std::get<ActiveStereoConfig>(mine).color.photosites;
  const DeviceConfig second = device_preset((folder.path() / "again.toml").string());
  const auto& b = std::get<ActiveStereoConfig>(second).color.photosites;
  EXPECT_EQ(a.full_well_e, b.full_well_e);
  EXPECT_EQ(a.read_noise_e, b.read_noise_e);
}

}  // namespace
}  // namespace cousin
