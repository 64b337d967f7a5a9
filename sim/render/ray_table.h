#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/camera.h"

namespace cousin {

/// Unit directions in the camera of the points (first_x + i, first_y + j), i < width, j < height,
/// row by row; zero where the lens model gives no ray.
///
/// The lens is unprojected exactly on a grid of nodes and interpolated between them by Lagrange
/// polynomials of degree 5. The grid starts at 32 px and is halved until, at cell centres spread
/// over the image, the direction is within `tolerance_px` of the exact one; below 2 px every point
/// is unprojected exactly. Points without a full stencil of nodes are unprojected exactly.
std::vector<Eigen::Vector3d> lens_directions(const Camera& camera, double first_x, double first_y,
                                             int width, int height, double tolerance_px);

}  // namespace cousin
