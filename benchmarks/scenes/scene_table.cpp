#include "benchmarks/scenes/scene_table.h"

#include <stdexcept>

#include "benchmarks/scenes/built_scene.h"
#include "benchmarks/scenes/plant_scenes.h"
#include "benchmarks/seeds/simulate.h"
#include "benchmarks/seeds/simulator_plan.h"

namespace cousin {
namespace {

SceneJob configure_seeds(const std::vector<std::string>& assignments,
                         const std::filesystem::path& file) {
  SeedsRunConfig config = seeds_run_config(assignments, file);
  SceneJob job;
  job.keys = describe(fields(config)) + cousins_text(seeds_cousin_moves());
  job.rig = config.rig;
  job.streams = planned_streams(config, Reader::anybody);
  job.views = config.scene.views;
  job.hash = [config](std::uint64_t seed) { return config_hash(config, seed); };
  job.plan = [config] { return simulator_plan(config, Reader::anybody); };
  job.build = [config](std::uint64_t seed, int index) {
    return built_scene(SeedsSimulation(config, seed, index));
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
                   .has_pipeline = true,
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
