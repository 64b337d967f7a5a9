#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/types/mesh.h"
#include "sim/types/rng.h"

namespace cousin {

/// Distance from anywhere to the nearest of many triangles or points, exact, by a tree of boxes.
class DistanceTree {
 public:
  /// @throws std::invalid_argument if there are no triangles, an index is out of range or a vertex
  /// not finite.
  explicit DistanceTree(const Mesh& mesh);
  /// @throws std::invalid_argument if there are no points or one is not finite.
  explicit DistanceTree(std::span<const Eigen::Vector3d> points_m);

  double distance_m(const Eigen::Vector3d& point_m) const;
  /// The same with a sign: positive on the side that the nearest triangle faces (outside of a
  /// closed mesh with outward triangles). Where several triangles are nearest, at
  /// an edge or a corner, their normals are weighted by angle; points and flat triangles have no
  /// sides: positive.
  double signed_distance_m(const Eigen::Vector3d& point_m) const;
  /// Unit normal of the nearest triangle, outward of a closed mesh with outward triangles; where
  /// several are nearest, their mean weighted by angle. Zero for points and flat triangles.
  Eigen::Vector3d normal_at(const Eigen::Vector3d& point_m) const;
  /// Whether a triangle lies across the way from one point to another, between them. Edges belong
  /// to their triangles, so that no way leads between two of them; ways along a triangle's plane
  /// are free.
  bool blocks(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const;

 private:
  struct Node {
    Eigen::Vector3d low = Eigen::Vector3d::Zero();
    Eigen::Vector3d high = Eigen::Vector3d::Zero();
    std::uint32_t first =
        0;  ///< of its triangles, or its left child; the right one follows the left
    std::uint32_t count = 0;  ///< of triangles; 0 = inner node
  };
  struct Nearest {
    double distance2 = 0;
    double facing = 0;                                 ///< its sign is that of the side
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< times the angle
  };
  Nearest nearest(const Eigen::Vector3d& point) const;
  void build();
  double box_distance2(const Node& node, const Eigen::Vector3d& point) const;

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<std::array<std::uint32_t, 3>>
      triangles_;  ///< a point is a triangle of one vertex three times
  std::vector<Node> nodes_;
};

/// Distance from a point to a triangle; triangles that are lines or points are fine.
double point_triangle_distance_m(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Points spread evenly over the area of a mesh: stratified along the sum of areas.
std::vector<Eigen::Vector3d> sample_surface(const Mesh& mesh, int count, Rng rng);

/// A measured cloud against a true surface [terms of Knapitsch et al., "Tanks and Temples", 2017].
struct CloudScore {
  std::int64_t measured_points = 0;  ///< that accuracy and precision are over
  std::int64_t surface_samples = 0;  ///< that completeness and recall are over
  double accuracy_mean_m = 0;        ///< cloud to surface
  double bias_m = 0;                 ///< mean signed distance, outside of a closed surface positive
  double accuracy_rms_m = 0;
  double accuracy_median_m = 0;
  double accuracy_p95_m = 0;
  double completeness_mean_m = 0;  ///< surface to cloud
  double completeness_p95_m = 0;
  struct AtTolerance {
    double tolerance_m = 0;
    double precision = 0;  ///< share of the cloud within the tolerance of the surface
    double recall = 0;     ///< share of the surface within the tolerance of the cloud
    double f1 = 0;         ///< harmonic mean; 0 if both are 0
  };
  std::vector<AtTolerance> at;
};
/// @param cloud_m           measured points
/// @param surface           the true mesh, in the frame of the cloud
/// @param surface_samples_m points of the true surface that ought to be found: all of it, or what
/// cameras can see. An empty cloud scores precision and recall 0 and distances NaN. The same bytes
/// on any number of threads.
/// @throws std::invalid_argument if the surface or the samples are empty, or a point is not finite.
CloudScore score_cloud(std::span<const Eigen::Vector3d> cloud_m, const Mesh& surface,
                       std::span<const Eigen::Vector3d> surface_samples_m,
                       std::span<const double> tolerances_m);

/// A measured closed surface, the same way: `measured_samples_m` are points spread over it by
/// `sample_surface`; the true samples' distances are to its triangles, so that they do not depend
/// on how many points were drawn.
CloudScore score_mesh(const Mesh& measured, std::span<const Eigen::Vector3d> measured_samples_m,
                      const Mesh& surface, std::span<const Eigen::Vector3d> surface_samples_m,
                      std::span<const double> tolerances_m);

/// Angles between measured normals and the true surface's nearest to where they were measured, from
/// 0 to pi: a normal that points inward is pi off.
struct NormalScore {
  std::int64_t measured = 0;           ///< normals that are not zero
  std::int64_t points = 0;             ///< with and without
  double median_rad = 0, p95_rad = 0;  ///< NaN if none is measured
};
/// @param normals  of any length but zero, which is unknown
/// @throws std::invalid_argument if the surface is empty, the lengths differ or a point or a
/// normal is not finite.
NormalScore score_normals(std::span<const Eigen::Vector3d> points_m,
                          std::span<const Eigen::Vector3d> normals, const Mesh& surface);

}  // namespace cousin
