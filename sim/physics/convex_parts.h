#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

struct ConvexPartsConfig {
  double max_gap_m =
      2e-5;  ///< mean distance of the hulls from the surface: excess volume over area
  int max_parts = 8;
  double follow_m =
      1.4e-5;  ///< thinning a hull's corners leaves none of them farther outside than this
};

struct ConvexParts {
  std::vector<Mesh>
      hulls;          ///< closed, convex, in the mesh's frame; neighbours share their cut face
  double gap_m = 0;   ///< reached, before thinning; more than max_gap_m where max_parts ran out
  double excess = 0;  ///< volume of the hulls over the mesh's, minus 1
};

/// Cuts a closed mesh by planes across its box's axes until the hulls of the pieces follow its
/// shape, worst piece first.
/// @throws std::invalid_argument if the mesh is empty, flat or not finite.
ConvexParts convex_parts(const Mesh& mesh, const ConvexPartsConfig& config = {});

}  // namespace cousin
