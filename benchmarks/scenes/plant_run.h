#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "scenes/maize/maize_scene.h"
#include "scenes/seedlings/seedlings_scene.h"
#include "sim/config/fields.h"
#include "sim/render/path_tracer.h"
#include "sim/sensors/rig_capture.h"

namespace cousin {

/// A scene of plants of any kind; to add a kind, add it here and to plant_run.cpp's overloads.
using PlantSceneConfig = std::variant<SeedlingsSceneConfig, MaizeSceneConfig>;

/// Everything that decides the images of a plant scene, apart from the seed: light is traced path
/// by path, for leaves let it through. Keys as for SeedsRunConfig.
struct PlantRunConfig {
  PlantSceneConfig scene;
  DeviceConfig rig = PhoneConfig{};
  RigCaptureConfig capture;
  std::string streams = "auto";  ///< images of the capture: auto (all), or names of Streams
  PathConfig render{.pixel_samples = 16};
};
Fields fields(PlantRunConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const PlantRunConfig& config);

/// `base` with the rig's preset, then `file` (as resolved_toml writes it; empty = none), then the
/// user's `key=value`s in order; as seeds_run_config.
PlantRunConfig plant_run_config(PlantSceneConfig base, const std::vector<std::string>& assignments,
                                const std::filesystem::path& file = {});

Streams planned_streams(const PlantRunConfig& config);
int view_count(const PlantSceneConfig& scene);
std::string rig_name(const PlantSceneConfig& scene);

/// Scene number `index` of a run.
Scene build_scene(const PlantSceneConfig& config, std::uint64_t seed, int index);

/// Names of the plants of scene number `index` that other scenes of the run show too; empty where
/// each scene has its own. Datasets are split by them.
std::vector<std::string> shared_plants(const PlantSceneConfig& config, int index);

std::string resolved_toml(const PlantRunConfig& config);
/// SHA-256 of the resolved configuration and the seed.
std::string config_hash(const PlantRunConfig& config, std::uint64_t seed);

}  // namespace cousin
