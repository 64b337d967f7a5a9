#include "benchmarks/loop/plant_run.h"

#include <algorithm>
#include <stdexcept>

#include "benchmarks/loop/stand_cache.h"
#include "scenes/apples/apples_toml.h"
#include "scenes/boards/toml_text.h"
#include "scenes/maize/toml_text.h"
#include "scenes/seedlings/toml_text.h"
#include "scenes/strawberries/strawberry_toml.h"
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

Scene build(const SpecimenSceneConfig& config, std::uint64_t seed, int index) {
  if (config.mesh.empty())
    throw std::invalid_argument("mesh is not set: --set mesh=FILE names the specimen's file");
  return build_specimen_scene(config, read_user_mesh(config.mesh),
                              scene_rng(seed, index).fork("build"));
}

Scene build(const BoardsSceneConfig& config, std::uint64_t seed, int index) {
  return build_boards_scene(config, scene_rng(seed, index).fork("build"));
}

Scene build(const ApplesSceneConfig& config, std::uint64_t seed, int index) {
  return build_apples_scene(config, scene_rng(seed, index).fork("build"),
                            tree_settler(config, seed, index));
}

/// The camera that a rig's first images come from, as its preset has it.
RigEye eye_of(const PhoneConfig& rig) {
  RigEye eye;
  eye.camera.width_px = rig.width_px;
  eye.camera.height_px = rig.height_px;
  eye.camera.fx_px = eye.camera.fy_px = rig.focal_px_per_width * rig.width_px;
  eye.camera.cx_px = 0.5 * (rig.width_px - 1);
  eye.camera.cy_px = 0.5 * (rig.height_px - 1);
  return eye;
}
RigEye eye_of(const RigConfig& rig) {
  const RigSensor& first = rig.sensors.at(0);
  return {nominal_camera(first.camera), sensor_from_rig(first)};
}
RigEye eye_of(const ActiveStereoConfig& rig) {
  RigEye eye{color_camera(rig), {}};
  eye.eye_from_rig.translation_m.x() = -rig.color_x_m;
  return eye;
}
RigEye eye_of(const RangeRigConfig& rig) { return eye_of(rig.body); }

/// Of its rows, the slowest camera's.
double readout_s(const PhoneConfig& rig) { return rig.readout_s; }
double readout_s(const RigConfig& rig) {
  double longest_s = 0;
  for (const RigSensor& sensor : rig.sensors)
    longest_s = std::max(longest_s, sensor.camera.photosites.readout_s);
  return longest_s;
}
double readout_s(const ActiveStereoConfig& rig) { return rig.color.photosites.readout_s; }
double readout_s(const RangeRigConfig& rig) { return readout_s(rig.body); }

std::vector<std::string> shared(const SeedlingsSceneConfig& config, int /*index*/) {
  return config.day_step > 0 ? std::vector<std::string>{"tray"} : std::vector<std::string>{};
}

std::vector<std::string> shared(const StrawberriesSceneConfig& config, int index) {
  return {"stretch " + std::to_string(index % config.plants)};
}

/// Plants of their own in each scene.
template <class Config>
std::vector<std::string> shared(const Config&, int /*index*/) {
  return {};
}

/// Stretches of bed come again with other colours, light and views.
Scene build(const StrawberriesSceneConfig& config, std::uint64_t seed, int index) {
  const int stretch = index % config.plants;
  return build_strawberries_scene(config, stand_at_rest(config, seed, stretch),
                                  stretch_rng(seed, stretch), scene_rng(seed, index).fork("build"));
}

/// What is of the machine and decides no byte: not in a resolved configuration.
Fields machine_fields(PlantRunConfig& config) {
  if (auto* strawberries = std::get_if<StrawberriesSceneConfig>(&config.scene))
    return {{"cache", &strawberries->cache,
             "folder that keeps trusses at rest, which take seconds to settle; empty: none"}};
  if (auto* apples = std::get_if<ApplesSceneConfig>(&config.scene))
    return {{"cache", &apples->cache,
             "folder that keeps branches at rest, which take seconds to settle; empty: none"}};
  return {};
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

Fields pipeline_fields(PipelineConfig* pipeline) {
  return pipeline ? nested("pipeline", fields(*pipeline)) : Fields{};
}

Fields file_fields(PlantRunConfig& config, PipelineConfig* pipeline) {
  return nested("scene", scene_fields(config)) + nested("capture", capture_fields(config)) +
         nested("rig", fields(config.rig)) + nested("render", fields(config.render)) +
         pipeline_fields(pipeline) + nested("cousin", fields(config.cousin));
}

}  // namespace

Fields fields(PlantRunConfig& config) { return fields(config, nullptr); }

Fields fields(PlantRunConfig& config, PipelineConfig* pipeline) {
  return scene_fields(config) + machine_fields(config) + capture_fields(config) +
         nested("rig", fields(config.rig)) + nested("render", fields(config.render)) +
         pipeline_fields(pipeline) + nested("cousin", fields(config.cousin));
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
  static const std::vector<CousinMove> kStrawberries =
      read_cousin_moves(strawberry_cousins_toml(), "scenes/strawberries/cousins.toml");
  static const std::vector<CousinMove> kApples =
      read_cousin_moves(apple_cousins_toml(), "scenes/apples/cousins.toml");
  static const std::vector<CousinMove> kBoards =
      read_cousin_moves(board_cousins_toml(), "scenes/boards/cousins.toml");
  static const std::vector<CousinMove> kNone;  // of a user's specimen
  if (std::holds_alternative<SeedlingsSceneConfig>(scene)) return kSeedlings;
  if (std::holds_alternative<MaizeSceneConfig>(scene)) return kMaize;
  if (std::holds_alternative<StrawberriesSceneConfig>(scene)) return kStrawberries;
  if (std::holds_alternative<ApplesSceneConfig>(scene)) return kApples;
  return std::holds_alternative<BoardsSceneConfig>(scene) ? kBoards : kNone;
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
                                const std::filesystem::path& file, PipelineConfig* pipeline) {
  PlantRunConfig config;
  config.scene = std::move(base);
  // Who photographs an apple taps on it: it and the leaves about it are exposed for.
  constexpr double kApple_m = 0.09;
  if (std::holds_alternative<ApplesSceneConfig>(config.scene)) config.capture.metered_m = kApple_m;
  if (!file.empty()) {
    // What a rig's table holds depends on the rig.
    const std::string name = toml_text_of(file, "scene", "rig");
    if (!name.empty()) rig_key(config) = name;
    config.rig = device_preset(rig_key(config));
    read_toml(file, file_fields(config, pipeline), MissingKeys::keep_default);
  }
  constexpr std::string_view kRig = "rig=";
  bool rig_is_given = false;
  for (const std::string& assignment : assignments) {
    if (!assignment.starts_with(kRig)) continue;
    rig_key(config) = assignment.substr(kRig.size());
    rig_is_given = true;
  }
  if (rig_is_given || file.empty()) config.rig = device_preset(rig_key(config));
  const Fields all = fields(config, pipeline);
  for (const std::string& assignment : assignments) set_field(all, assignment);
  validate(config);
  if (pipeline) validate(*pipeline);
  const std::string mesh = mesh_file_of(config.scene);
  if (!mesh.empty() && !std::filesystem::is_regular_file(mesh))
    throw std::runtime_error("mesh = \"" + mesh + "\": there is no such file");
  config.scene = seen_by(std::move(config.scene), config.rig);
  return config;
}

std::string mesh_file_of(const PlantSceneConfig& scene) {
  const auto* specimen = std::get_if<SpecimenSceneConfig>(&scene);
  return specimen ? specimen->mesh : std::string();
}

Streams planned_streams(const PlantRunConfig& config, const StreamReader* reader) {
  return streams_for(config.streams, streams_of(config.rig), rig_name(config.scene), reader);
}

int view_count(const PlantSceneConfig& scene) {
  return std::visit([](const auto& s) { return s.views; }, scene);
}

std::string rig_name(const PlantSceneConfig& scene) {
  return std::visit([](const auto& s) { return s.rig; }, scene);
}

PlantSceneConfig seen_by(PlantSceneConfig scene, const DeviceConfig& rig) {
  const RigEye eye = std::visit([](const auto& r) { return eye_of(r); }, rig);
  if (auto* apples = std::get_if<ApplesSceneConfig>(&scene)) apples->eye = eye;
  if (auto* berries = std::get_if<StrawberriesSceneConfig>(&scene)) berries->eye = eye;
  if (auto* boards = std::get_if<BoardsSceneConfig>(&scene)) {
    boards->half_view = {0.5 * eye.camera.width_px / eye.camera.fx_px,
                         0.5 * eye.camera.height_px / eye.camera.fy_px};
    boards->eye_from_rig = eye.eye_from_rig;
    boards->readout_s = std::visit([](const auto& r) { return readout_s(r); }, rig);
  }
  return scene;
}

Scene build_scene(const PlantSceneConfig& config, std::uint64_t seed, int index) {
  return std::visit([&](const auto& scene) { return build(scene, seed, index); }, config);
}

std::vector<std::string> shared_plants(const PlantSceneConfig& config, int index) {
  return std::visit([&](const auto& scene) { return shared(scene, index); }, config);
}

std::string resolved_toml(const PlantRunConfig& config, const PipelineConfig* pipeline) {
  PlantRunConfig copy = config;  // fields point into what they describe
  if (!pipeline) return to_toml(file_fields(copy, nullptr));
  PipelineConfig own = *pipeline;
  return to_toml(file_fields(copy, &own));
}

std::string config_hash(const PlantRunConfig& config, std::uint64_t seed,
                        const PipelineConfig* pipeline) {
  const std::string mesh = mesh_file_of(config.scene);
  return sha256_hex(resolved_toml(config, pipeline) + "\nseed = " + std::to_string(seed) + "\n" +
                    (mesh.empty() ? "" : sha256_hex_of_file(mesh)));
}

}  // namespace cousin
