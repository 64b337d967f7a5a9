#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "scenes/apples/apples_scene.h"
#include "scenes/boards/boards_scene.h"
#include "scenes/maize/maize_scene.h"
#include "scenes/seedlings/seedlings_scene.h"
#include "scenes/specimen/specimen_scene.h"
#include "scenes/strawberries/strawberries_scene.h"
#include "sim/config/cousin.h"
#include "sim/config/fields.h"
#include "sim/render/path_tracer.h"
#include "sim/sensors/rig_capture.h"

namespace cousin {

/// A scene of plants of any kind, or of a calibration board; to add a kind, add it here and to
/// plant_run.cpp's overloads.
using PlantSceneConfig =
    std::variant<SeedlingsSceneConfig, MaizeSceneConfig, ApplesSceneConfig, BoardsSceneConfig,
                 SpecimenSceneConfig, StrawberriesSceneConfig>;

/// Everything that decides the images of a plant scene, apart from the seed: light is traced path
/// by path, for leaves let it through. Keys as for SeedsRunConfig.
struct PlantRunConfig {
  PlantSceneConfig scene;
  DeviceConfig rig = PhoneConfig{};
  RigCaptureConfig capture;
  std::string streams = "auto";  ///< images of the capture: auto (all), or names of Streams
  PathConfig render{.pixel_samples = 16};
  CousinDistance cousin;  ///< each scene is another cousin of what the other keys say
};
Fields fields(PlantRunConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const PlantRunConfig& config);

/// The file of a user's mesh; "" if the scene grows what stands in it.
std::string mesh_file_of(const PlantSceneConfig& scene);

/// `base` with the rig's preset, then `file` (as resolved_toml writes it; empty = none), then the
/// user's `key=value`s in order; as seeds_run_config.
/// @throws std::runtime_error naming a user's mesh that is no file.
/// @param pipeline  in and out: the one that reads the images, whose keys `pipeline.` are; null:
/// none
PlantRunConfig plant_run_config(PlantSceneConfig base, const std::vector<std::string>& assignments,
                                const std::filesystem::path& file = {},
                                PipelineConfig* pipeline = nullptr);
/// All keys of a run.
Fields fields(PlantRunConfig& config, PipelineConfig* pipeline);

/// What the scene's cousins.toml moves; nothing for a scene without one.
const std::vector<CousinMove>& cousin_moves(const PlantSceneConfig& scene);

/// The configuration of one scene: the keys that `cousin` moves, moved. A growth series is one
/// cousin.
struct PlantCousin {
  PlantRunConfig config;
  std::vector<CousinChange> changes;
};
/// @throws std::invalid_argument if the moved configuration is not valid.
PlantCousin cousin_of(const PlantRunConfig& config, std::uint64_t seed, int scene_index);

/// @param reader  null: nobody reads the images yet @throws as streams_for
Streams planned_streams(const PlantRunConfig& config, const StreamReader* reader = nullptr);
int view_count(const PlantSceneConfig& scene);
std::string rig_name(const PlantSceneConfig& scene);

/// `scene` with what it must know of the rig that takes it: views of a board are planned in the
/// picture.
PlantSceneConfig seen_by(PlantSceneConfig scene, const DeviceConfig& rig);

/// Scene number `index` of a run; a user's mesh is read from its file.
Scene build_scene(const PlantSceneConfig& config, std::uint64_t seed, int index);

/// Names of the plants in scene number `index` that other scenes of the run may show too; empty
/// where each scene has its own.
std::vector<std::string> shared_plants(const PlantSceneConfig& config, int index);

std::string resolved_toml(const PlantRunConfig& config, const PipelineConfig* pipeline = nullptr);
/// SHA-256 of the resolved configuration, the user's mesh and the seed.
std::string config_hash(const PlantRunConfig& config, std::uint64_t seed,
                        const PipelineConfig* pipeline = nullptr);

}  // namespace cousin
