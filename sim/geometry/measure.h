#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

/// Exact integrals over a closed mesh by the divergence theorem [Eberly, "Polyhedral Mass
/// Properties"; Mirtich 1996], in double, about a local origin so that far-away meshes lose
/// nothing.
struct MassProperties {
  double volume_m3 = 0;  ///< signed: positive for outward triangles
  double area_m2 = 0;
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_m5 = Eigen::Matrix3d::Zero();  ///< about the centroid, density 1
};
MassProperties mass_properties(
    const Mesh& mesh);  ///< @throws std::invalid_argument if empty or not finite

/// Why a mesh cannot be a specimen; `ok` if it can.
struct MeshCheck {
  bool ok = false;
  std::string problem;  ///< "edge 12-57 belongs to 1 triangle; a closed mesh needs 2", ...
  int open_edges = 0;
  int degenerate_triangles = 0;
};
/// Closed (every edge in exactly two triangles, opposite directions), finite, indices in range, one
/// consistent orientation, positive volume.
MeshCheck check_watertight(const Mesh& mesh);

/// Merges vertices that are equal bit by bit (STL repeats them) and drops triangles that become
/// degenerate.
Mesh weld(const Mesh& mesh);

/// All triangles of several meshes as one; nothing is welded.
Mesh merged(std::span<const Mesh> meshes);

/// Convex hull of points as a closed mesh (Qhull). Fewer than four points, or all in one plane or
/// line to 1e-12 of their extent: an empty mesh.
Mesh convex_hull(std::span<const Eigen::Vector3d> points_m);

/// Oriented box, size.x >= size.y >= size.z.
struct OrientedBox {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes =
      Eigen::Matrix3d::Identity();  ///< columns: unit directions of size x, y, z; right-handed
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
};
/// True minimum of the volume over all rotations, where two adjacent sides are flush with edges of
/// the hull [O'Rourke 1985]: starts all over the rotations, the best refined to a relative 1e-9.
/// Flat, collinear, duplicate or single points give a box with zero sizes, never NaN. @throws
/// std::invalid_argument if empty or not finite.
OrientedBox minimum_volume_box(std::span<const Eigen::Vector3d> points_m);
/// The local minimum reached from the axes of `near`, about ten times faster: for points that are a
/// little different from those that `near` was found for. @throws std::invalid_argument also if its
/// axes are not orthonormal.
OrientedBox minimum_volume_box(std::span<const Eigen::Vector3d> points_m, const OrientedBox& near);
/// Boxes that are local minima of the volume, the least first: `least` and those that a search
/// reaches from its axes turned by steps of 15 degrees about each of them. Boxes whose axes all lie
/// within 10 degrees of a better one's are that one. Where volumes are nearly equal, as for a
/// nearly square outline, which one is the least is a matter of noise. @throws as above.
std::vector<OrientedBox> rival_boxes(std::span<const Eigen::Vector3d> points_m,
                                     const OrientedBox& least);
/// The paper's box: axes from the covariance of the points [Seeds 2.3.4].
OrientedBox pca_box(std::span<const Eigen::Vector3d> points_m);

struct CaliperDiameters {
  double maximum_m = 0;  ///< largest distance between two points (Feret)
  double minimum_m =
      0;  ///< smallest distance between parallel supporting planes (width of the convex hull)
};
CaliperDiameters caliper_diameters(std::span<const Eigen::Vector3d> points_m);

/// Alpha shape: Delaunay tetrahedra (Qhull) whose circumscribed sphere has a radius below alpha
/// [Seeds 2.3.5].
struct AlphaShape {
  double volume_m3 = 0;  ///< sum of the kept tetrahedra
  double area_m2 = 0;    ///< of the triangles that bound them
  Mesh boundary;         ///< outward
  int tetrahedra = 0;
};
/// Coplanar, collinear, duplicate or fewer than four points, or none: zero volume and no triangles,
/// never a throw.
/// @throws std::invalid_argument if a point is not finite or alpha_m is not positive.
AlphaShape alpha_shape(std::span<const Eigen::Vector3d> points_m, double alpha_m);

}  // namespace cousin
