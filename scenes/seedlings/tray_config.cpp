#include <stdexcept>
#include <string>

#include "scenes/seedlings/toml_text.h"
#include "scenes/seedlings/tray.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

Fields fields(TrayConfig::Tray& c) {
  return {{"columns", &c.columns, "cells along the tray", 1, 50},
          {"rows", &c.rows, "cells across", 1, 50},
          {"pitch_m", &c.pitch_m, "from cell to cell", 0.005, 1},
          {"depth_m", &c.depth_m, "of the tray", 0.005, 1},
          {"wall_m", &c.wall_m, "rim between two cells", 1e-4, 0.1},
          {"corner", &c.corner, "exponent of the opening's superellipse", 2, 50},
          {"taper", &c.taper, "opening at the bottom over that at the top", 0.1, 1},
          {"albedo", &c.albedo, "of the plastic", 0, 1},
          {"roughness", &c.roughness, "of the plastic", 0.05, 1},
          {"empty_share", &c.empty_share, "of the cells that nobody sowed", 0, 1}};
}

Fields fields(TrayConfig::Substrate& c) {
  return {{"below_rim_m", &c.below_rim_m, "its surface below the rim", 0, 0.1},
          {"variants", &c.variants, "different surfaces", 1, 100},
          {"detail_m", &c.detail_m, "edge of its triangles", 2e-4, 0.1},
          {"clump_m", &c.clump_m, "amplitude of clumps", 0, 0.1},
          {"clump_scale_m", &c.clump_scale_m, "their size", 1e-4, 1},
          {"grain_m", &c.grain_m, "amplitude of grains", 0, 0.1},
          {"grain_scale_m", &c.grain_scale_m, "their size", 1e-4, 1},
          {"albedo_dark", &c.albedo_dark, "moist", 0, 1},
          {"albedo_light", &c.albedo_light, "dry", 0, 1},
          {"perlite", &c.perlite, "white grains in sight in a cell", 0, 1000},
          {"perlite_m", &c.perlite_m, "their least and largest radius", 1e-5, 0.1},
          {"perlite_albedo", &c.perlite_albedo, "of them", 0, 1},
          {"roughness", &c.roughness, "of the substrate", 0.05, 1}};
}

Fields fields(TrayConfig::Bench& c) {
  return {{"half_m", &c.half_m, "of the square floor", 0.5, 100},
          {"albedo", &c.albedo, "of the floor", 0, 1},
          {"other_albedo", &c.other_albedo, "of its stains", 0, 1},
          {"noise_m", &c.noise_m, "size of the stains", 1e-3, 10}};
}

Fields fields(TrayConfig::LightNumbers& c) {
  constexpr double kMost = 1e6;
  return {{"d1_elevation_rad", &c.d1_elevation_rad, "of the sun", 0.05, 1.57},
          {"d1_azimuth_rad", &c.d1_azimuth_rad, "of the sun about +z", -7, 7},
          {"d1_turbidity", &c.d1_turbidity, "of the air", 1.7, 10},
          {"d2_zenith", &c.d2_zenith, "radiance at the zenith", 0, kMost},
          {"d2_horizon_share", &c.d2_horizon_share, "horizon over zenith", 0, 10},
          {"d3_lamps", &c.d3_lamps, "LED bars", 1, 100},
          {"d3_height_m", &c.d3_height_m, "above the substrate", 0.05, 10},
          {"d3_half_length_m", &c.d3_half_length_m, "of a bar", 1e-3, 10},
          {"d3_half_width_m", &c.d3_half_width_m, "of a bar", 1e-4, 10},
          {"d3_radiance", &c.d3_radiance, "of a bar's face", 0, kMost},
          {"d3_blue_m", &c.d3_blue_m, "wavelength", 3.6e-7, 8.3e-7},
          {"d3_red_m", &c.d3_red_m, "wavelength", 3.6e-7, 8.3e-7},
          {"d3_width_m", &c.d3_width_m, "between half maxima", 1e-9, 1e-7},
          {"d3_blue_share", &c.d3_blue_share, "of the power", 0, 1},
          {"d3_room", &c.d3_room, "radiance of the dark room", 0, kMost}};
}

}  // namespace

Fields fields(TrayConfig& c) {
  return nested("tray", fields(c.tray)) + nested("substrate", fields(c.substrate)) +
         nested("bench", fields(c.bench)) + nested("lights", fields(c.light));
}

void validate(const TrayConfig& config) {
  TrayConfig copy = config;
  check_limits(fields(copy), "tray");
  for (const auto* color :
       {&config.tray.albedo, &config.substrate.albedo_dark, &config.substrate.albedo_light,
        &config.substrate.perlite_albedo, &config.bench.albedo, &config.bench.other_albedo,
        &config.light.d2_zenith, &config.light.d3_room}) {
    if (color->size() != 3)
      throw std::invalid_argument("tray: a colour has " + std::to_string(color->size()) +
                                  " numbers; it needs 3");
  }
  if (config.substrate.perlite_m.size() != 2)
    throw std::invalid_argument("tray: substrate.perlite_m needs 2 numbers");
  if (config.tray.wall_m >= config.tray.pitch_m) {
    throw std::invalid_argument("tray: wall_m " + std::to_string(config.tray.wall_m) +
                                " leaves no cell of pitch_m " +
                                std::to_string(config.tray.pitch_m));
  }
}

const TrayConfig& seedling_tray() {
  static const TrayConfig kConfig = [] {
    TrayConfig config;
    read_toml_text(tray_toml(), "scenes/seedlings/tray.toml", fields(config), MissingKeys::error);
    validate(config);
    return config;
  }();
  return kConfig;
}

}  // namespace cousin
