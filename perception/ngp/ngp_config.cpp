#include <cmath>
#include <stdexcept>
#include <string>

#include "perception/ngp/ngp.h"

namespace cousin {

Fields fields(NgpConfig& c) {
  return {
      {"iterations", &c.iterations, "steps of training", 1, 1000000},
      {"samples_per_step", &c.samples_per_step, "points of rays in a step, about", 256, 1 << 22},
      {"grid.levels", &c.grid.levels, "resolutions of the hash grid", 1, 24},
      {"grid.log2_table", &c.grid.log2_table, "entries of a level, a power of two", 8, 22},
      {"grid.coarsest", &c.grid.coarsest, "cubes along a side of the coarsest level", 2, 512},
      {"grid.finest", &c.grid.finest, "cubes along a side of the finest level", 2, 1 << 19},
      {"occupancy_cells", &c.occupancy_cells, "cells along a side that say what is empty", 8, 256},
      {"steps", &c.steps, "shortest step: the inner cube's diagonal over this", 16, 4096},
      {"cascades", &c.cascades, "cubes, each twice the one inside", 1, 8},
      {"side_m", &c.side_m, "of the inner cube; 0 = distance of the cameras", 0, 1e6},
      {"centre_m", &c.centre_m, "of the cubes in the world; empty = where cameras look"},
      {"learning_rate", &c.learning_rate, "of Adam", 1e-6, 1},
      {"background", &c.background, "red, green, blue behind everything", 0, 1},
      {"seed", &c.seed, "of all draws"}};
}

void validate(const NgpConfig& config) {
  const auto refuse = [](const std::string& key, const std::string& value,
                         const std::string& limit) {
    throw std::invalid_argument("ngp." + key + " = " + value + ": " + limit);
  };
  NgpConfig copy = config;
  for (const Field& field : fields(copy)) {
    double value = field.min;
    if (const auto* whole = std::get_if<int*>(&field.value))
      value = **whole;
    else if (const auto* real = std::get_if<double*>(&field.value))
      value = **real;
    else
      continue;
    if (!(value >= field.min && value <= field.max))
      refuse(field.key, std::to_string(value),
             "is not in " + std::to_string(field.min) + ".." + std::to_string(field.max));
  }
  if (config.grid.finest < config.grid.coarsest)
    refuse("grid.finest", std::to_string(config.grid.finest), "must not be below grid.coarsest");
  if (!config.centre_m.empty() && config.centre_m.size() != 3)
    refuse("centre_m", std::to_string(config.centre_m.size()) + " numbers",
           "must be three or none");
  for (const double x : config.centre_m)
    if (!std::isfinite(x)) refuse("centre_m", std::to_string(x), "must be finite");
  if (config.background.size() != 3)
    refuse("background", std::to_string(config.background.size()) + " numbers", "must be three");
  for (const double x : config.background)
    if (!(x >= 0 && x <= 1)) refuse("background", std::to_string(x), "must be in 0..1");
}

std::string_view to_string(NgpStatus status) {
  switch (status) {
    case NgpStatus::ok:
      return "ok";
    case NgpStatus::too_few_views:
      return "too_few_views";
    case NgpStatus::no_pixels:
      return "no_pixels";
    case NgpStatus::no_volume:
      return "no_volume";
    case NgpStatus::not_finite:
      return "not_finite";
  }
  return "?";
}

}  // namespace cousin
