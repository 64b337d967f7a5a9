#include <algorithm>
#include <stdexcept>
#include <string>

#include "scenes/strawberries/strawberry_toml.h"
#include "scenes/strawberries/truss.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

/// How stalks taper, droop and fork, beside their lengths.
Fields stalk_fields(TrussShape& s) {
  return {
      {"peduncle_taper", &s.peduncle_taper, "radius at the first fork over that at the crown", 0.1,
       2},
      {"peduncle_droop_rad", &s.peduncle_droop_rad, "turn to the ground, unloaded", -3, 3},
      {"early_share", &s.early_share, "what an early fork saves that a branch is longer by", 0, 1},
      {"apart_rad", &s.apart_rad, "turn of a plant's two trusses from straight out", 0, 0.7},
      {"apart_spread_rad", &s.apart_spread_rad, "its sigma", 0, 0.15},
      {"turn_spread_rad", &s.turn_spread_rad, "sigma of the peduncle's azimuth", 0, 1},
      {"pedicel_thick", &s.pedicel_thick, "radius at its base over that at the fruit", 0.1, 5},
      {"pedicel_droop_rad", &s.pedicel_droop_rad, "turn to the ground, unloaded", -3, 3},
      {"pedicel_less", &s.pedicel_less, "share of its length lost a rank", 0, 1},
      {"pedicel_least", &s.pedicel_least, "share of its length that is left", 0.1, 1},
      {"branch_thick", &s.branch_thick, "base and tip over the peduncle's radius", 0.1, 2},
      {"branch_less", &s.branch_less, "share of its length lost a rank", 0, 1},
      {"branch_least", &s.branch_least, "share of its length that is left", 0.1, 1},
      {"crosswise_rad", &s.crosswise_rad, "turn of a fork's plane from the one before", -3.2, 3.2},
      {"crosswise_spread_rad", &s.crosswise_spread_rad, "its sigma", 0, 2},
      {"growth_by_ripeness", &s.growth_by_ripeness, "size lost a unit below grown_ripeness", 0, 2},
      {"grown_ripeness", &s.grown_ripeness, "from which a fruit is full-grown", -1, 5},
      {"growth_least", &s.growth_least, "of the size", 0.1, 1},
      {"fruit_drag", &s.fruit_drag, "drag coefficient of a fruit", 0, 2},
  };
}

}  // namespace

Fields fields(TrussShape& s) {
  return Fields{
             {"peduncle_length_m", &s.peduncle_length_m, "from the crown to the first fork", 0.01,
              1},
             {"branch_length_m", &s.branch_length_m, "from fork to fork", 0.005, 0.5},
             {"pedicel_length_m", &s.pedicel_length_m, "from the last fork to the fruit", 0.005,
              0.5},
             {"cv_length", &s.cv_length, "of all lengths: standard deviation over mean", 0, 0.3},
             {"peduncle_radius_m", &s.peduncle_radius_m, "at the crown", 5e-4, 0.01},
             {"pedicel_radius_m", &s.pedicel_radius_m, "at the fruit", 3e-4, 0.01},
             {"young_modulus_pa", &s.young_modulus_pa, "of stalks in bending", 1e6, 1e11},
             {"density_kg_m3", &s.density_kg_m3, "of stalks", 100, 2000},
             {"strength_pa", &s.strength_pa, "stress at which a stalk breaks", 1e4, 1e10},
             {"damping_time_s", &s.damping_time_s, "tau: the damping ratio at f is pi f tau", 0, 1},
             {"fork_rad", &s.fork_rad, "between a branch and what it leaves", 0, 1.5},
             {"rise_rad", &s.rise_rad, "of the peduncle over the bed, unloaded", 0, 1.5},
             {"vigour_low", &s.vigour_low, "lengths of the shortest truss over these", 0.2, 3},
             {"vigour_high", &s.vigour_high, "lengths of the longest truss over these", 0.2, 3},
             {"fork_low", &s.fork_low, "earliest fork over the peduncle's length", 0.2, 1},
             {"fork_high", &s.fork_high, "latest fork over the peduncle's length", 0.2, 1},
             {"one_branch_share", &s.one_branch_share,
              "of the forks, from which one branch goes on", 0, 1},
             {"mass_by_rank", &s.mass_by_rank, "mass over the variety's mean, of ranks 0, 1, ...",
              0.01, 5},
             {"lag_by_rank", &s.lag_by_rank, "of ripeness behind the rank before", 0, 5},
             {"lag_spread", &s.lag_spread, "its standard deviation", 0, 1},
             {"ripeness_low", &s.ripeness_low, "of the first fruit, where none is asked for", -1,
              5},
             {"ripeness_high", &s.ripeness_high, "of the first fruit, where none is asked for", -1,
              5},
             {"maturity_medium", &s.maturity_medium,
              "red share from which a fruit is medium, not low", 0, 1},
             {"maturity_high", &s.maturity_high,
              "red share above which a fruit is high, not medium", 0, 1},
             {"crown_m", &s.crown_m, "of the crown from the bed's edge", 0.01, 1},
             {"bed_half_width_m", &s.bed_half_width_m, "of the bed", 0.05, 5},
             {"bed_height_m", &s.bed_height_m, "of the bed", 0.05, 5},
             {"bed_round_m", &s.bed_round_m, "radius of the bed's shoulders", 1e-3, 0.2},
             {"bed_slope_rad", &s.bed_slope_rad, "of the bed's sides from the vertical", 0, 1},
         } +
         stalk_fields(s);
}

void validate(const TrussShape& shape) {
  TrussShape copy = shape;
  check_limits(fields(copy));
  if (shape.ripeness_low > shape.ripeness_high)
    throw std::invalid_argument("ripeness_low is above ripeness_high");
  check_maturity(shape.maturity_medium, shape.maturity_high);
  if (shape.vigour_low > shape.vigour_high)
    throw std::invalid_argument("vigour_low is above vigour_high");
  if (shape.fork_low > shape.fork_high) throw std::invalid_argument("fork_low is above fork_high");
  if (2 * shape.bed_round_m > std::min(2 * shape.bed_half_width_m, shape.bed_height_m))
    throw std::invalid_argument("bed_round_m " + std::to_string(shape.bed_round_m) +
                                " is above half the bed's width or height");
  if (shape.branch_thick.size() != 2) throw std::invalid_argument("branch_thick needs 2 numbers");
  if (shape.mass_by_rank.size() != 4) throw std::invalid_argument("mass_by_rank needs 4 numbers");
}

const TrussShape& truss_shape() {
  static const TrussShape shape = [] {
    TrussShape read;
    read_toml_text(truss_toml(), "scenes/strawberries/truss.toml", fields(read),
                   MissingKeys::error);
    validate(read);
    return read;
  }();
  return shape;
}

void validate(const TrussConfig& config) {
  strawberry_variety(config.variety);
  if (config.numbers) validate(*config.numbers);
  validate(config.shape);
  const auto require = [](const char* key, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw std::invalid_argument("truss: " + std::string(key) + " is " + std::to_string(value) +
                                "; it must be in [" + std::to_string(low) + ", " +
                                std::to_string(high) + "]");
  };
  require("fruits", config.fruits, 1, 15);
  if (config.ripeness) require("ripeness", *config.ripeness, -1, 5);
  require("heavier", config.heavier, 0.01, 1000);
  require("norm of to_sun", config.to_sun.norm(), 1e-6, 1e6);
  require("along_m", config.along_m, -0.5, 0.5);
  require("turn_rad", config.turn_rad, -1, 1);
  if (config.grid != 0) require("grid", config.grid, 8, 200);
}

}  // namespace cousin
