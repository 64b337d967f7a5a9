// The two renderers of the seeds scene, before the phone and after it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/simulate.h"

namespace cousin {
namespace {

RunConfig config_by(const char* radiance) {
  // A sphere on the board: nothing is dropped. As many bounces of either kind.
  std::vector<std::string> sets = {"sphere=true", "views=3", "rig.width_px=240",
                                   "rig.height_px=135"};
  const std::vector<std::string> own =
      radiance == std::string("paths")
          ? std::vector<std::string>{"render.by=paths", "render.pixel_samples=32",
                                     "render.max_bounces=5"}
          : std::vector<std::string>{"render.by=cached", "render.irradiance_samples=32",
                                     "render.max_bounces=4"};
  sets.insert(sets.end(), own.begin(), own.end());
  return seeds_run_config(sets);
}

std::array<double, 3> mean_of(const Image<Rgbf>& image) {
  std::array<double, 3> sum{};
  for (const Rgbf& c : image) {
    sum[0] += static_cast<double>(c.r);
    sum[1] += static_cast<double>(c.g);
    sum[2] += static_cast<double>(c.b);
  }
  for (double& s : sum) s /= static_cast<double>(image.size());
  return sum;
}

std::array<double, 3> mean_of(const Image<Rgb8>& image) {
  std::array<double, 3> sum{};
  for (const Rgb8& c : image) {
    sum[0] += c.r;
    sum[1] += c.g;
    sum[2] += c.b;
  }
  for (double& s : sum) s /= static_cast<double>(image.size());
  return sum;
}

TEST(RadianceChoice, PathsAndCachedLightGiveTheSameMeanRadianceAndPhotograph) {
  const Simulation paths(config_by("paths"), 1, 0), cached(config_by("cached"), 1, 0);
  ASSERT_EQ(paths.views().size(), 3U);
  for (const int frame : {0, 2}) {
    const auto a = mean_of(paths.radiance(frame)), b = mean_of(cached.radiance(frame));
    const auto again = mean_of(paths.radiance(frame, 1));
    const auto photo_a = mean_of(paths.take(frame, {.color = true}).frame.sensors[0].color);
    const auto photo_b = mean_of(cached.take(frame, {.color = true}).frame.sensors[0].color);
    for (std::size_t k = 0; k < 3; ++k) {
      // 32,400 pixels of 32 paths: their means repeat to 0.1 %. The cache interpolates and takes
      // what gloss shows of gloss as diffuse: half a per cent of the mean.
      EXPECT_NEAR(again[k] / a[k], 1, 2e-3) << frame << " " << k;
      EXPECT_NEAR(b[k] / a[k], 1, 6e-3) << frame << " " << k;
      // Through the same phone's tone curve, in 8 bits.
      EXPECT_NEAR(photo_b[k], photo_a[k], 1) << frame << " " << k;
    }
  }
}

TEST(RadianceChoice, TheRunSaysWhichRendererRanAndItsTime) {
  for (const char* radiance : {"paths", "cached"}) {
    RunConfig config = config_by(radiance);
    seeds_scene(config).views = 1;
    config.paths.pixel_samples = 4;
    config.cached.irradiance_samples = 16;
    config.cached.board_texel_m = 0.01;
    const SimulatedRun run = simulate(config, 1, 0, {});
    EXPECT_EQ(run.radiance.stage, std::string("radiance_by_") + radiance);
    EXPECT_GT(run.radiance.wall_s, 0);
    for (const StageTiming& timing : run.timings) {
      if (timing.stage == "render") EXPECT_LE(run.radiance.wall_s, timing.wall_s);
    }
    EXPECT_NE(run.truth.config_toml.find("by = \"" + std::string(radiance) + "\""),
              std::string::npos);
  }
}

}  // namespace
}  // namespace cousin
