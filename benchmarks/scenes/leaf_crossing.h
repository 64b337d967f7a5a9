#pragma once

#include "sim/geometry/surface_crossing.h"
#include "sim/truth/scene.h"

namespace cousin {

/// How much of a scene's leaf area crosses other leaves, of the same plant or another: leaves are
/// the parts of specimens whose material is a leaf.
SurfaceCrossing leaf_crossing(const Scene& scene);

}  // namespace cousin
