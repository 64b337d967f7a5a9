#include "benchmarks/scenes/plant_run.h"

#include <stdexcept>

#include "scenes/maize/toml_text.h"
#include "scenes/seedlings/toml_text.h"
#include "sim/config/limits.h"
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

Scene build(const BoardsSceneConfig& config, std::uint64_t seed, int index) {
  return build_boards_scene(config, scene_rng(seed, index).fork("build"));
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
         nested("rig", fields(config.rig)) + nested("render", fields(config.render)) +
         nested("cousin", fields(config.cousin));
}

}  // namespace

Fields fields(PlantRunConfig& config) {
  return scene_fields(config) + capture_fields(config) + nested("rig", fields(config.rig)) +
         nested("render", fields(config.render)) + nested("cousin", fields(config.cousin));
}

void validate(const PlantRunConfig& config) {
  std::visit([](const auto& scene) { validate(scene); }, config.scene);
  validate(config.rig);
  validate(config.capture);
  planned_streams(config);
  validate(config.render);
  PlantRunConfig copy = config;  // fields point into what they describe
  check_limits(nested("cousin", fields(copy.cousin)));
  check_cousin(fields(copy), cousin_moves(config.scene), config.cousin);
}

const std::vector<CousinMove>& cousin_moves(const PlantSceneConfig& scene) {
  static const std::vector<CousinMove> kSeedlings =
      read_cousin_moves(seedling_cousins_toml(), "scenes/seedlings/cousins.toml");
  static const std::vector<CousinMove> kMaize =
      read_cousin_moves(maize_cousins_toml(), "scenes/maize/cousins.toml");
  static const std::vector<CousinMove> kNone;
  if (std::holds_alternative<SeedlingsSceneConfig>(scene)) return kSeedlings;
  return std::holds_alternative<MaizeSceneConfig>(scene) ? kMaize : kNone;
}

PlantCousin cousin_of(const PlantRunConfig& config, std::uint64_t seed, int scene_index) {
  PlantCousin cousin{config, {}};
  if (is_twin(config.cousin)) return cousin;
  const auto* seedlings = std::get_if<SeedlingsSceneConfig>(&config.scene);
  const bool is_series = seedlings && seedlings->day_step > 0;
  const Rng rng = scene_rng(seed, is_series ? 0 : scene_index).fork("cousin");
  cousin.changes =
      move_to_cousin(fields(cousin.config), cousin_moves(config.scene), config.cousin, rng);
  cousin.config.cousin = {};
  try {
    validate(cousin.config);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("cousin of scene " + std::to_string(scene_index) + ": " +
                                error.what());
  }
  return cousin;
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

PlantSceneConfig seen_by(PlantSceneConfig scene, const DeviceConfig& rig) {
  if (auto* boards = std::get_if<BoardsSceneConfig>(&scene)) {
    // What the rig reports does not depend on what it sees.
    Scene nothing;
    nothing.models.push_back({});
    nothing.models[0].mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    nothing.materials.push_back({});
    nothing.instances.push_back({});
    const RayScene rays(nothing);
    const Camera camera = RigCapture(rig, {}, rays, nothing, Rng(0)).reports().front().camera;
    boards->half_view = {0.5 * camera.width_px / camera.fx_px,
                         0.5 * camera.height_px / camera.fy_px};
  }
  return scene;
}

Scene build_scene(const PlantSceneConfig& config, std::uint64_t seed, int index) {
  return std::visit([&](const auto& scene) { return build(scene, seed, index); }, config);
}

std::string resolved_toml(const PlantRunConfig& config) {
  PlantRunConfig copy = config;  // fields point into what they describe
  return to_toml(file_fields(copy));
}

std::string config_hash(const PlantRunConfig& config, std::uint64_t seed) {
  return sha256_hex(resolved_toml(config) + "\nseed = " + std::to_string(seed) + "\n");
}

}  // namespace cousin
