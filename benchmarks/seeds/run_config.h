#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "perception/pipelines/seeds.h"
#include "scenes/seeds/seeds_scene.h"
#include "sim/config/fields.h"
#include "sim/render/radiance_pass.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/phone.h"

namespace cousin {

/// Everything that decides what `run seeds` does, apart from the seed. Scene keys stand alone
/// (`cultivar`); the others carry a prefix (`rig.`, `render.`, `pipeline.`).
struct SeedsRunConfig {
  SeedsSceneConfig scene;
  PhoneConfig rig;
  RadianceConfig render;
  SeedsPipelineConfig pipeline;
};
Fields fields(SeedsRunConfig& config);
void validate(const SeedsRunConfig& config);

/// Defaults, then the rig's preset, then `file` (as resolved_toml writes it; keys may be missing;
/// empty = none), then the user's `key=value`s in order. `rig=NAME` picks the preset first, in
/// place of the file's rig.
/// @throws std::invalid_argument naming key, value and limit; std::runtime_error naming the file.
SeedsRunConfig seeds_run_config(const std::vector<std::string>& assignments,
                                const std::filesystem::path& file = {});

/// The resolved configuration as TOML, and its SHA-256.
std::string resolved_toml(const SeedsRunConfig& config);
/// The part of it that decides the images: scene, rig and renderer.
std::string simulator_toml(const SeedsRunConfig& config);
std::string config_hash(const SeedsRunConfig& config, std::uint64_t seed);

}  // namespace cousin
