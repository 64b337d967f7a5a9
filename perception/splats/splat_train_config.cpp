#include "perception/splats/splat_train_config.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

void check(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument("splat training: " + std::string(name) + " = " +
                              std::to_string(value) + " is not in " + std::to_string(low) + " .. " +
                              std::to_string(high));
}

}  // namespace

SplatRates rates_for(int steps) {
  SplatRates rates;
  constexpr double kFittedAt = 1000;                   // steps of the defaults
  const double power = std::log(4.0) / std::log(7.0);  // a quarter of them at 7000 steps
  const double share = std::min(1.0, std::pow(kFittedAt / steps, power));
  rates.centre_first *= share;
  rates.log_scale *= share;
  return rates;
}

SplatTrainConfig reference_training() {
  SplatTrainConfig config;
  config.steps = 30000;
  config.rates = {.centre_first = 1.6e-4,
                  .centre_last = 1.6e-6,
                  .log_scale = 5e-3,
                  .rotation = 1e-3,
                  .opacity = 5e-2,
                  .dc = 2.5e-3,
                  .rest = 1.25e-4};
  config.low_pass_px2 = 0.3;
  config.quarter_until = config.half_until = 0;
  config.growth = SplatGrowth::adaptive;
  config.most_splats = 10'000'000;
  config.grow_every = 100;
  config.grow_from = 500.0 / 30000;
  config.grow_until = 0.5;
  config.reset_every = 0.1;
  return config;
}

void validate(const SplatTrainConfig& config) {
  check("steps", config.steps, 1, 1e6);
  check("sh_degree", config.sh_degree, 0, 3);
  check("sh_degree_every", config.sh_degree_every, 0, 1e6);
  check("report_every", config.report_every, 1, 1e6);
  for (const float value : config.background) check("background", value, 0, 1);
  check("ssim_share", config.ssim_share, 0, 1);
  check("near", config.near, 1e-9, 1);
  check("low_pass_px2", config.low_pass_px2, 1e-6, 100);
  const SplatRates& rates = config.rates;
  check("rates.centre_first", rates.centre_first, 0, 1);
  check("rates.centre_last", rates.centre_last, 0, 1);
  check("rates.log_scale", rates.log_scale, 0, 1);
  check("rates.rotation", rates.rotation, 0, 1);
  check("rates.opacity", rates.opacity, 0, 1);
  check("rates.dc", rates.dc, 0, 1);
  check("rates.rest", rates.rest, 0, 1);
  check("rates.decay", rates.decay, 1e-6, 1);
  check("rest_every", config.rest_every, 1, 1e6);
  check("quarter_until", config.quarter_until, 0, 1);
  check("half_until", config.half_until, 0, 1);
  check("most_splats", config.most_splats, 1, 1e7);
  check("grow_every", config.grow_every, 1, 1e6);
  check("grow_from", config.grow_from, 0, 1);
  check("grow_until", config.grow_until, 0, 1);
  check("growth_power", config.growth_power, 0.01, 100);
  check("gradient_limit", config.gradient_limit, 0, 1e6);
  check("split_size", config.split_size, 0, 1e6);
  check("least_opacity", config.least_opacity, 0, 0.5);
  check("largest_size", config.largest_size, 1e-6, 1e6);
  check("reset_every", config.reset_every, 0, 1);
  check("noise", config.noise, 0, 1e9);
  check("opacity_pull", config.opacity_pull, 0, 1);
  check("scale_pull", config.scale_pull, 0, 1);
}

}  // namespace cousin
