#pragma once

#include <vector>

#include "scenes/strawberries/leaf_room.h"
#include "scenes/strawberries/strawberry_bed.h"
#include "scenes/strawberries/strawberry_plant.h"

namespace cousin {

/// Private to scenes/strawberries: plants in their rows.

/// A leaf that is an instance of its own, about the base of its petiole.
struct LoneLeaf {
  std::size_t place = 0;                              ///< into Scene::instances
  Eigen::Vector3d blade_m = Eigen::Vector3d::Zero();  ///< middle of its leaflets, in its frame
};

struct RowPlaces {
  std::vector<Eigen::Vector3d> near_m, far_m;  ///< crowns of the bed's two rows
};

/// Plants of the near row, each its own and off the fruits; then variants of them in the far row
/// and on the beds behind.
/// @param apart  leaves of the near row are instances of their own, "plant NN leaf K" with the
/// parts petiole and three leaflets, beside "plant NN" with the rest
/// @return those leaves
std::vector<LoneLeaf> add_strawberry_plants(Scene& scene, const StrawberryPlantConfig& config,
                                            const StrawberryBedConfig& bed,
                                            const TrussLeafRoom& room, const RowPlaces& rows,
                                            bool apart, const Rng& rng);

}  // namespace cousin
