#pragma once

#include "sim/types/mesh.h"

namespace cousin {

/// The unit sphere as an icosahedron whose triangles are split in four `subdivisions` times:
/// 10 * 4^n + 2 vertices of unit length, triangles counter-clockwise seen from outside.
/// @throws std::invalid_argument unless 0 <= subdivisions <= 8.
Mesh icosphere(int subdivisions);

}  // namespace cousin
