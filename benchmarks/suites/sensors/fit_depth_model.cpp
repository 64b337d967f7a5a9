// fit_depth_model RIG [key=value ...]: fits the fast depth model to the full one of a preset,
// prints the [model] table of its TOML, and how both compare on walls that were not fitted.
#include <cstdio>
#include <exception>

#include "benchmarks/suites/sensors/depth_model_fit.h"

namespace {

constexpr std::uint64_t kSeed = 11;
constexpr int kFrames = 2;

int run(int count, char** words) {
  using namespace cousin;
  if (count < 2) {
    std::fprintf(stderr, "usage: fit_depth_model RIG [key=value ...]\n");
    return 2;
  }
  ActiveStereoConfig config = active_stereo_preset(words[1]);
  for (int i = 2; i < count; ++i) set_field(fields(config), words[i]);
  // The rng of the unit is the fit's own: its calibration's errors shift the disparities a little.
  const ActiveStereoUnit unit = make_active_stereo(config, Rng(3));
  config.model = fit_depth_model(config, unit, kFrames, Rng(kSeed), [](int done, int all) {
    std::fprintf(stderr, "wall %d of %d\n", done, all);
  });
  std::printf("%s\n", to_toml(fields(config.model)).c_str());
  for (const ModelComparison& c :
       compare_models(test_walls(config), config, unit, kFrames, Rng(77))) {
    std::printf("# %.2f m, %.2f rad, light %.3g: fill %.4f full %.4f fast, sigma %.4f %.4f px\n",
                c.wall.distance_m, c.wall.incidence_rad, c.wall.light, c.full.fill, c.fast.fill,
                c.full.sigma_px, c.fast.sigma_px);
  }
  return 0;
}

}  // namespace

int main(int count, char** words) {
  try {
    return run(count, words);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fit_depth_model: %s\n", error.what());
    return 4;
  }
}
