#pragma once

#include <vector>

#include "scenes/strawberries/truss.h"
#include "sim/physics/penetration.h"
#include "sim/truth/scene.h"

namespace cousin {

/// Private to scenes/strawberries.

/// A hanging fruit as what plants keep off.
struct HangingFruit {
  ConvexBody hull;
  Pose fruit_from_world;
  Eigen::Vector3d centre_m;
  double radius_m = 0;

  HangingFruit(const Mesh& mesh, const Pose& world_from_fruit);
  /// Negative outside: at most the distance, or minus `far_m` beyond it.
  double depth_m(const Eigen::Vector3d& in_world_m, double far_m) const;
};
std::vector<HangingFruit> hanging_fruits(const std::vector<Truss>& trusses);

/// Where leaves may be: off the fruits and out of the bed.
struct TrussLeafRoom {
  std::vector<HangingFruit> fruits;
  std::vector<BendingObstacle> bed;
  double clear_m = 0;  ///< from fruits

  /// Whether no vertex of a part comes near a fruit or into the bed.
  bool is_free(const Mesh& part, const Pose& world_from_part) const;
};

/// Sepals that reach into fruits beside them lie on these instead: vertices of each fruit's calyx
/// move out of other fruits, away from their middles, until they are `clear_m` off.
void lay_sepals(std::vector<Truss>& trusses, double clear_m);

}  // namespace cousin
