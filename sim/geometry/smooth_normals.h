#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

/// Unit normals at the vertices: the triangles' normals weighted by area; +z where there are none.
std::vector<Eigen::Vector3f> smooth_normals(const Mesh& mesh);

}  // namespace cousin
