#pragma once

#include "perception/splats/splat_growth.h"

namespace cousin {

/// The kinds of growth behind `grow_splats`. Each leaves finite parameters and cleared sums.
void grow_adaptive(SplatTrainState& state, const SplatTrainConfig& config, double extent_m,
                   const Rng& rng);
void grow_budgeted(SplatTrainState& state, const SplatTrainConfig& config, double progress);
void grow_mcmc(SplatTrainState& state, const SplatTrainConfig& config, const Rng& rng);

/// Axes of Gaussian i, each as long as its standard deviation: A A' is the covariance.
Eigen::Matrix3d splat_axes(const SplatPlanes& values, int i);
double splat_opacity(const SplatPlanes& values, int i);
void set_opacity(SplatPlanes& values, int i, double opacity);
double largest_scale_m(const SplatPlanes& values, int i);

}  // namespace cousin
