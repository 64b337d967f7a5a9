#pragma once

#include <string>
#include <vector>

#include "benchmarks/tools/fit_sensor/depth_law.h"
#include "sim/sensors/active_stereo.h"

namespace cousin {

/// A plane before a depth camera, without ray tracing.
struct PlaneBefore {
  double depth_m = 1;  ///< along the optical axis
  double turn_x_rad = 0, turn_y_rad = 0;
  double albedo = 0.5, light = 0.02;  ///< as of WallCase
};
DepthModelInputs plane_inputs(const PlaneBefore& plane, const ActiveStereoConfig& config);

/// The fast model with the same noise and fill whatever the light.
void set_even_noise(DepthModelConfig& model, double spatial_px, double temporal_px, double fill,
                    double ripple_px);

/// Keys of the fast model with the values that a fit gives them.
struct ModelCurves {
  struct Entry {
    std::string key;    ///< "model.spatial_px"
    std::string value;  ///< as TOML
    std::string words;  ///< what its comment says after "fitted: "
  };
  std::vector<Entry> entries;
};

/// The fit as the fast model's curves over the matcher's contrast, which follows from a wall's
/// distance, albedo and light by the preset: the laws at the laws' walls, its own numbers at any
/// other. Knots of the preset outside the walls' contrasts stay, scaled so that they continue the
/// fit.
/// @param data  what the numbers are fitted to, for the comments
ModelCurves model_curves(const DepthFit& fit, const ActiveStereoConfig& config,
                         const std::string& data);

}  // namespace cousin
