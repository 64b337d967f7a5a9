#pragma once

#include <string>
#include <vector>

#include "scenes/seeds/seeds_scene.h"
#include "scenes/seeds/setting.h"
#include "sim/physics/convex_parts.h"

namespace cousin {

/// What is put on the board. Private to scenes/seeds.
struct BoardSpecimen {
  SeedModel seed;
  Material material;
  std::string category;
  double radius_m = 0;  ///< of the sphere around its centroid
  ConvexParts parts;    ///< what collides
};

/// Uniform over all rotations [Shoemake 1992].
Eigen::Quaterniond random_rotation(Rng& rng);

/// Drops the specimens; new spots are drawn where they do not come to rest apart from each other.
/// @throws std::runtime_error if they cannot be settled, saying why.
std::vector<Pose> drop_apart(const std::vector<BoardSpecimen>& specimens,
                             const SettingConfig& setting, Rng rng);

}  // namespace cousin
