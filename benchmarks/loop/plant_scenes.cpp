#include "benchmarks/loop/plant_scenes.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "benchmarks/loop/built_scene.h"
#include "benchmarks/loop/plant_simulation.h"

namespace cousin {
namespace {

/// Whether a scene needs physics, and what for.
std::pair<bool, std::string> plant_physics(const PlantSceneConfig& scene) {
  if (std::holds_alternative<StrawberriesSceneConfig>(scene))
    return {true, "trusses hang at rest, or come from the folder `cache`"};
  if (const auto* apples = std::get_if<ApplesSceneConfig>(&scene);
      COUSIN_WITH_MUJOCO && apples != nullptr && apples->sag)
    return {true, apples->wind.mean_speed_m_s > 0 || apples->push.force_n > 0
                      ? "branches bend under their fruits to rest, and sway"
                      : "branches bend under their fruits to rest"};
  const bool blows = std::visit(
      [](const auto& config) {
        if constexpr (requires { is_still(config.motion); }) return !is_still(config.motion);
        return false;
      },
      scene);
  if (blows) return {true, "plants move in the wind or under a hand"};
  return {false, "nothing settles or moves by force"};
}

std::vector<PlanEntry> plant_plan(const PlantRunConfig& config, const StreamReader* reader) {
  const Streams streams = planned_streams(config, reader);
  const bool light = streams.color || streams.raw;
  const std::string nobody = reader ? "no stage reads it" : "not among the streams";
  const auto [moves, physics] = plant_physics(config.scene);
  const bool infrared =
      streams.infrared || (streams.depth && config.capture.depth_by == DepthBy::matched);
  return {
      {"scene", true, "what is photographed, with its exact measures, and what it stands in"},
      {"physics", moves, physics},
      {"radiance", light, light ? "paths: leaves let light through, so it is not cached" : nobody},
      {"sensor", light, light ? "lens, noise and processing of the camera" : nobody},
      {"infrared", infrared, infrared ? "infrared images, or the depth matched from them" : nobody},
      {"sensor depth", streams.depth, streams.depth ? "the depth sensor's own depth" : nobody},
  };
}

SceneJob configure_plants(PlantSceneConfig base, const SceneRequest& request) {
  PipelineConfig* const pipeline = request.pipeline;
  PlantRunConfig config =
      plant_run_config(std::move(base), request.assignments, request.file, pipeline);
  const KeptPipeline kept(pipeline);  // as the configuration left it
  SceneJob job;
  job.keys = describe(fields(config, pipeline)) + cousins_text(cousin_moves(config.scene));
  job.toml = resolved_toml(config, pipeline);
  job.rig = config.rig;
  job.streams = planned_streams(config, kept.reader());
  job.depth_by = config.capture.depth_by;
  job.views = view_count(config.scene);
  job.hash = [config, kept](std::uint64_t seed) {
    return config_hash(config, seed, kept.config());
  };
  job.plan = [config, kept] { return plant_plan(config, kept.reader()); };
  job.build = [config](std::uint64_t seed, int index) {
    return built_scene(PlantSimulation(config, seed, index));
  };
  job.simulate = [build = job.build, streams = job.streams](std::uint64_t seed, int index,
                                                            const TruthNeeds& needs,
                                                            const Progress& progress) {
    SimulatedRun run;
    if (progress) progress("scene", 0, 1);
    const StageClock clock("scene");
    const BuiltScene built = build(seed, index);
    run.timings.push_back(clock.finish());
    take_frames(built, streams, needs, progress, run);
    return run;
  };
  job.warnings = [file = mesh_file_of(config.scene)] { return mesh_warnings(file); };
  return job;
}

PlantSceneConfig default_scene(const std::string& name) {
  if (name == "seedlings") return SeedlingsSceneConfig{};
  if (name == "maize") return MaizeSceneConfig{};
  if (name == "apples") return ApplesSceneConfig{};
  if (name == "boards") return BoardsSceneConfig{};
  if (name == "specimen") return SpecimenSceneConfig{};
  if (name == "strawberries") return StrawberriesSceneConfig{};
  throw std::logic_error("scene \"" + name + "\" has a text and no configuration");
}

}  // namespace

std::vector<SceneEntry> plant_scenes() {
  std::vector<SceneEntry> scenes;
  for (const PlantSceneText& text : kPlantScenes) {
    const bool is_built = COUSIN_WITH_MUJOCO || !text.needs_physics;
    scenes.push_back({.name = text.name,
                      .status = is_built ? "built in" : "not built in: WITH_MUJOCO is OFF",
                      .help = text.help,
                      .has_points = text.has_points,
                      .configure = [base = default_scene(text.name)](const SceneRequest& request) {
                        return configure_plants(base, request);
                      }});
  }
  return scenes;
}

}  // namespace cousin
