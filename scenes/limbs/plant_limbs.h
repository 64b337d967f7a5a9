#pragma once

#include "sim/config/fields.h"
#include "sim/physics/limbs.h"
#include "sim/plant/plant.h"

namespace cousin {

/// How stiff and how heavy a species' organs are, for motion in the wind. Every value is given in
/// the species' TOML.
struct LimbConfig {
  double stem_modulus_pa = 0, petiole_modulus_pa = 0;
  double blade_modulus_pa = 0;  ///< of a rod as thick as the midrib's line that bends as the blade
  double least_radius_m = 0;    ///< of that rod, and of petioles
  double density_kg_m3 = 0;     ///< of stems and petioles
  double leaf_kg_m2 = 0, cotyledon_kg_m2 = 0;  ///< fresh mass over one side's area
  double damping_time_s = 0;                   ///< tau of c = tau k
  double drag_coefficient = 0;                 ///< of a blade's one side, up to 1 m/s
  double reconfiguration = 0;                  ///< drag grows as speed to 2 + this above
  double modulus_spread = 0;                   ///< sigma from plant to plant over the mean
  int stem_segments = 0, petiole_segments = 0, blade_segments = 0;
  double least_leaf_m = 0;  ///< shorter blades move with what bears them
  double lead_s = 0;        ///< of wind before the first view
};
Fields fields(LimbConfig& config);

/// The stems that bend a plant: its stalk, of all its organs of that kind in a row, on it the
/// petioles and blades; and which of their sections carries each triangle and keypoint of
/// plant_model(plant). Blades bend about their midrib's line. Sheaths, ligules, flowers and roots
/// go with the stalk where they are nearest to it; a blade too short with all of it. Blades carry
/// their mass and drag section by section.
/// @param wind_m_s  mean speed that the drag is for  @param rng  the plant's own stiffness
/// @return no stems for a plant without a stalk: nothing moves
Limbs plant_limbs(const Plant& plant, const PlantModel& model, const LimbConfig& config,
                  double wind_m_s, Rng rng);

}  // namespace cousin
