#include <stdexcept>
#include <string>

#include "scenes/strawberries/strawberry_bed.h"
#include "scenes/strawberries/strawberry_toml.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

Fields fields(StrawberryBedConfig::Film& c) {
  return {{"albedo", &c.albedo, "of the film", 0, 1},
          {"roughness", &c.roughness, "of the film", 0.05, 1},
          {"ior", &c.ior, "of the film", 1, 3},
          {"wrinkle_m", &c.wrinkle_m, "depth of its folds", 0, 0.02},
          {"wrinkle_scale_m", &c.wrinkle_scale_m, "size of its folds", 5e-3, 1},
          {"half_length_m", &c.half_length_m, "of the bed, to each side", 0.7, 20},
          {"cell_m", &c.cell_m, "of its mesh where the camera looks", 1e-3, 0.1},
          {"dust_albedo", &c.dust_albedo, "of dried splashes", 0, 1},
          {"dust_m", &c.dust_m, "size of splashes", 1e-3, 1}};
}

Fields fields(StrawberryBedConfig::Row& c) {
  return {{"spacing_m", &c.spacing_m, "crowns along a row", 0.08, 1},
          {"scatter_m", &c.scatter_m, "sigma of a crown's place", 0, 0.05},
          {"plants", &c.plants, "of a row before the camera", 1, 31},
          {"variants", &c.variants, "plants that stand for all farther ones", 1, 20},
          {"hole_m", &c.hole_m, "radius of the planting holes", 0.01, 0.1},
          {"soil_albedo", &c.soil_albedo, "in the holes", 0, 1},
          {"soil_other_albedo", &c.soil_other_albedo, "its dry crumbs", 0, 1}};
}

Fields fields(StrawberryBedConfig::Drip& c) {
  return {{"radius_m", &c.radius_m, "of the drip tubes", 2e-3, 0.03},
          {"albedo", &c.albedo, "of the drip tubes", 0, 1},
          {"under_m", &c.under_m, "of the tube under the film, from the edge", 0.03, 1},
          {"rise_m", &c.rise_m, "of the film over it", 0, 0.05}};
}

Fields fields(StrawberryBedConfig::Path& c) {
  return {{"albedo", &c.albedo, "of the furrow's soil", 0, 1},
          {"other_albedo", &c.other_albedo, "of its dry crumbs", 0, 1},
          {"weave_m", &c.weave_m, "size of its largest patches", 1e-3, 1},
          {"wave_m", &c.wave_m, "height of its waves", 0, 0.1},
          {"wave_scale_m", &c.wave_scale_m, "size of its waves", 5e-3, 5},
          {"clod_m", &c.clod_m, "height of its clods", 0, 0.05},
          {"clod_scale_m", &c.clod_scale_m, "size of its clods", 5e-3, 0.5},
          {"lift_m", &c.lift_m, "how far it is turned up at the bed's foot", 0, 0.2},
          {"pitch_m", &c.pitch_m, "from bed to bed", 0.5, 5},
          {"beds", &c.beds, "beds behind the first", 0, 10},
          {"wall_m", &c.wall_m, "distance of the greenhouse's wall", 2, 100},
          {"wall_albedo", &c.wall_albedo, "of the wall", 0, 1}};
}

Fields fields(StrawberryBedConfig::LightNumbers& c) {
  return {
      {"morning_elevation_rad", &c.morning_elevation_rad, "of the low sun", 0.02, 1.5},
      {"morning_haze_rad", &c.morning_haze_rad, "its radius through the film", 1e-3, 0.5},
      {"morning_turbidity", &c.morning_turbidity, "of the morning's air", 1.7, 10},
      {"noon_elevation_rad", &c.noon_elevation_rad, "of the hard sun", 0.02, 1.57},
      {"noon_turbidity", &c.noon_turbidity, "of noon's air", 1.7, 10},
      {"azimuth_spread_rad", &c.azimuth_spread_rad, "of the sun about the path's side", 0, 3.1416},
      {"overcast", &c.overcast, "radiance at the zenith", 0, 1000},
      {"overcast_horizon", &c.overcast_horizon, "the horizon's over the zenith's", 0, 1},
      {"lamp_radiance", &c.lamp_radiance, "of the panel beside the camera", 0, 1e6},
      {"lamp_half_m", &c.lamp_half_m, "its half sides", 1e-3, 1},
      {"lamp_dim", &c.lamp_dim, "daylight beside it, over the overcast sky's", 0, 1}};
}

}  // namespace

Fields fields(StrawberryBedConfig& c) {
  return nested("film", fields(c.film)) + nested("row", fields(c.row)) +
         nested("drip", fields(c.drip)) + nested("path", fields(c.path)) +
         nested("light", fields(c.light));
}

void validate(const StrawberryBedConfig& config) {
  StrawberryBedConfig copy = config;
  check_limits(fields(copy), "bed");
  const auto numbers = [](const char* key, const std::vector<double>& list, std::size_t count) {
    if (list.size() == count) return;
    throw std::invalid_argument(std::string("bed: ") + key + " has " + std::to_string(list.size()) +
                                " numbers; it needs " + std::to_string(count));
  };
  for (const auto* color :
       {&config.film.albedo, &config.film.dust_albedo, &config.row.soil_albedo,
        &config.row.soil_other_albedo, &config.drip.albedo, &config.path.albedo,
        &config.path.other_albedo, &config.path.wall_albedo, &config.light.overcast})
    numbers("a colour", *color, 3);
  numbers("light.lamp_half_m", config.light.lamp_half_m, 2);
}

const StrawberryBedConfig& strawberry_bed() {
  static const StrawberryBedConfig config = [] {
    StrawberryBedConfig read;
    read_toml_text(strawberry_bed_toml(), "scenes/strawberries/bed.toml", fields(read),
                   MissingKeys::error);
    validate(read);
    return read;
  }();
  return config;
}

}  // namespace cousin
