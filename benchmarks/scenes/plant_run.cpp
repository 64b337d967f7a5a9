#include "benchmarks/scenes/plant_run.h"

#include <stdexcept>

#include "sim/config/toml_peek.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

Rng scene_rng(std::uint64_t seed, int index) {
  return Rng(seed).fork("scene").fork(static_cast<std::uint64_t>(index));
}

/// A growth series is one tray on one day after another.
Scene build(const SeedlingsSceneConfig& config, std::uint64_t seed, int index) {
  const bool is_series = config.day_step > 0;
  SeedlingsSceneConfig own = config;
  own.day += index * config.day_step;
  return build_seedlings_scene(own, scene_rng(seed, is_series ? 0 : index).fork("build"));
}

Scene build(const MaizeSceneConfig& config, std::uint64_t seed, int index) {
  return build_maize_scene(config, scene_rng(seed, index).fork("build"));
}

/// Each scene has plants of its own, unless its kind says otherwise below.
template <class Config>
std::vector<std::string> shared(const Config&, int) {
  return {};
}
std::vector<std::string> shared(const SeedlingsSceneConfig& config, int /*index*/) {
  return config.day_step > 0 ? std::vector<std::string>{"tray"} : std::vector<std::string>{};
}

Fields scene_fields(PlantRunConfig& config) {
  return std::visit([](auto& scene) { return fields(scene); }, config.scene);
}

std::string& rig_key(PlantRunConfig& config) {
  return std::visit([](auto& scene) -> std::string& { return scene.rig; }, config.scene);
}

Fields capture_fields(PlantRunConfig& config) {
  return Fields{{"streams", &config.streams,
                 "images of the capture: auto, all, or of color,raw,infrared,depth those listed"}} +
         fields(config.capture);
}

Fields file_fields(PlantRunConfig& config) {
  return nested("scene", scene_fields(config)) + nested("capture", capture_fields(config)) +
         nested("rig", fields(config.rig)) + nested("render", fields(config.render));
}

}  // namespace

Fields fields(PlantRunConfig& config) {
  return scene_fields(config) + capture_fields(config) + nested("rig", fields(config.rig)) +
         nested("render", fields(config.render));
}

void validate(const PlantRunConfig& config) {
  std::visit([](const auto& scene) { validate(scene); }, config.scene);
  validate(config.rig);
  validate(config.capture);
  planned_streams(config);
  validate(config.render);
}

PlantRunConfig plant_run_config(PlantSceneConfig base, const std::vector<std::string>& assignments,
                                const std::filesystem::path& file) {
  PlantRunConfig config;
  config.scene = std::move(base);
  if (!file.empty()) {
    // What a rig's table holds depends on the rig.
    const std::string name = toml_text_of(file, "scene", "rig");
    if (!name.empty()) rig_key(config) = name;
    config.rig = device_preset(rig_key(config));
    read_toml(file, file_fields(config), MissingKeys::keep_default);
  }
  constexpr std::string_view kRig = "rig=";
  bool rig_is_given = false;
  for (const std::string& assignment : assignments) {
    if (!assignment.starts_with(kRig)) continue;
    rig_key(config) = assignment.substr(kRig.size());
    rig_is_given = true;
  }
  if (rig_is_given || file.empty()) config.rig = device_preset(rig_key(config));
  const Fields all = fields(config);
  for (const std::string& assignment : assignments) set_field(all, assignment);
  validate(config);
  return config;
}

Streams planned_streams(const PlantRunConfig& config) {
  const Streams there_are = streams_of(config.rig);
  if (config.streams == "auto") return there_are;
  return streams_from_string(config.streams, there_are, rig_name(config.scene));
}

int view_count(const PlantSceneConfig& scene) {
  return std::visit([](const auto& s) { return s.views; }, scene);
}

std::string rig_name(const PlantSceneConfig& scene) {
  return std::visit([](const auto& s) { return s.rig; }, scene);
}

Scene build_scene(const PlantSceneConfig& config, std::uint64_t seed, int index) {
  return std::visit([&](const auto& scene) { return build(scene, seed, index); }, config);
}

std::vector<std::string> shared_plants(const PlantSceneConfig& config, int index) {
  return std::visit([&](const auto& scene) { return shared(scene, index); }, config);
}

std::string resolved_toml(const PlantRunConfig& config) {
  PlantRunConfig copy = config;  // fields point into what they describe
  return to_toml(file_fields(copy));
}

std::string config_hash(const PlantRunConfig& config, std::uint64_t seed) {
  return sha256_hex(resolved_toml(config) + "\nseed = " + std::to_string(seed) + "\n");
}

}  // namespace cousin
