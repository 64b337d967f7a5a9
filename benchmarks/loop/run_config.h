#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/loop/box_noise_config.h"
#include "benchmarks/loop/keypoint_noise_config.h"
#include "perception/pipelines/pipeline_table.h"
#include "scenes/row/scene_row.h"
#include "sim/config/cousin.h"
#include "sim/config/fields.h"
#include "sim/render/path_tracer.h"
#include "sim/render/radiance_pass.h"
#include "sim/sensors/rig_capture.h"

namespace cousin {

/// Which renderer makes the light that cameras see.
enum class RadianceBy {
  cached,  ///< diffuse light computed once for all views: still matt scenes alone
  paths,   ///< each pixel's own paths: noise in place of interpolation
};

/// Everything that decides what a run does, apart from the seed. Scene keys stand alone
/// (`cultivar`), and so do those of the capture (`depth_by`, `streams`); the others carry a prefix
/// (`rig.`, `render.`, `keypoints.`, `boxes.`, `pipeline.`, `cousin.`). As `rig` decides what
/// `rig.` holds, `render.by` decides what `render.` does.
struct RunConfig {
  SceneConfig scene;
  DeviceConfig rig = PhoneConfig{};
  RigCaptureConfig capture;
  std::string streams = "auto";  ///< images of the capture: auto, all, or names of Streams
  RadianceBy radiance = RadianceBy::paths;
  RadianceConfig cached;
  PathConfig paths;
  std::optional<PipelineConfig> pipeline;  ///< that reads the images; none: nobody yet
  KeypointNoiseConfig keypoints;           ///< of true ones, where a pipeline takes them
  BoxNoiseConfig boxes;                    ///< the same of boxes
  CousinDistance cousin;                   ///< each scene is another cousin of what the keys say
};
/// All keys; they point into it.
Fields fields(RunConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const RunConfig& config);

/// The defaults of a scene with its rig's preset.
RunConfig default_run(const SceneRow& row);

/// Defaults, then the rig's preset, then `file` (as resolved_toml writes it; keys may be missing;
/// empty = none), then the user's `key=value`s in order. `rig=NAME` picks the preset first, in
/// place of the file's rig, and `render.by` the renderer.
/// @param pipeline  what it holds comes before `file`
/// @throws std::invalid_argument naming key, value and limit; std::runtime_error naming the file,
/// or the user's mesh or environment if there is no such file.
RunConfig run_config(const SceneRow& row, const std::vector<std::string>& assignments,
                     const std::filesystem::path& file = {},
                     std::optional<PipelineConfig> pipeline = {});

/// The configuration of one scene: the keys that `cousin` moves, moved. The same at distance 0.
struct RunCousin {
  RunConfig config;
  std::vector<CousinChange> changes;
};
/// A series is one cousin.
/// @throws std::invalid_argument if the moved configuration is not valid, saying what moved it.
RunCousin cousin_of(const RunConfig& config, std::uint64_t seed, int scene_index);
/// What the scene's cousins.toml moves; nothing for a scene without one.
const std::vector<CousinMove>& cousin_moves(const SceneConfig& scene);

/// A pipeline's method that reads images, and which.
struct StreamReader {
  std::string method;
  Streams needed;
};
StreamReader reader_of(const PipelineConfig& pipeline);
/// For whom the images are rendered: for the pipeline, or for anybody, as in a dataset.
enum class Reader { pipeline, anybody };
/// The streams that a capture holds: those that `streams` names; `auto` is what the pipeline needs,
/// or for anybody all that the rig has.
/// @throws std::invalid_argument if the rig has no such stream, or the pipeline needs one that
/// `streams` leaves out or the rig does not have.
Streams planned_streams(const RunConfig& config, Reader reader = Reader::pipeline);
/// What a configured pipeline reads.
Streams needed_streams(const PipelineConfig& config);

/// Keys, as --keys prints them, and what cousin.* moves.
std::string keys_text(RunConfig config);
/// What of the user's meshes is passed over, for the user: the files are read for it.
std::vector<std::string> user_mesh_warnings(const RunConfig& config);
/// SHA-256 of the bytes of the user's files, one after the other; "" if there are none. Whatever is
/// kept under a configuration's name depends on them too.
std::string user_files_hash(const SceneConfig& config);

/// The resolved configuration as TOML.
std::string resolved_toml(const RunConfig& config);
/// The part of it that decides the images: scene, rig, the renderer that runs, and the capture's
/// keys where they are not as by default.
std::string simulator_toml(const RunConfig& config);
/// SHA-256 of the resolved configuration, the user's files and the seed.
std::string config_hash(const RunConfig& config, std::uint64_t seed);

}  // namespace cousin
