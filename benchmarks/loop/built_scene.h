#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/loop/scene_table.h"
#include "sim/config/cousin.h"
#include "sim/geometry/mesh_warnings.h"
#include "sim/types/stage_clock.h"

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
  built.truth = [s](int frame, const TruthNeeds& needs, std::size_t sensor) {
    return s->truth(frame, needs, sensor);
  };
  built.capture_header = [s] { return s->capture_header(); };
  built.scene_truth = [s] { return s->scene_truth(); };
  return built;
}

/// All frames of a built scene and the truth that `needs` asks for, in memory, with the seconds of
/// each pass but the building's.
inline void take_frames(const BuiltScene& built, const Streams& streams, const TruthNeeds& needs,
                        const Progress& progress, SimulatedRun& run) {
  const int frames = static_cast<int>(built.views->size());
  const auto say = [&](const char* what, int done) {
    if (progress) progress(what, done, frames);
  };
  run.capture = built.capture_header();
  std::vector<RigFrame> of_depth;  // what is true of the depth taken
  const StageClock render_clock("render");
  for (int i = 0; i < frames; ++i) {
    say("render", i);
    of_depth.push_back(built.take(i, streams));
    run.capture.frames.push_back(std::move(of_depth.back().frame));
  }
  run.timings.push_back(render_clock.finish());
  const StageClock truth_clock("truth");
  run.truth = built.scene_truth();
  const bool any = needs != TruthNeeds{};
  for (int i = 0; any && i < frames; ++i) {
    say("truth", i);
    TruthImages& images = run.truth.images.emplace_back(built.truth(i, needs, 0));
    RigFrame& own = of_depth[static_cast<std::size_t>(i)];
    if (needs.noise_free_depth) images.noise_free_depth_m = std::move(own.noise_free_depth_m);
    if (needs.invalid_reason) images.invalid_reason = std::move(own.invalid_reason);
  }
  add_other_sensors(
      other_true_sensors(*built.rig, streams, needs),
      [&](int frame, std::size_t sensor) { return built.truth(frame, needs, sensor); }, run.truth);
  run.timings.push_back(truth_clock.finish());
}

/// The pipeline of a request, kept by the functions of a job; none if nobody reads the images.
class KeptPipeline {
 public:
  explicit KeptPipeline(const PipelineConfig* pipeline) {
    if (!pipeline) return;
    config_ = *pipeline;
    reader_ = reader_of(*pipeline);
  }
  const PipelineConfig* config() const { return config_ ? &*config_ : nullptr; }
  const StreamReader* reader() const { return reader_ ? &*reader_ : nullptr; }

 private:
  std::optional<PipelineConfig> config_;
  std::optional<StreamReader> reader_;
};

/// What cousin.* moves, as text after a scene's keys.
inline std::string cousins_text(const std::vector<CousinMove>& moves) {
  if (moves.empty()) return {};
  return "\nAt 1, cousin.AXIS moves\n" + describe(moves);
}

inline std::vector<std::string> mesh_warnings(const std::string& file) {
  return file.empty() ? std::vector<std::string>() : user_mesh_warnings(file);
}

}  // namespace cousin
