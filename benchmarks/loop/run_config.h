#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "perception/pipelines/pipeline_table.h"
#include "perception/pipelines/seeds.h"
#include "scenes/seeds/seeds_scene.h"
#include "sim/config/cousin.h"
#include "sim/config/fields.h"
#include "sim/render/path_tracer.h"
#include "sim/render/radiance_pass.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/rig_capture.h"

namespace cousin {

/// Which renderer makes the light that cameras see.
enum class RadianceBy {
  cached,  ///< diffuse light computed once for all views, keys `render.`
  paths,   ///< each pixel's own paths, keys `paths.`: noise in place of interpolation
};

/// Everything that decides what `run seeds` does, apart from the seed. Scene keys stand alone
/// (`cultivar`), and so do `radiance` and those of the capture (`depth_by`, `streams`); the others
/// carry a prefix (`rig.`, `render.`, `paths.`, `pipeline.`).
struct SeedsRunConfig {
  SeedsSceneConfig scene;
  DeviceConfig rig = PhoneConfig{};
  RigCaptureConfig capture;
  std::string streams = "auto";  ///< images of the capture: auto, all, or names of Streams
  RadianceBy radiance = RadianceBy::cached;
  RadianceConfig render;
  PathConfig paths = {.max_bounces = 5};  ///< as deep as the cache, whose 4 come after its points
  SeedsPipelineConfig pipeline;
  CousinDistance cousin;  ///< each scene is another cousin of what the other keys say
};
Fields fields(SeedsRunConfig& config);
void validate(const SeedsRunConfig& config);

/// Defaults, then the rig's preset, then `file` (as resolved_toml writes it; keys may be missing;
/// empty = none), then the user's `key=value`s in order. `rig=NAME` picks the preset first, in
/// place of the file's rig.
/// @param pipeline  in and out: the one that runs, whose keys `pipeline.` are; null: seeds. What it
/// holds comes before `file`.
/// @throws std::invalid_argument naming key, value and limit; std::runtime_error naming the file,
/// or the user's mesh or environment if there is no such file.
SeedsRunConfig seeds_run_config(const std::vector<std::string>& assignments,
                                const std::filesystem::path& file = {},
                                PipelineConfig* pipeline = nullptr);
/// All keys of a run, those of another pipeline in place of the seeds' own.
Fields fields(SeedsRunConfig& config, PipelineConfig* pipeline);

/// What scenes/seeds/cousins.toml moves.
const std::vector<CousinMove>& seeds_cousin_moves();

/// The configuration of one scene: the keys that `cousin` moves, moved. The same at distance 0.
struct SeedsCousin {
  SeedsRunConfig config;
  std::vector<CousinChange> changes;
};
/// @throws std::invalid_argument if the moved configuration is not valid, saying what moved it.
SeedsCousin cousin_of(const SeedsRunConfig& config, std::uint64_t seed, int scene_index);

/// Who reads the images. Nobody reads those of a dataset when it is rendered.
enum class Reader { pipeline, anybody };
/// A pipeline's method that reads images, and which.
struct StreamReader {
  std::string method;
  Streams needed;
};
StreamReader reader_of(const PipelineConfig& pipeline);
/// The streams that a capture holds: those that `streams` names; `auto` is what the reader needs,
/// or where there is none all that the rig has.
/// @throws as planned_streams
Streams streams_for(const std::string& streams, const Streams& there_are, const std::string& rig,
                    const StreamReader* reader);
/// The streams that a capture holds: those that `streams` names; `auto` is what the pipeline needs,
/// or for anybody all that the rig has.
/// @throws std::invalid_argument if the rig has no such stream, or the pipeline needs one that
/// `streams` leaves out or the rig does not have.
Streams planned_streams(const SeedsRunConfig& config, Reader reader = Reader::pipeline);
/// What a configured pipeline reads.
Streams needed_streams(const PipelineConfig& config);

/// The file of the user's own mesh; "" if the scene grows its specimens. @throws
/// std::invalid_argument if `specimen` is something else than "mesh:FILE".
std::string specimen_file(const SeedsSceneConfig& config);
/// SHA-256 of the bytes of the user's mesh and environment, one after the other; "" if there is
/// neither. Whatever is kept under a configuration's name depends on it too.
std::string user_files_hash(const SeedsSceneConfig& config);

/// The resolved configuration as TOML.
/// @param pipeline  as of seeds_run_config
std::string resolved_toml(const SeedsRunConfig& config, const PipelineConfig* pipeline = nullptr);
/// The part of it that decides the images: scene, rig, the renderer that runs, and the capture's
/// keys where they are not as by default.
std::string simulator_toml(const SeedsRunConfig& config);
/// SHA-256 of the resolved configuration, the user's files and the seed.
std::string config_hash(const SeedsRunConfig& config, std::uint64_t seed,
                        const PipelineConfig* pipeline = nullptr);

}  // namespace cousin
