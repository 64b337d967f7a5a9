#include "sim/physics/plant_motion.h"

namespace cousin {
SagResult sag(const BendingPlant& plant, const SagConfig& config) {
  validate(config);
  validate(plant);
  SagResult result;
  result.status = plant.stems.empty() ? PlantStatus::ok : PlantStatus::not_built;
  result.bent = unbent(plant);
  return result;
}

SwayResult sway(const BendingPlant& plant, const BentPlant& from, const std::vector<HandPush>&,
                const SwayConfig& config, Rng) {
  validate(config);
  validate(plant);
  SwayResult result;
  result.status = plant.stems.empty() ? PlantStatus::ok : PlantStatus::not_built;
  result.frames = {from};
  return result;
}

SwayResult sway_windows(const BendingPlant& plant, const BentPlant& from,
                        const std::vector<HandPush>&, const SwayConfig& config, const WindField&,
                        const SwayWindows& windows) {
  validate(config);
  validate(plant);
  validate(windows);
  SwayResult result;
  result.status = plant.stems.empty() ? PlantStatus::ok : PlantStatus::not_built;
  result.frames = {from};
  return result;
}

}  // namespace cousin
