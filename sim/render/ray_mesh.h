#pragma once

#include <cstddef>

#include "sim/render/ray_scene_impl.h"
#include "sim/truth/scene.h"

namespace cousin {

/// Private to sim/render: the triangles of RayScene.

/// How a model's triangles become a RayMesh.
struct MeshPlacement {
  bool is_instanced = false;  ///< in the model's axes about its middle; else placed by `pose`
  Pose world_from_object;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< RayScene's, subtracted from the world
  bool has_print = false;                              ///< some instance's material has a print
  double print_bend_m = 0;                             ///< Material's, the largest of them
  bool keeps_planes = true;
};

/// @throws std::invalid_argument naming the model if a coordinate does not fit.
RayMesh make_ray_mesh(const ObjectModel& model, const MeshPlacement& placement);

/// Corners of a mesh's bounds; of the origin if it has no vertices.
std::array<Eigen::Vector3d, 8> box_corners(const Mesh& mesh);

}  // namespace cousin
