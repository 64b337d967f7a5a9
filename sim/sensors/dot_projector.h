#pragma once

#include "sim/config/fields.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

/// The pattern projector of an active stereo camera.
struct DotProjectorConfig {
  int width_px = 1280;  ///< of the picture that holds the pattern
  int height_px = 800;
  double view_x_rad = 1.57;  ///< full angles of the pattern
  double view_y_rad = 1.10;
  int dots = 5000;
  double dot_sigma_rad = 0.0012;    ///< of a dot's Gaussian profile
  double background = 0.1;          ///< share of the light that is spread evenly
  double irradiance_at_1m = 0.004;  ///< mean, on a surface that faces it, in the scene's units
};
Fields fields(DotProjectorConfig& config);
/// @throws std::invalid_argument naming the field, its value and the limit.
void validate(const DotProjectorConfig& config);

/// Pseudo-random dots, one in each cell of a grid, as such patterns keep a distance between dots;
/// their strengths differ by a tenth. The picture's mean is `irradiance_at_1m`.
Projector make_dot_projector(const DotProjectorConfig& config, const Pose& world_from_projector,
                             Rng rng);

}  // namespace cousin
