#pragma once

#include <vector>

#include "sim/geometry/surface_crossing.h"
#include "sim/truth/scene.h"

namespace cousin {

/// How much of a scene's leaf area crosses other leaves, of the same plant or another: leaves are
/// the parts of specimens whose material is a leaf.
SurfaceCrossing leaf_crossing(const Scene& scene);
/// The same of some instances.
SurfaceCrossing leaf_crossing(const Scene& scene, const std::vector<const Instance*>& plants);

}  // namespace cousin
