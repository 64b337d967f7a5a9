#pragma once

#include "perception/pipelines/seeds.h"

namespace cousin {

/// Private to perception/pipelines: what the stages' configurations become where the depth is a
/// sensor's own, which says itself how noisy it is. For the other methods they stay as they are,
/// except that points of Gaussians join in 8 rounds at least (clusters_for).

/// What a pixel spans at the board's middle: the median over the views that have a pose, else NaN.
double pixel_at_board_m(const Poses& poses);

/// The fusion's configuration for depths of a sensor: their sigma says how far two of them differ.
FuseConfig fuse_for(const SeedsPipelineConfig& config, const Depths& depths);

/// Of a sensor's depth, what rises above the board by less than the cloud's noise is no object.
BoardClusterConfig clusters_for(const SeedsPipelineConfig& config, const Capture& capture,
                                const Estimate& so_far);

/// A sensor's depth as measurements of a surface: points within a matching window of an object's
/// rim are smeared with the board's and left out; what is left errs together over a window, and
/// all over an object, by as much as the board's patches do. Harmonics finer than the outlines'
/// pixels are left out.
SurfaceFitConfig surface_for(const SeedsPipelineConfig& config, const Capture& capture,
                             const Estimate& so_far);

/// Sigmas of sizes beyond the fit's, in pixels as all of them.
MeshTraitConfig traits_for(const SeedsPipelineConfig& config, double pixel_m);

/// Not solved, with the reason, is what rises above the board by less than `agreement_sigmas` of
/// its cloud's noise or of the height's own sigma: nothing supports that it is there.
Traits without_noise(Traits traits, const SeedsPipelineConfig& config, const Capture& capture,
                     const Estimate& so_far);

/// Traits of clusters of a sensor's points with sigmas: nothing undoes the matching window there,
/// so lengths and widths may be off by one and a half of what it covers on the board, heights by 4
/// sigmas of the cloud, areas by what follows; volumes by their box's, for the shell of points is
/// open below (the scatter of rendered maize before a D405 at 0.15 m, seed 1). Unknown (NaN) where
/// the window or the noise is.
Traits with_point_sigmas(Traits traits, const SeedsPipelineConfig& config, const Capture& capture,
                         const Estimate& so_far);

}  // namespace cousin
