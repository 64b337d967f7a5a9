#pragma once

#include "sim/types/mesh.h"
#include "sim/types/rng.h"

namespace cousin {

/// A mesh as another of its kind might have grown: each axis has a factor of its own, and three
/// smooth waves between two and four mean radii long move the vertices. Up to a variation of 0.3
/// the map is one to one, so a closed mesh stays closed and does not cut itself.
/// @param variation  standard deviation of the logarithm of a factor; a wave's amplitude is a sixth
///                   of it times the mean radius. 0: the mesh itself, bit by bit
Mesh varied_mesh(const Mesh& mesh, double variation, Rng rng);

}  // namespace cousin
