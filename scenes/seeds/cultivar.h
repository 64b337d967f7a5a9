#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scenes/seeds/seeds_scene.h"
#include "sim/types/image.h"

namespace cousin {

enum class Species { maize, wheat, rice };

/// One cultivar's table in cultivars.toml, which says what each number is and where it comes from.
/// Every value is given there.
struct CultivarConfig {
  Species species = Species::maize;
  double length_m = 0, width_m = 0, height_m = 0;     ///< means
  double cv_length = 0, cv_width = 0, cv_height = 0;  ///< standard deviation over mean
  double size_share = 0;                       ///< of each variance, explained by one common factor
  std::vector<double> paper_rmse_m, paper_r2;  ///< length, width, height
  double density_kg_m3 = 0;
  std::vector<double> profile_width, profile_height;  ///< from tip to crown, 1 = maximum
  double tip_round = 0, tip_exponent = 0, crown_round = 0, crown_exponent = 0;
  double section_exponent = 0;  ///< superellipse
  double bend_m = 0, lump_m = 0, relief_m = 0, groove_m = 0, wrinkle_m = 0;
  double neck_m = 0, back_narrower = 0;
  std::vector<double> beak_m;  ///< rice: apiculus along and aside, pedicel along
  /// Standard deviations between the seeds of a lot.
  double relief_spread = 0, groove_spread = 0, slant = 0, skew = 0, taper = 0;
  std::vector<double> albedo_body, albedo_pale, albedo_dark, albedo_tip;
  double mottle = 0, mottle_scale_m = 0;
  double roughness = 0, ior = 0;
  int grid = 0;
};
Fields fields(CultivarConfig& config);
void validate(const CultivarConfig& config);

/// @throws std::invalid_argument naming the cultivars that exist.
const CultivarConfig& cultivar(const std::string& name);

/// Standard deviations of length, width and height at a spread.
Eigen::Vector3d size_sigma_m(const CultivarConfig& config, SizeSpread spread);

/// One seed's length >= width >= height along its own axes. Normal about the means, cut at two
/// standard deviations and widened so that the cut leaves the standard deviation as stated; redrawn
/// where the order of the axes would change.
Eigen::Vector3d draw_size_m(const CultivarConfig& config, SizeSpread spread, Rng& rng);

}  // namespace cousin
