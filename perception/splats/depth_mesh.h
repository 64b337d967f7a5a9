#pragma once

#include <Eigen/Core>

#include "sim/types/mesh.h"
#include "sim/types/seams.h"

namespace cousin {

struct DepthMeshConfig {
  /// What a pixel without depth says.
  enum class NoDepth {
    unknown,  ///< nothing: it was not measured
    free      ///< its ray meets nothing, as a rendered one that is never half blocked
  };
  Eigen::Vector3d low_m{-0.1, -0.1, -0.1};  ///< the box that is meshed; beyond it all is outside
  Eigen::Vector3d high_m{0.1, 0.1, 0.1};
  double step_m = 0.002;        ///< of the lattice
  double truncation_m = 0.008;  ///< how far from a surface its distance counts
  int free_views = 2;         ///< views that must see through a place before it is held to be free
  double least_part = 0.05;   ///< parts smaller than this share of the largest one's area go
  double most_points = 64e6;  ///< of the lattice
  NoDepth no_depth = NoDepth::free;
};
void validate(const DepthMeshConfig& config);  ///< throws std::invalid_argument

/// One closed mesh from the depth images of many views: signed distances along the rays, cut off
/// at the truncation and averaged on a lattice [Curless & Levoy, SIGGRAPH 1996], and the surface
/// where they pass through zero. What no view sees through, though some see what hides it, is
/// inside; what lies in no image is outside. Outward triangles; empty if there is no surface. TBB;
/// the same bytes on any number of threads. Views without a pose or depth add nothing.
/// @param poses   one for each of `depths`, same order
/// @throws std::invalid_argument if counts or sizes differ or the configuration is invalid.
Mesh mesh_of_depths(const Poses& poses, const Depths& depths, const DepthMeshConfig& config = {});

}  // namespace cousin
