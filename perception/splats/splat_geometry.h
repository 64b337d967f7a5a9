#pragma once

#include <span>
#include <vector>

#include "perception/cloud/fuse.h"
#include "perception/splats/splat_render.h"
#include "sim/types/seams.h"

namespace cousin {

/// Where a model is looked at from.
struct SplatViewpoint {
  Camera camera;  ///< pinhole
  Pose camera_from_world;
};

/// The centres of the Gaussians whose opacity is at least `least_opacity`, in the model's order:
/// the cloud of the Seeds paper. Colour is the one that does not depend on direction; normals and
/// sigmas are unknown. @throws std::invalid_argument if least_opacity is not in 0..1, if the
/// origin is not finite, or so far away that positions as float would be off by more than a
/// thousandth of what these centres extend over.
Cloud splat_centres(const SplatModel& model, double least_opacity = 0.5);

/// Depth images of a model, as the stages after it take them: `poses` and `depths` are one for each
/// viewpoint, and `capture` has the rendered colours. Depth is where transmittance falls through
/// 1/2; NaN = the ray is never half blocked.
struct SplatDepthImages {
  Capture capture;
  Poses poses;
  Depths depths;
};
SplatDepthImages render_splat_depths(const SplatModel& model, std::span<const SplatViewpoint> from,
                                     const SplatRenderConfig& config = {});

/// The depths of all views as one cloud with normals, colours and sigmas: points that other views
/// agree with (see fuse_depths; no colour is left out).
Cloud fused_splat_cloud(const SplatDepthImages& depths, const FuseConfig& config = {});

/// For each Gaussian the number of views that see it: its centre lies in the image and no deeper
/// than the rendered depth there plus `slack` of its largest standard deviations, or its ray is
/// never half blocked.
/// @throws std::invalid_argument if slack is negative or not finite.
std::vector<int> views_that_see(const SplatModel& model, const SplatDepthImages& depths,
                                double slack = 1);

}  // namespace cousin
