#include "sim/sensors/dot_projector.h"

#include <algorithm>
#include <cmath>

#include "sim/config/limits.h"

namespace cousin {

Fields fields(DotProjectorConfig& c) {
  return {
      {"width_px", &c.width_px, "width of the pattern's picture", 16, 8192},
      {"height_px", &c.height_px, "height of the pattern's picture", 16, 8192},
      {"view_x_rad", &c.view_x_rad, "full horizontal angle", 0.01, 3},
      {"view_y_rad", &c.view_y_rad, "full vertical angle", 0.01, 3},
      {"dots", &c.dots, "number of dots", 1, 1000000},
      {"dot_sigma_rad", &c.dot_sigma_rad, "sigma of a dot's profile", 1e-5, 0.1},
      {"background", &c.background, "share of the light spread evenly", 0, 1},
      {"irradiance_at_1m", &c.irradiance_at_1m, "mean irradiance at 1 m", 0, 1e9},
  };
}

void validate(const DotProjectorConfig& config) {
  DotProjectorConfig copy = config;
  check_limits(fields(copy), "projector");
}

Projector make_dot_projector(const DotProjectorConfig& config, const Pose& world_from_projector,
                             Rng rng) {
  validate(config);
  Projector projector;
  projector.world_from_projector = world_from_projector;
  Camera& lens = projector.lens;
  lens.width_px = config.width_px;
  lens.height_px = config.height_px;
  lens.fx_px = 0.5 * config.width_px / std::tan(0.5 * config.view_x_rad);
  lens.fy_px = 0.5 * config.height_px / std::tan(0.5 * config.view_y_rad);
  lens.cx_px = 0.5 * (config.width_px - 1);
  lens.cy_px = 0.5 * (config.height_px - 1);

  const int width = config.width_px, height = config.height_px;
  Image<float> light(width, height, 0.0F);
  const double cell_px = std::sqrt(static_cast<double>(width) * height / config.dots);
  const int columns = std::max(1, static_cast<int>(std::lround(width / cell_px)));
  const int rows = std::max(1, static_cast<int>(std::lround(height / cell_px)));
  const double sigma_x = config.dot_sigma_rad * lens.fx_px;
  const double sigma_y = config.dot_sigma_rad * lens.fy_px;
  const int reach_x = static_cast<int>(std::ceil(4 * sigma_x)) + 1;
  const int reach_y = static_cast<int>(std::ceil(4 * sigma_y)) + 1;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double x = (column + uniform(rng)) * width / columns - 0.5;
      const double y = (row + uniform(rng)) * height / rows - 0.5;
      const double strength = truncated_normal(rng, 1, 0.1);
      const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
      for (int j = std::max(cy - reach_y, 0); j <= std::min(cy + reach_y, height - 1); ++j) {
        for (int i = std::max(cx - reach_x, 0); i <= std::min(cx + reach_x, width - 1); ++i) {
          const double u = (i - x) / sigma_x, v = (j - y) / sigma_y;
          light(i, j) += static_cast<float>(strength * std::exp(-0.5 * (u * u + v * v)));
        }
      }
    }
  }
  double sum = 0;
  for (const float v : light) sum += static_cast<double>(v);
  const double mean = sum / static_cast<double>(light.size());
  projector.intensity = Image<Rgbf>(width, height);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double dots = (1 - config.background) * static_cast<double>(light.data()[i]) / mean;
    const auto value = static_cast<float>(config.irradiance_at_1m * (dots + config.background));
    projector.intensity.data()[i] = {value, value, value};
  }
  return projector;
}

}  // namespace cousin
