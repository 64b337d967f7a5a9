#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "scenes/apples/apple_cultivar.h"
#include "scenes/fruit/fruit_model.h"
#include "sim/types/rng.h"

namespace cousin {

/// What of an apple is asked for, beside its cultivar.
struct AppleConfig {
  std::string cultivar = "fuji";
  std::optional<double> red_share;       ///< of the surface; absent: drawn as the cultivar says
  double growth = 1;                     ///< size over a ripe fruit's, 0.1..1
  Eigen::Vector3d to_sun = {1, 0, 0.5};  ///< in the fruit's frame: the side that colours first
  FruitFamily family = FruitFamily::botanical;
  double elongation = 1;  ///< times the shape index drawn, 0.4..2.5
  int grid = 0;           ///< cells along an edge of the mesh's cube, 4..200; 0: the cultivar's
};
/// @throws std::invalid_argument naming key, value and limit.
void validate(const AppleConfig& config);

/// An apple with stalk and calyx; see FruitModel. Keypoints: calyx_centre, stalk_base, cut_point
/// (the stalk's end). Mass is drawn first (cut normal) and the volume follows from it and the
/// density drawn. Deterministic in (config, rng).
FruitModel make_apple(const AppleConfig& config, Rng rng);
/// The same of a cultivar whose numbers are given; `config.cultivar` is its name alone.
FruitModel make_apple(const AppleConfig& config, const AppleCultivar& cultivar, Rng rng);

// The steps of make_apple.

struct AppleFlesh {
  Mesh mesh;                                ///< closed, centred
  std::vector<Eigen::Vector3d> directions;  ///< unit, of each vertex on the sphere it was
  std::vector<Eigen::Vector3d> normals;
};
AppleFlesh make_apple_flesh(const AppleCultivar& cultivar, FruitFamily family, double shape_index,
                            double volume_m3, Rng rng);

/// Ground colour, blush on the sunny side, streaks from stalk to calyx, lenticels and russet.
std::vector<Rgbf> color_apple(const AppleCultivar& cultivar, const AppleFlesh& flesh,
                              double red_share, const Eigen::Vector3d& to_sun, Rng rng);

}  // namespace cousin
