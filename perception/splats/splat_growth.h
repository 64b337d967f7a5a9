#pragma once

#include "perception/splats/splat_train_config.h"
#include "perception/splats/splat_train_state.h"
#include "sim/types/rng.h"

namespace cousin {

/// Changes the number of Gaussians as the configuration's kind of growth does between two steps,
/// and orders them along a Morton curve so that neighbours in space are neighbours in memory.
/// Parameters that are not finite are dropped by all kinds. Clears the gradient sums.
/// @param extent_m  the scene's: radius of the camera centres
/// @param progress  of growth, 0..1: what the budget's schedule goes by
void grow_splats(SplatTrainState& state, const SplatTrainConfig& config, double extent_m,
                 double progress, const Rng& rng);

/// The reference's reset: no opacity above 0.01, and its moments at zero.
void reset_opacity(SplatTrainState& state);

/// Langevin noise of `mcmc` on the centres of nearly transparent Gaussians [Kheradmand et al.
/// 2024, eq. 8]. @param scale  standard deviation as a share of the Gaussian's covariance
void add_centre_noise(SplatPlanes& values, double scale, const Rng& rng);

/// Opacity and scale of each of `copies` Gaussians at one place that together look like one
/// [Kheradmand et al. 2024, eq. 9].
struct SharedOpacity {
  double opacity;
  double scale_factor;  ///< of the standard deviations
};
SharedOpacity share_opacity(double opacity, int copies);

}  // namespace cousin
