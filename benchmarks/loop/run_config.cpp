#include "benchmarks/loop/run_config.h"

#include <algorithm>
#include <stdexcept>

#include "scenes/seeds/toml_text.h"
#include "sim/config/limits.h"
#include "sim/config/toml_peek.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

Fields capture_fields(SeedsRunConfig& config) {
  return Fields{{"streams", &config.streams,
                 "images of the capture: auto, all, or of color,raw,infrared,depth those listed"}} +
         fields(config.capture);
}

Fields radiance_fields(SeedsRunConfig& config) {
  const TextField by{
      [&config] { return std::string(config.radiance == RadianceBy::paths ? "paths" : "cached"); },
      [&config](const std::string& text) {
        if (text != "cached" && text != "paths")
          throw std::invalid_argument("\"" + text + "\" is not one of cached, paths");
        config.radiance = text == "paths" ? RadianceBy::paths : RadianceBy::cached;
      }};
  return {{"radiance", by,
           "light that cameras see: cached (computed once for all views, render.*) or paths (each "
           "pixel's own, paths.*)"}};
}

/// Another pipeline than the seeds' own.
PipelineConfig* other_than_seeds(PipelineConfig* pipeline) {
  return pipeline && !pipeline->get_if<SeedsPipelineConfig>() ? pipeline : nullptr;
}

Fields pipeline_fields(SeedsRunConfig& config, PipelineConfig* pipeline) {
  PipelineConfig* other = other_than_seeds(pipeline);
  return nested("pipeline", other ? fields(*other) : fields(config.pipeline));
}

/// As `fields`, but scene keys under a table of their own: top-level "rig" is a name there and a
/// table here.
Fields file_fields(SeedsRunConfig& config, PipelineConfig* pipeline = nullptr) {
  return nested("scene", fields(config.scene)) +
         nested("capture", capture_fields(config) + radiance_fields(config)) +
         nested("rig", fields(config.rig)) + nested("render", fields(config.render)) +
         nested("paths", fields(config.paths)) + pipeline_fields(config, pipeline) +
         nested("cousin", fields(config.cousin));
}

/// What of a scene no axis can move.
void require_movable(const SeedsRunConfig& config) {
  const CousinDistance& d = config.cousin;
  const auto refuse = [](const std::string& axis, const std::string& why) {
    throw std::invalid_argument("cousin." + axis + " is above 0, but " + why);
  };
  const bool is_grown = config.scene.specimen.empty() && !config.scene.sphere;
  for (const auto& [axis, value] :
       {std::pair{"shape", d.shape}, {"growth", d.growth}, {"texture", d.texture}}) {
    if (value > 0 && !is_grown)
      refuse(axis, "the specimens are not grown: it moves a cultivar's numbers");
    if (value > 0 && config.scene.seeds == 0) refuse(axis, "there are no seeds");
  }
  if (d.light > 0 && !config.scene.environment.empty())
    refuse("light", "an environment picture lights the scene: it moves lamps and sun");
  if (d.texture > 0 && !config.scene.gloss)
    refuse("texture", "gloss is false: it moves the coat's roughness");
}

bool within(const Streams& a, const Streams& b) {
  return (!a.color || b.color) && (!a.raw || b.raw) && (!a.infrared || b.infrared) &&
         (!a.depth || b.depth);
}

}  // namespace

Fields fields(SeedsRunConfig& config) { return fields(config, nullptr); }

Fields fields(SeedsRunConfig& config, PipelineConfig* pipeline) {
  return fields(config.scene) + capture_fields(config) + radiance_fields(config) +
         nested("rig", fields(config.rig)) + nested("render", fields(config.render)) +
         nested("paths", fields(config.paths)) + pipeline_fields(config, pipeline) +
         nested("cousin", fields(config.cousin));
}

const std::vector<CousinMove>& seeds_cousin_moves() {
  static const std::vector<CousinMove> kMoves =
      read_cousin_moves(seeds_cousins_toml(), "scenes/seeds/cousins.toml");
  return kMoves;
}

SeedsCousin cousin_of(const SeedsRunConfig& config, std::uint64_t seed, int scene_index) {
  SeedsCousin cousin{config, {}};
  if (is_twin(config.cousin)) return cousin;
  const Rng rng =
      Rng(seed).fork("scene").fork(static_cast<std::uint64_t>(scene_index)).fork("cousin");
  cousin.changes = move_to_cousin(fields(cousin.config), seeds_cousin_moves(), config.cousin, rng);
  cousin.config.cousin = {};
  try {
    validate(cousin.config);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("cousin of scene " + std::to_string(scene_index) + ": " +
                                error.what());
  }
  return cousin;
}

Streams needed_streams(const PipelineConfig& config) {
  const std::vector<std::string> images = needs(config).images;
  const auto has = [&](std::string_view name) {
    return std::find(images.begin(), images.end(), name) != images.end();
  };
  return {
      .color = has("color"), .raw = has("raw"), .infrared = has("infrared"), .depth = has("depth")};
}

StreamReader reader_of(const PipelineConfig& pipeline) {
  return {std::string(method_of(pipeline)), needed_streams(pipeline)};
}

Streams streams_for(const std::string& streams, const Streams& there_are, const std::string& rig,
                    const StreamReader* reader) {
  if (reader && !within(reader->needed, there_are)) {
    throw std::invalid_argument("method " + reader->method + " reads " + to_string(reader->needed) +
                                "; rig " + rig + " has " + to_string(there_are));
  }
  if (streams == "auto") return reader ? reader->needed : there_are;
  const Streams asked = streams_from_string(streams, there_are, rig);
  if (reader && !within(reader->needed, asked)) {
    throw std::invalid_argument("streams = \"" + streams + "\" leaves out what method " +
                                reader->method + " reads: " + to_string(reader->needed));
  }
  return asked;
}

Streams planned_streams(const SeedsRunConfig& config, Reader reader) {
  const StreamReader own = reader_of(config.pipeline);
  return streams_for(config.streams, streams_of(config.rig), config.scene.rig,
                     reader == Reader::pipeline ? &own : nullptr);
}

void validate(const SeedsRunConfig& config) {
  validate(config.scene);
  validate(config.rig);
  validate(config.capture);
  planned_streams(config, Reader::anybody);
  validate(config.render);
  validate(config.paths);
  validate(config.pipeline);
  SeedsRunConfig copy = config;  // fields point into what they describe
  check_limits(nested("cousin", fields(copy.cousin)));
  if (is_twin(config.cousin)) return;
  require_movable(config);
  check_cousin(fields(copy), seeds_cousin_moves(), config.cousin);
}

SeedsRunConfig seeds_run_config(const std::vector<std::string>& assignments,
                                const std::filesystem::path& file, PipelineConfig* pipeline) {
  SeedsRunConfig config;
  auto* own = pipeline ? pipeline->get_if<SeedsPipelineConfig>() : nullptr;
  if (own) config.pipeline = *own;
  if (!file.empty()) {
    // What a rig's table holds depends on the rig.
    const std::string name = toml_text_of(file, "scene", "rig");
    if (!name.empty()) config.scene.rig = name;
    config.rig = device_preset(config.scene.rig);
    read_toml(file, file_fields(config, pipeline), MissingKeys::keep_default);
  }
  constexpr std::string_view kRig = "rig=";
  bool rig_is_given = false;
  for (const std::string& assignment : assignments) {
    if (!assignment.starts_with(kRig)) continue;
    config.scene.rig = assignment.substr(kRig.size());
    rig_is_given = true;
  }
  if (rig_is_given || file.empty()) config.rig = device_preset(config.scene.rig);
  const Fields all = fields(config, pipeline);
  for (const std::string& assignment : assignments) set_field(all, assignment);
  validate(config);
  const std::string mesh = specimen_file(config.scene);
  if (!mesh.empty() && !std::filesystem::is_regular_file(mesh)) {
    throw std::runtime_error("specimen = \"" + config.scene.specimen + "\": there is no file " +
                             mesh);
  }
  const std::string& environment = config.scene.environment;
  if (!environment.empty() && !std::filesystem::is_regular_file(environment)) {
    throw std::runtime_error("environment = \"" + environment + "\": there is no such file");
  }
  if (own) *own = config.pipeline;
  if (pipeline) validate(*pipeline);
  return config;
}

std::string specimen_file(const SeedsSceneConfig& config) {
  constexpr std::string_view kMesh = "mesh:";
  if (config.specimen.empty()) return {};
  if (!config.specimen.starts_with(kMesh) || config.specimen == kMesh) {
    throw std::invalid_argument("specimen = \"" + config.specimen + "\" is not \"mesh:FILE\"");
  }
  return config.specimen.substr(kMesh.size());
}

std::string user_files_hash(const SeedsSceneConfig& config) {
  std::string hash;
  for (const std::string& file : {specimen_file(config), config.environment}) {
    if (!file.empty()) hash += sha256_hex_of_file(file);
  }
  return hash;
}

std::string simulator_toml(const SeedsRunConfig& config) {
  SeedsRunConfig copy = config;  // fields point into what they describe
  const Fields light = copy.radiance == RadianceBy::paths ? nested("paths", fields(copy.paths))
                                                          : nested("render", fields(copy.render));
  const std::string text =
      to_toml(nested("scene", fields(copy.scene)) + nested("rig", fields(copy.rig)) + light);
  const std::string cousin =
      is_twin(config.cousin) ? "" : "\n[cousin]\n" + to_toml(fields(copy.cousin));
  RigCaptureConfig plain;
  const std::string capture = to_toml(fields(copy.capture));
  return (capture == to_toml(fields(plain)) ? text : text + "\n[capture]\n" + capture) + cousin;
}

std::string resolved_toml(const SeedsRunConfig& config, const PipelineConfig* pipeline) {
  SeedsRunConfig copy = config;
  if (!pipeline) return to_toml(file_fields(copy));
  PipelineConfig other = *pipeline;
  return to_toml(file_fields(copy, &other));
}

std::string config_hash(const SeedsRunConfig& config, std::uint64_t seed,
                        const PipelineConfig* pipeline) {
  return sha256_hex(resolved_toml(config, pipeline) + "\nseed = " + std::to_string(seed) + "\n" +
                    user_files_hash(config.scene));
}

}  // namespace cousin
