#pragma once

#include <string>
#include <vector>

#include "scenes/limbs/plant_limbs.h"
#include "sim/physics/rigid_sway.h"

namespace cousin {

/// A hand that pushes one leaf and lets go while a view is taken.
struct HandConfig {
  double force_n = 0;                            ///< largest; 0 = no hand
  int plant = 0;                                 ///< the number in the specimen's name
  int leaf = 0;                                  ///< "leaf N"; 0 = the stalk's upper end
  double azimuth_rad = 0, elevation_rad = -1.2;  ///< where it pushes to, from +x to +y and up
  int view = 0;                                  ///< whose time_s is the middle of the push
  double seconds = 0.5;
};

/// What moves a scene's plants while it is photographed.
struct SceneWind {
  WindConfig wind;  ///< still by default
  HandConfig push;
  /// organs: leaves and stems bend apart, by physics; plants: each sways about its foot as one
  /// body.
  std::string moves = "organs";
};
/// "wind", "gusts.", "push.", "moves": keys of a scene.
Fields fields(SceneWind& config);
/// @throws std::invalid_argument for a `moves` that is neither.
void validate(const SceneWind& config);
inline bool is_still(const SceneWind& config) {
  return config.wind.mean_speed_m_s == 0 && config.push.force_n == 0;
}

/// A kind of plant that some of a scene's specimens show.
struct PlantKind {
  const Plant* plant = nullptr;
  const PlantModel* model = nullptr;
  std::vector<std::size_t> specimens;  ///< places in Scene::instances; they share its model
};

/// Gives a scene's specimens their motion about the times of its views: in gusts that all feel, and
/// one of them under a hand. Still air without a hand changes nothing. Of `kinds` each specimen's
/// organs become instances of their own.
/// @param height_share  of the trait "height", where whole plants feel the wind
/// @throws std::invalid_argument for a hand on a plant, leaf or view that is not there;
/// std::runtime_error as sway_limbs.
void move_plants(Scene& scene, const std::vector<PlantKind>& kinds, const SceneWind& config,
                 const LimbConfig& limbs, const RigidSwayConfig& whole, double height_share,
                 const Rng& rng);

}  // namespace cousin
