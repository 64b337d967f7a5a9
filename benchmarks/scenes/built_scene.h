#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/scenes/scene_table.h"
#include "sim/config/cousin.h"
#include "sim/geometry/mesh_warnings.h"

namespace cousin {

/// A simulation as the verbs see it; it lives as long as the result.
template <class Simulation>
BuiltScene built_scene(Simulation made) {
  const auto simulation = std::make_shared<const Simulation>(std::move(made));
  const Simulation* s = simulation.get();
  BuiltScene built;
  built.owner = simulation;
  built.scene = &s->scene();
  built.rig = &s->rig();
  built.views = &s->views();
  built.take = [s](int frame, const Streams& streams) { return s->take(frame, streams); };
  built.truth = [s](int frame, const TruthNeeds& needs) { return s->truth(frame, needs); };
  built.capture_header = [s] { return s->capture_header(); };
  built.scene_truth = [s] { return s->scene_truth(); };
  return built;
}

/// What cousin.* moves, as text after a scene's keys.
inline std::string cousins_text(const std::vector<CousinMove>& moves) {
  if (moves.empty()) return {};
  return "\nAt 1, cousin.AXIS moves\n" + describe(moves);
}

inline std::vector<std::string> mesh_warnings(const std::string& file) {
  return file.empty() ? std::vector<std::string>() : user_mesh_warnings(file);
}

}  // namespace cousin
