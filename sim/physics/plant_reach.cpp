#include "sim/physics/plant_reach.h"

#include <algorithm>

namespace cousin {

std::vector<Reach> reaches_of(const BendingPlant& plant) {
  std::vector<Reach> reaches;
  std::vector<double> begin_m(plant.stems.size(), 0);  // along the stems from the root
  std::vector<std::size_t> root(plant.stems.size(), 0);
  const auto extend = [&](std::size_t stem, double to_m) {
    Reach& reach = reaches[root[stem]];
    reach.radius_m = std::max(reach.radius_m, to_m);
  };
  for (std::size_t s = 0; s < plant.stems.size(); ++s) {
    const BendingStem& stem = plant.stems[s];
    if (stem.parent < 0) {
      root[s] = reaches.size();
      reaches.push_back({stem.points_m.front(), 0});
    } else {
      const auto p = static_cast<std::size_t>(stem.parent);
      root[s] = root[p];
      // Where it begins may lie off its parent's line.
      begin_m[s] = begin_m[p] + stem.parent_share * length_m(plant.stems[p]) +
                   (stem.points_m.front() - point_at_m(plant.stems[p], stem.parent_share)).norm();
    }
    extend(s, begin_m[s] + length_m(stem) +
                  *std::max_element(stem.radii_m.begin(), stem.radii_m.end()));
  }
  for (const BendingLoad& load : plant.loads) {
    const auto s = static_cast<std::size_t>(load.stem);
    double size_m = 0;
    for (const Mesh& hull : load.hulls) {
      for (const Eigen::Vector3d& v : hull.vertices_m) size_m = std::max(size_m, v.norm());
    }
    const double off_m = (load.centroid_m - point_at_m(plant.stems[s], load.share)).norm();
    extend(s, begin_m[s] + load.share * length_m(plant.stems[s]) + off_m + size_m);
  }
  // The chain's straight sections are as long as the line at most; a hundredth for contacts' reach.
  for (Reach& reach : reaches) reach.radius_m *= 1.01;
  return reaches;
}

bool is_reached(const std::vector<Reach>& reaches, const BendingObstacle& obstacle,
                const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
  const Pose box_from_world = inverse(obstacle.world_from_box);
  return std::any_of(reaches.begin(), reaches.end(), [&](const Reach& reach) {
    const Eigen::Vector3d centre = box_from_world * reach.centre_m;
    const double far_m = (centre - centre.cwiseMax(low_m).cwiseMin(high_m)).norm();
    return far_m <= reach.radius_m || depth_m(obstacle, reach.centre_m) > 0;
  });
}

}  // namespace cousin
