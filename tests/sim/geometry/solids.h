#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "sim/types/mesh.h"
#include "sim/types/rng.h"

namespace cousin {

Mesh box_mesh(const Eigen::Vector3d& size_m);  ///< about the origin
/// Octahedron divided `levels` times, on the sphere and scaled by the semi-axes.
Mesh ellipsoid_mesh(const Eigen::Vector3d& semi_axes_m, int levels);
/// Corners of a cube of side 2 that make a regular tetrahedron of edge 2 sqrt 2.
Mesh tetrahedron_mesh();

Eigen::Matrix3d random_rotation(Rng& rng);
std::vector<Eigen::Vector3d> moved(std::vector<Eigen::Vector3d> points,
                                   const Eigen::Matrix3d& rotation,
                                   const Eigen::Vector3d& translation);
Mesh moved(Mesh mesh, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation);
std::vector<Eigen::Vector3d> shuffled(std::vector<Eigen::Vector3d> points, Rng rng);
std::vector<Eigen::Vector3d> random_points(int count, const Eigen::Vector3d& scale, Rng rng);

/// Point sets that span no volume, by name.
struct FlatCase {
  const char* name;
  std::vector<Eigen::Vector3d> points;
};
std::vector<FlatCase> flat_cases();

}  // namespace cousin
