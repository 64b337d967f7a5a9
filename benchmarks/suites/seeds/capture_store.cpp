#include "benchmarks/suites/seeds/capture_store.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/truth_choice.h"
#include "scenes/seeds/toml_text.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/truth_io.h"
#include "sim/types/whole_file.h"

namespace cousin {

std::string built_in_tables() {
  return sha256_hex(cultivars_toml()) + "\n" + sha256_hex(setting_toml()) + "\n";
}

namespace fs = std::filesystem;
namespace {

std::string capture_name(const RunConfig& config, std::uint64_t seed, int scene_index,
                         const TruthNeeds& needs) {
  std::string key = std::string(COUSIN_VERSION) + "\n" + simulator_toml(config) + "\n" +
                    std::to_string(seed) + "\n" + std::to_string(scene_index) + "\n" +
                    built_in_tables();
  const std::string files = user_files_hash(config.scene);
  if (!files.empty()) key += files + "\n";
  for (const bool need :
       {needs.depth, needs.normal, needs.position, needs.instance, needs.part, needs.coverage,
        needs.visibility, needs.shares, needs.keypoints, needs.flow}) {
    key += need ? '1' : '0';
  }
  // Phones have neither, and keep the names that they have.
  if (needs.disparity || needs.noise_free_depth || needs.invalid_reason || needs.leaf_area)
    key += "\ntruth " + to_string(needs);
  const Streams streams = planned_streams(config);
  if (streams != Streams{.color = true}) key += "\nstreams " + to_string(streams);
  constexpr std::size_t kDigits = 16;
  return (seeds_scene(config).sphere ? "sphere" : seeds_scene(config).cultivar) + "_" +
         sha256_hex(key).substr(0, kDigits);
}

/// @throws std::runtime_error naming the folder if it does not hold what its name says.
void check_whole(const fs::path& stored, const SimulatedRun& run, const RunConfig& config,
                 std::uint64_t seed, const TruthNeeds& needs) {
  const auto require = [&](bool good, const char* what) {
    if (!good) {
      throw std::runtime_error(stored.string() + ": " + what +
                               "; remove the folder to have it rendered again");
    }
  };
  const auto views = static_cast<std::size_t>(config.scene.views());
  require(run.capture.frames.size() == views && run.truth.views.size() == views,
          "has not as many views as the scene");
  require(run.truth.seed == seed, "is of another seed");
  const Streams streams = planned_streams(config);
  for (const Frame& frame : run.capture.frames) {
    const auto& sensors = frame.sensors;
    const auto there = [&](const auto& has) {
      return std::any_of(sensors.begin(), sensors.end(), has);
    };
    require(!streams.color || there([](const SensorFrame& s) { return !s.color.empty(); }),
            "lacks a colour image");
    require(!streams.raw || there([](const SensorFrame& s) { return !s.raw.empty(); }),
            "lacks a raw image");
    require(!streams.infrared || there([](const SensorFrame& s) { return !s.grey.empty(); }),
            "lacks an infrared image");
    require(!streams.depth || there([](const SensorFrame& s) { return !s.depth.empty(); }),
            "lacks a depth image");
  }
  const bool any = needs != TruthNeeds{};
  require(!any || run.truth.images.size() == views, "lacks truth images");
  for (const TruthImages& images : run.truth.images) {
    require(!(needs.depth && images.depth_m.empty()) && !(needs.normal && images.normal.empty()) &&
                !(needs.position && images.position_m.empty()) &&
                !(needs.instance && images.instance.empty()) &&
                !(needs.part && images.part.empty()) &&
                !(needs.coverage && images.specimen_coverage.empty()) &&
                !(needs.visibility && images.visibility.empty()) &&
                !(needs.shares && images.shares.empty()) &&
                !(needs.disparity && images.stereo.state.empty()) &&
                !(needs.noise_free_depth && images.noise_free_depth_m.empty()) &&
                !(needs.invalid_reason && images.invalid_reason.empty()),
            "lacks a truth image");
  }
}

SimulatedRun read_stored(const fs::path& stored, const RunConfig& config, std::uint64_t seed,
                         const TruthNeeds& needs) {
  SimulatedRun run;
  run.categories = specimen_categories(config.scene);
  run.capture = read_capture(stored);
  run.truth = read_truth(stored);
  check_whole(stored, run, config, seed, needs);
  return run;
}

/// Writes beside the final name and renames. Whoever renders the same capture at the same time
/// writes elsewhere; the first to be done wins, and both are the same bytes. What killed processes
/// left of it is removed.
void store(const fs::path& stored, const SimulatedRun& run) {
  PartFolder part(stored);
  for (const auto& entry : fs::directory_iterator(stored.parent_path())) {
    if (entry.path() != part.path()) remove_if_stale(entry.path());
  }
  write_capture(part.path(), run.capture);
  write_truth(part.path(), run.truth, TruthFormat::exr);  // packed: .npy takes several times that
  part.take_free_name();
}

}  // namespace

SimulatedRun stored_seeds(const fs::path& folder, const RunConfig& config, std::uint64_t seed,
                          int scene_index, const TruthNeeds& needs, const Progress& progress) {
  if (folder.empty()) return simulate(config, seed, scene_index, needs, progress);
  const fs::path stored = folder / capture_name(config, seed, scene_index, needs);
  if (fs::exists(stored)) {
    if (progress) progress("read " + stored.filename().string(), 0, 1);
    return read_stored(stored, config, seed, needs);
  }
  SimulatedRun run = simulate(config, seed, scene_index, needs, progress);
  store(stored, run);
  return run;
}

}  // namespace cousin
