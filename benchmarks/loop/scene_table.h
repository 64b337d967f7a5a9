#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/loop/plan.h"
#include "benchmarks/loop/simulate.h"
#include "sim/dataset/truth_io.h"
#include "sim/sensors/rig_capture.h"
#include "sim/types/capture.h"

namespace cousin {

/// One scene of a run, built and ready to be photographed, whatever made it.
struct BuiltScene {
  std::shared_ptr<const void> owner;  ///< keeps alive what the rest points to
  const Scene* scene = nullptr;
  const RigCapture* rig = nullptr;
  const std::vector<TrueView>* views = nullptr;  ///< of the rig's first sensor
  std::function<RigFrame(int frame, const Streams&)> take;
  std::function<TruthImages(int frame, const TruthNeeds&, std::size_t sensor)> truth;
  std::function<Capture()> capture_header;  ///< without frames
  std::function<SceneTruth()> scene_truth;  ///< without images
};

/// What a scene is configured by.
struct SceneRequest {
  std::vector<std::string> assignments;  ///< key=value; those of the pipeline after "pipeline."
  std::filesystem::path file;            ///< TOML, before them; empty: none
  /// In and out: the pipeline that reads the images; null: nobody yet, as in a dataset.
  PipelineConfig* pipeline = nullptr;
};

/// A configured scene: all that the verbs ask of it.
struct SceneJob {
  std::string keys;  ///< configuration keys, as --keys prints them
  DeviceConfig rig;
  std::string toml;  ///< resolved, with the pipeline's keys
  Streams streams;   ///< that a capture holds
  DepthBy depth_by = DepthBy::matched;
  int views = 0;  ///< of each scene
  std::function<std::string(std::uint64_t seed)> hash;
  std::function<std::vector<PlanEntry>()> plan;  ///< of the simulator's passes
  std::function<BuiltScene(std::uint64_t seed, int scene_index)> build;
  /// All frames of `streams` and the truth images that are asked for, in memory.
  std::function<SimulatedRun(std::uint64_t seed, int scene_index, const TruthNeeds&,
                             const Progress&)>
      simulate;
  /// What of the user's mesh is passed over, for the user: the file is read for it.
  std::function<std::vector<std::string>()> warnings;
};

/// A row of `cousin scenes`.
struct SceneEntry {
  std::string name;
  std::string status;  ///< "built in", or why not
  std::string help;
  bool has_points = false;  ///< keypoints are what its views are for: part of the default truth
  /// @throws as seeds_run_config.
  std::function<SceneJob(const SceneRequest&)> configure;
};

/// To add a scene, add a row.
std::span<const SceneEntry> scene_table();
/// @throws std::invalid_argument listing the names that exist.
const SceneEntry& scene_entry(const std::string& name);

}  // namespace cousin
