#include "benchmarks/loop/scene_table.h"

#include <stdexcept>

#include "benchmarks/loop/built_scene.h"
#include "benchmarks/loop/plant_scenes.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/loop/simulator_plan.h"

namespace cousin {
namespace {

SceneJob configure_seeds(const SceneRequest& request) {
  PipelineConfig* const pipeline = request.pipeline;
  SeedsRunConfig config = seeds_run_config(request.assignments, request.file, pipeline);
  const KeptPipeline kept(pipeline);  // as the configuration left it
  SceneJob job;
  job.keys = describe(fields(config, pipeline)) + cousins_text(seeds_cousin_moves());
  job.toml = resolved_toml(config, pipeline);
  job.rig = config.rig;
  job.streams =
      streams_for(config.streams, streams_of(config.rig), config.scene.rig, kept.reader());
  job.depth_by = config.capture.depth_by;
  job.views = config.scene.views;
  job.hash = [config, kept](std::uint64_t seed) {
    return config_hash(config, seed, kept.config());
  };
  job.plan = [config, kept] { return simulator_plan(config, kept.reader()); };
  job.build = [config](std::uint64_t seed, int index) {
    return built_scene(SeedsSimulation(config, seed, index));
  };
  job.simulate = [config, streams = job.streams](std::uint64_t seed, int index,
                                                 const TruthNeeds& needs,
                                                 const Progress& progress) {
    return simulate_seeds(config, seed, index, streams, needs, progress);
  };
  job.warnings = [file = specimen_file(config.scene)] { return mesh_warnings(file); };
  return job;
}

std::string names_of(const std::vector<std::string>& list) {
  std::string names;
  for (const std::string& name : list) names += (names.empty() ? "" : ", ") + name;
  return names;
}

}  // namespace

std::span<const SceneEntry> scene_table() {
  static const std::vector<SceneEntry> kScenes = [] {
    std::vector<SceneEntry> scenes = plant_scenes();
    scenes.insert(scenes.begin(),
                  {.name = "seeds",
                   .status = COUSIN_WITH_MUJOCO ? "built in" : "not built in: WITH_MUJOCO is OFF",
                   .help = "ten seeds dropped on a calibration board before a green screen, three "
                           "camera rings (" +
                           names_of(cultivar_names()) + ")",
                   .configure = configure_seeds});
    return scenes;
  }();
  return kScenes;
}

const SceneEntry& scene_entry(const std::string& name) {
  std::string names;
  for (const SceneEntry& entry : scene_table()) {
    if (entry.name == name) return entry;
    names += (names.empty() ? "" : ", ") + entry.name;
  }
  throw std::invalid_argument("scene \"" + name + "\" is not one of: " + names);
}

}  // namespace cousin
