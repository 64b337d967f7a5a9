#pragma once

#include "scenes/strawberries/strawberries_scene.h"

namespace cousin {

/// A stretch whose setting is coarse, for tests of what grows on it.
inline StrawberriesSceneConfig small_stretch(int fruits) {
  StrawberriesSceneConfig config;
  config.stand.fruits_min = config.stand.fruits_max = fruits;
  config.stand.fruit_grid = 16;
  config.bed.row.plants = 3;
  config.bed.row.variants = 1;
  config.bed.path.beds = 0;
  config.bed.film.cell_m = 0.03;
  return config;
}

/// A stand as if nothing had weight: for tests that ask nothing of physics.
inline StandRest weightless(const StrawberriesSceneConfig& config, const Rng& rng) {
  StandRest rest;
  const Rng own = attempt_rng(rng, 0);
  const Stand stand = draw_stand(config.stand, config.bed, own);
  rest.sag.status = PlantStatus::ok;
  for (std::size_t i = 0; i < stand.trusses.size(); ++i) {
    for (const BendingStem& stem : grow_stalks(stand.trusses[i], truss_rng(own, i)).stems) {
      const auto nodes = static_cast<std::size_t>(stem.segments) + 1;
      rest.sag.bent.sections.emplace_back(nodes);
      rest.sag.bent.joints_rad.emplace_back(3 * (nodes - 1), 0.0);
    }
  }
  return rest;
}

inline Scene weightless_scene(const StrawberriesSceneConfig& config, std::uint64_t stretch,
                              std::uint64_t scene) {
  return build_strawberries_scene(config, weightless(config, Rng(stretch)), Rng(stretch),
                                  Rng(scene));
}

}  // namespace cousin
