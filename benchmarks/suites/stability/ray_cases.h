#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/suites/stability/stability_row.h"
#include "sim/types/mesh.h"
#include "sim/types/rng.h"

namespace cousin {

struct RayCasesConfig {
  std::int64_t watertight_rays = 10'000'000;
  int offset_rays = 20'000;  ///< for each scale and offset
};

/// Ray tracing at its limits: self-hits and leaks at scene scales 1e-4..1e4 and distances 0..1e5
/// from the world's origin, watertightness from inside, depth at grazing incidence, needle
/// triangles.
std::vector<StabilityRow> ray_cases(const RayCasesConfig& config, Rng rng);

/// Rays from inside a closed mesh whose centroid lies inside; none may escape.
StabilityRow watertight_case(const std::string& name, const Mesh& mesh, std::int64_t rays, Rng rng);

}  // namespace cousin
