#pragma once

#include "sim/config/fields.h"
#include "sim/types/rng.h"
#include "sim/types/seams.h"

namespace cousin {

/// The paper's steps on a cloud: statistical outlier removal, voxel grid, RANSAC plane, Euclidean
/// clusters (PCL).
struct PaperClusterConfig {
  int outlier_neighbours = 20;
  double outlier_sigma = 2.0;
  double voxel_m = 0.0003;
  double plane_distance_m = 0.0006;
  double cluster_distance_m = 0.0012;
  int cluster_min_points = 60;
};
Fields fields(PaperClusterConfig& config);
void validate(const PaperClusterConfig& config);
/// The cloud after outlier removal and voxel grid, with what is above the plane clustered; what
/// lies in the plane or below it is no seed: centres of Gaussians hang there by the thousand.
/// Points that are not finite are left out. PCL works in float: the cloud is centred first.
/// Instances are ordered by their first point. A cloud too small for a plane has no clusters.
/// @param up  from the board to where it is photographed from, of any length
/// @throws std::runtime_error if built without PCL.
Clusters cluster_as_paper(const Cloud& cloud, const PaperClusterConfig& config, Rng rng,
                          const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/// Ours: the board's plane is known (z = 0), points below `min_height_m` are the board, colour
/// separates what is left of it.
struct BoardClusterConfig {
  double min_height_m = 0.0005;   ///< surely above the board
  double low_height_m = 0.00015;  ///< above this, points in an object's own colour belong to it
  double min_saturation =
      0.25;  ///< (max - min) / max of an object that can be told from the grey board
  double min_top_m =
      0.0012;  ///< an object reaches at least this high; lower groups are noise of the board
  double core_distance_m = 0.0008;  ///< steps that link the upward faces of one object
  double cluster_distance_m =
      0.0012;  ///< other points join the core they are nearest to within this
  /// Times that points join, each `cluster_distance_m` farther from the core. Plane sweeps smear
  /// between objects that nearly touch, so 1; of clouds without smears sides may join to the board.
  int join_rounds = 1;
  /// Points join an object if their saturation is at least this share of the median of its core's:
  /// board at a pale grain's foot is paler than the grain. 0: any may.
  double join_saturation = 0;
  double min_share =
      0.08;  ///< of the largest object's upward points: smaller ones are patches, not objects
  int cluster_min_points = 60;
};
Fields fields(BoardClusterConfig& config);
void validate(const BoardClusterConfig& config);
/// All finite points of the cloud, in their order. The cores of objects are Euclidean clusters of
/// points above `min_height_m` that face up, coloured ones apart from grey ones; those that reach
/// no higher than `min_top_m` are noise. The sides join the core they are nearest to. Clusters
/// below `cluster_min_points` are no objects. Instances are ordered by their first point.
Clusters cluster_on_board(const Cloud& cloud, const BoardClusterConfig& config);

/// How a cluster lies on the board, to notice seeds that touch.
struct ClusterShape {
  int points = 0;
  double footprint_m2 = 0;      ///< area of the cells of the board that the cluster covers
  double solidity = 0;          ///< footprint over that of its convex hull: near 1 for one seed
  bool may_be_several = false;  ///< the footprint has a waist
};
std::vector<ClusterShape> cluster_shapes(const Clusters& clusters);  ///< one for each instance

/// The clusters' points as surfaces without a mesh, for chains that measure points.
Surfaces surfaces_of_clusters(const Clusters& clusters);

}  // namespace cousin
