#pragma once

#include "sim/types/mesh.h"

namespace cousin {

/// The unit sphere as a cube of `grid` x `grid` cells a face, at equal angles: 6 grid^2 + 2
/// vertices, closed, outward.
Mesh cube_sphere(int grid);

}  // namespace cousin
