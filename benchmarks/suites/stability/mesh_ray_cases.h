#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Rays at meshes that are not what they should be, each laid out in the world and shared by two
/// instances: triangles without area, numbers that are not finite, coincident surfaces, a camera
/// on a leaf and inside one of 0.2 mm, and exact depth at scales 1e-4..1e4 and offsets to 1e5 m.
std::vector<StabilityRow> mesh_ray_cases();

}  // namespace cousin
