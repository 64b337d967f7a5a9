#include "sim/physics/plant_motion.h"

namespace cousin {
namespace {

/// Nothing bent: every section where it was.
BentPlant unbent(const BendingPlant& plant) {
  BentPlant bent;
  for (const BendingStem& stem : plant.stems) {
    const auto segments = static_cast<std::size_t>(stem.segments);
    bent.sections.emplace_back(segments + 1);
    bent.joints_rad.emplace_back(3 * segments, 0.0);
  }
  return bent;
}

}  // namespace

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

}  // namespace cousin
