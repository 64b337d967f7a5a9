#include "benchmarks/scenes/scene_table.h"

#include <stdexcept>

#include "benchmarks/scenes/plant_simulation.h"
#include "benchmarks/seeds/simulate.h"
#include "sim/geometry/mesh_warnings.h"
#include "benchmarks/seeds/simulator_plan.h"

namespace cousin {
namespace {

template <class Simulation>
BuiltScene built(Simulation made) {
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

/// What follows the keys: what cousin.* moves.
std::string cousins_text(const std::vector<CousinMove>& moves) {
  if (moves.empty()) return {};
  return "\nAt 1, cousin.AXIS moves\n" + describe(moves);
}

std::vector<std::string> mesh_warnings(const std::string& file) {
  return file.empty() ? std::vector<std::string>() : user_mesh_warnings(file);
}

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
    return built(SeedsSimulation(config, seed, index));
  };
  job.warnings = [file = specimen_file(config.scene)] { return mesh_warnings(file); };
  return job;
}

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

std::vector<PlanEntry> plant_plan(const PlantRunConfig& config) {
  const Streams streams = planned_streams(config);
  const bool light = streams.color || streams.raw;
  const std::string nobody = "not among the streams";
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

SceneJob configure_plants(PlantSceneConfig base, const std::vector<std::string>& assignments,
                          const std::filesystem::path& file) {
  PlantRunConfig config = plant_run_config(std::move(base), assignments, file);
  SceneJob job;
  job.keys = describe(fields(config)) + cousins_text(cousin_moves(config.scene));
  job.rig = config.rig;
  job.streams = planned_streams(config);
  job.views = view_count(config.scene);
  job.hash = [config](std::uint64_t seed) { return config_hash(config, seed); };
  job.plan = [config] { return plant_plan(config); };
  job.build = [config](std::uint64_t seed, int index) {
    return built(PlantSimulation(config, seed, index));
  };
  job.warnings = [file = mesh_file_of(config.scene)] { return mesh_warnings(file); };
  return job;
}

std::string names_of(const std::vector<std::string>& list) {
  std::string names;
  for (const std::string& name : list) names += (names.empty() ? "" : ", ") + name;
  return names;
}

}  // namespace

std::span<const SceneEntry> scene_table() {
  static const std::vector<SceneEntry> kScenes = {
      {.name = "seeds",
       .status = COUSIN_WITH_MUJOCO ? "built in" : "not built in: WITH_MUJOCO is OFF",
       .help = "ten seeds dropped on a calibration board before a green screen, three camera rings "
               "(" +
               names_of(cultivar_names()) + ")",
       .has_pipeline = true,
       .configure = configure_seeds},
      {.name = "seedlings",
       .status = "built in; no pipeline yet",
       .help = "watermelon seedlings of day 0 to 12 in a tray of 50 cells, hand-held views, three "
               "lights (D1 sun, D2 overcast, D3 violet LED)",
       .configure =
           [](const auto& sets, const auto& file) {
             return configure_plants(SeedlingsSceneConfig{}, sets, file);
           }},
      {.name = "maize",
       .status = "built in; no pipeline yet",
       .help = "maize from V3 to VT, one plant or rows, with a keypoint at every node, seen by a "
               "ZED stereo camera",
       .configure =
           [](const auto& sets, const auto& file) {
             return configure_plants(MaizeSceneConfig{}, sets, file);
           }},
      {.name = "apples",
       .status = "built in; no pipeline yet",
       .help =
           "a Fuji spindle tree in its row, seen from 0.1 to 1 m of a fruit; four lights (front, "
           "back, side, shade); occlusion on demand",
       .configure =
           [](const auto& sets, const auto& file) {
             return configure_plants(ApplesSceneConfig{}, sets, file);
           }},
      {.name = "boards",
       .status = "built in; no pipeline yet",
       .help = "calibration boards (" + names_of(board_names()) +
               ") with warp, stretch and gloss, on a table, on a stand or held by hand",
       .has_points = true,
       .configure =
           [](const auto& sets, const auto& file) {
             return configure_plants(BoardsSceneConfig{}, sets, file);
           }},
      {.name = "specimen",
       .status = "built in; no pipeline yet",
       .help = "your own mesh on a table: --set mesh=FILE (PLY, OBJ, STL, glTF) --set unit=mm",
       .configure =
           [](const auto& sets, const auto& file) {
             return configure_plants(SpecimenSceneConfig{}, sets, file);
           }},
      {.name = "strawberries",
       .status =
           COUSIN_WITH_MUJOCO ? "built in; no pipeline yet" : "not built in: WITH_MUJOCO is OFF",
       .help = "strawberries of three varieties on a raised bed, 1 to 10 fruits of all maturities "
               "in view, four lights (morning, overcast, noon, lamp), seen by a D457",
       .configure =
           [](const auto& sets, const auto& file) {
             return configure_plants(StrawberriesSceneConfig{}, sets, file);
           }},
  };
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
