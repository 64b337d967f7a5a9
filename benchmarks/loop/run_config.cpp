#include "benchmarks/loop/run_config.h"

#include <algorithm>
#include <exception>
#include <stdexcept>

#include "benchmarks/loop/rig_sight.h"
#include "sim/config/limits.h"
#include "sim/config/toml_peek.h"
#include "sim/dataset/manifest.h"
#include "sim/geometry/mesh_warnings.h"

namespace cousin {
namespace {

RadianceBy radiance_of(const std::string& text, const SceneRow& row) {
  if (text != "cached" && text != "paths")
    throw std::invalid_argument("\"" + text + "\" is not one of cached, paths");
  if (text == "cached" && !row.why_paths.empty())
    throw std::invalid_argument("\"cached\": scene " + std::string(row.text.name) +
                                " is by paths: " + std::string(row.why_paths));
  return text == "paths" ? RadianceBy::paths : RadianceBy::cached;
}

/// The same, refused by the name of the key.
RadianceBy radiance_of_key(const std::string& text, const SceneRow& row) {
  try {
    return radiance_of(text, row);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("render.by = " + std::string(error.what()));
  }
}

/// The renderer by its name. What else a table holds depends on it, so it is set before.
Field by_field(RunConfig& config, const char* key) {
  const TextField by{
      [&config] { return std::string(config.radiance == RadianceBy::paths ? "paths" : "cached"); },
      [&config](const std::string& text) {
        config.radiance = radiance_of(text, row_of(config.scene));
      }};
  return {key, by,
          "light that cameras see: cached (computed once for all views; still matt scenes) or "
          "paths (each pixel's own)"};
}

Fields render_fields(RunConfig& config) {
  return Fields{by_field(config, "by")} +
         (config.radiance == RadianceBy::paths ? fields(config.paths) : fields(config.cached));
}

Fields capture_fields(RunConfig& config) {
  return Fields{{"streams", &config.streams,
                 "images of the capture: auto, all, or of color,raw,infrared,depth those listed"}} +
         fields(config.capture);
}

/// Keys that change no byte of a result, such as a cache folder. A resolved configuration leaves
/// them out.
Fields machine_fields(RunConfig& config) {
  std::string* const cache = cache_folder(config.scene);
  if (!cache) return {};
  return {{"cache", cache,
           "folder that keeps plants at rest, which take seconds to settle; empty: none"}};
}

Fields last_fields(RunConfig& config) {
  const bool has_keypoints = config.pipeline && takes_keypoints(row_of(*config.pipeline));
  const bool has_boxes = config.pipeline && takes_boxes(row_of(*config.pipeline));
  return (has_keypoints ? nested("keypoints", fields(config.keypoints)) : Fields{}) +
         (has_boxes ? nested("boxes", fields(config.boxes)) : Fields{}) +
         (config.pipeline ? nested("pipeline", fields(*config.pipeline)) : Fields{}) +
         nested("cousin", fields(config.cousin));
}

/// As `fields`, but scene keys under a table of their own: top-level "rig" is a name there and a
/// table here.
Fields file_fields(RunConfig& config) {
  return nested("scene", fields(config.scene)) + nested("capture", capture_fields(config)) +
         nested("rig", fields(config.rig)) + nested("render", render_fields(config)) +
         last_fields(config);
}

/// The same of files by earlier versions, which have a table for each renderer.
Fields earlier_file_fields(RunConfig& config) {
  return nested("scene", fields(config.scene)) +
         nested("capture", capture_fields(config) + Fields{by_field(config, "radiance")}) +
         nested("rig", fields(config.rig)) + nested("render", fields(config.cached)) +
         nested("paths", fields(config.paths)) + last_fields(config);
}

/// Reads the keys of a file. Where nobody reads the images, its table [pipeline] is of a run of
/// before: read, so that what is wrong in it is said, and dropped.
void read_keys(const std::filesystem::path& file, bool is_earlier, RunConfig& config) {
  const auto read = [&] {
    read_toml(file, is_earlier ? earlier_file_fields(config) : file_fields(config),
              MissingKeys::keep_default);
  };
  const std::string method = toml_text_of(file, "pipeline", "method");
  if (config.pipeline || method.empty()) return read();
  const PipelineRow* const own = pipeline_of_scene(row_of(config.scene).text.name);
  std::vector<const PipelineRow*> rows = pipeline_table();
  std::stable_partition(rows.begin(), rows.end(),
                        [&](const PipelineRow* row) { return row == own; });
  std::exception_ptr first;
  for (const PipelineRow* row : rows) {
    RunConfig copy = config;
    config.pipeline = row->defaults();
    try {
      read();
      config.pipeline.reset();
      return;
    } catch (const std::runtime_error&) {
      if (!first) first = std::current_exception();
    }
    config = std::move(copy);
  }
  std::rethrow_exception(first);
}

/// What decides which keys there are, then all keys.
void read_run_file(const std::filesystem::path& file, RunConfig& config) {
  const std::string name = toml_text_of(file, "scene", "rig");
  if (!name.empty()) config.scene.rig() = name;
  config.rig = device_preset(config.scene.rig());
  const bool is_earlier = !toml_text_of(file, "capture", "radiance").empty();
  const std::string by = toml_text_of(file, "render", "by");
  if (!by.empty()) {
    try {
      config.radiance = radiance_of_key(by, row_of(config.scene));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(file.string() + ": " + error.what());
    }
  }
  read_keys(file, is_earlier, config);
}

/// The last value given to a key; none if it is not given.
std::optional<std::string> given(const std::vector<std::string>& assignments,
                                 const std::string& key) {
  std::optional<std::string> value;
  for (const std::string& assignment : assignments) {
    if (assignment.starts_with(key + "=")) value = assignment.substr(key.size() + 1);
  }
  return value;
}

void require_files(const SceneConfig& scene) {
  for (const UserFile& file : user_files(scene)) {
    if (!std::filesystem::is_regular_file(file.path))
      throw std::runtime_error(file.setting + ": there is no file " + file.path);
  }
}

bool within(const Streams& a, const Streams& b) {
  return (!a.color || b.color) && (!a.raw || b.raw) && (!a.infrared || b.infrared) &&
         (!a.depth || b.depth);
}

Streams streams_for(const RunConfig& config, const StreamReader* reader) {
  const Streams there_are = streams_of(config.rig);
  const std::string& rig = config.scene.rig();
  if (reader && !within(reader->needed, there_are)) {
    throw std::invalid_argument("method " + reader->method + " reads " + to_string(reader->needed) +
                                "; rig " + rig + " has " + to_string(there_are));
  }
  if (config.streams == "auto") return reader ? reader->needed : there_are;
  const Streams asked = streams_from_string(config.streams, there_are, rig);
  if (reader && !within(reader->needed, asked)) {
    throw std::invalid_argument("streams = \"" + config.streams + "\" leaves out what method " +
                                reader->method + " reads: " + to_string(reader->needed));
  }
  return asked;
}

}  // namespace

Fields fields(RunConfig& config) {
  return fields(config.scene) + machine_fields(config) + capture_fields(config) +
         nested("rig", fields(config.rig)) + nested("render", render_fields(config)) +
         last_fields(config);
}

void validate(const RunConfig& config) {
  validate(config.scene);
  validate(config.rig);
  validate(config.capture);
  planned_streams(config, Reader::anybody);
  validate(config.cached);
  validate(config.paths);
  if (config.pipeline) validate(*config.pipeline);
  validate(config.keypoints);
  validate(config.boxes);
  RunConfig copy = config;  // fields point into what they describe
  check_limits(nested("cousin", fields(copy.cousin)));
  if (is_twin(config.cousin)) return;
  check_movable(config.scene, config.cousin);
  check_cousin(fields(copy), cousin_moves(config.scene), config.cousin);
}

RunConfig default_run(const SceneRow& row) {
  RunConfig config{.scene = row.defaults()};
  config.rig = device_preset(config.scene.rig());
  config.capture.metered_m = row.metered_m;
  config.radiance = row.why_paths.empty() ? RadianceBy::cached : RadianceBy::paths;
  config.paths = row.paths;
  return config;
}

RunConfig run_config(const SceneRow& row, const std::vector<std::string>& assignments,
                     const std::filesystem::path& file, std::optional<PipelineConfig> pipeline) {
  RunConfig config = default_run(row);
  config.pipeline = std::move(pipeline);
  if (!file.empty()) read_run_file(file, config);
  if (const auto rig = given(assignments, "rig")) {
    config.scene.rig() = *rig;
    config.rig = device_preset(*rig);
  }
  if (const auto by = given(assignments, "render.by")) config.radiance = radiance_of_key(*by, row);
  const Fields all = fields(config);
  for (const std::string& assignment : assignments) {
    if (assignment.starts_with("radiance=") || assignment.starts_with("paths."))
      throw std::invalid_argument(assignment +
                                  ": the renderer is render.by, and render.* are its keys");
    set_field(all, assignment);
  }
  validate(config);
  require_files(config.scene);
  see(config.scene, sight_of(config.rig));
  return config;
}

const std::vector<CousinMove>& cousin_moves(const SceneConfig& scene) {
  static const std::vector<CousinMove> kNone;
  const SceneRow& row = row_of(scene);
  return row.cousin_moves ? row.cousin_moves() : kNone;
}

RunCousin cousin_of(const RunConfig& config, std::uint64_t seed, int scene_index) {
  RunCousin cousin{config, {}};
  if (is_twin(config.cousin)) return cousin;
  const SceneBuild scene{.seed = seed, .index = is_series(config.scene) ? 0 : scene_index};
  cousin.changes = move_to_cousin(fields(cousin.config), cousin_moves(config.scene), config.cousin,
                                  scene.rng().fork("cousin"));
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

Streams planned_streams(const RunConfig& config, Reader reader) {
  if (reader == Reader::anybody || !config.pipeline) return streams_for(config, nullptr);
  const StreamReader own = reader_of(*config.pipeline);
  return streams_for(config, &own);
}

std::string keys_text(RunConfig config) {
  const std::vector<CousinMove>& moves = cousin_moves(config.scene);
  return describe(fields(config)) +
         (moves.empty() ? "" : "\nAt 1, cousin.AXIS moves\n" + describe(moves));
}

std::vector<std::string> user_mesh_warnings(const RunConfig& config) {
  std::vector<std::string> warnings;
  for (const UserFile& file : user_files(config.scene)) {
    if (!file.is_mesh) continue;
    for (std::string& text : user_mesh_warnings(file.path)) warnings.push_back(std::move(text));
  }
  return warnings;
}

std::string user_files_hash(const SceneConfig& config) {
  std::string hash;
  for (const UserFile& file : user_files(config)) hash += sha256_hex_of_file(file.path);
  return hash;
}

std::string simulator_toml(const RunConfig& config) {
  RunConfig copy = config;  // fields point into what they describe
  const Fields light = copy.radiance == RadianceBy::paths ? nested("paths", fields(copy.paths))
                                                          : nested("render", fields(copy.cached));
  const std::string text =
      to_toml(nested("scene", fields(copy.scene)) + nested("rig", fields(copy.rig)) + light);
  const std::string cousin =
      is_twin(config.cousin) ? "" : "\n[cousin]\n" + to_toml(fields(copy.cousin));
  RigCaptureConfig plain;
  const std::string capture = to_toml(fields(copy.capture));
  return (capture == to_toml(fields(plain)) ? text : text + "\n[capture]\n" + capture) + cousin;
}

std::string resolved_toml(const RunConfig& config) {
  RunConfig copy = config;
  return to_toml(file_fields(copy));
}

std::string config_hash(const RunConfig& config, std::uint64_t seed) {
  return sha256_hex(resolved_toml(config) + "\nseed = " + std::to_string(seed) + "\n" +
                    user_files_hash(config.scene));
}

}  // namespace cousin
