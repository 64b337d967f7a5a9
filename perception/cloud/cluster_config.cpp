#include "perception/cloud/clusters.h"
#include "sim/config/limits.h"

namespace cousin {

Fields fields(PaperClusterConfig& c) {
  return {{"outlier_neighbours", &c.outlier_neighbours, "of statistical outlier removal", 1, 1000},
          {"outlier_sigma", &c.outlier_sigma,
           "standard deviations beyond which a point is an outlier", 0, 100},
          {"voxel_m", &c.voxel_m, "side of the voxel grid", 1e-6, 0.1},
          {"plane_distance_m", &c.plane_distance_m, "inliers of the RANSAC plane", 1e-6, 0.1},
          {"cluster_distance_m", &c.cluster_distance_m, "points nearer than this belong together",
           1e-6, 0.1},
          {"cluster_min_points", &c.cluster_min_points, "smaller clusters are noise", 1, 1e9}};
}

void validate(const PaperClusterConfig& config) {
  PaperClusterConfig copy = config;
  check_limits(fields(copy), "paper_clusters");
}

Fields fields(BoardClusterConfig& c) {
  return {
      {"min_height_m", &c.min_height_m, "surely above the board", 0, 0.1},
      {"low_height_m", &c.low_height_m, "coloured points above this belong to an object", 0, 0.1},
      {"min_saturation", &c.min_saturation, "of an object that is not grey like the board", 0, 1},
      {"min_top_m", &c.min_top_m, "an object reaches at least this high", 0, 0.1},
      {"min_share", &c.min_share, "smallest object over the largest, in upward points", 0, 1},
      {"core_distance_m", &c.core_distance_m, "steps that link the upward faces of one object",
       1e-6, 0.1},
      {"cluster_distance_m", &c.cluster_distance_m, "points nearer than this belong together", 1e-6,
       0.1},
      {"join_rounds", &c.join_rounds,
       "times that points join, each cluster_distance_m farther from an object's top; splats: 8 if "
       "less",
       1, 1000},
      {"join_saturation", &c.join_saturation,
       "share of an object's own saturation that points need to join it; splats: 0.5 if less", 0,
       1},
      {"cluster_min_points", &c.cluster_min_points, "smaller clusters are noise", 1, 1e9}};
}

void validate(const BoardClusterConfig& config) {
  BoardClusterConfig copy = config;
  check_limits(fields(copy), "clusters");
}

Surfaces surfaces_of_clusters(const Clusters& clusters) {
  Surfaces surfaces(static_cast<std::size_t>(clusters.count));
  for (std::size_t i = 0; i < surfaces.size(); ++i) surfaces[i].instance = static_cast<int>(i);
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    if (clusters.instance[i] < 0) continue;
    surfaces.at(static_cast<std::size_t>(clusters.instance[i]))
        .points_m.push_back(clusters.cloud[i].position_m.cast<double>());
  }
  for (Surface& surface : surfaces) {
    surface.status = surface.points_m.empty() ? SurfaceStatus::empty : SurfaceStatus::ok;
  }
  return surfaces;
}

}  // namespace cousin
