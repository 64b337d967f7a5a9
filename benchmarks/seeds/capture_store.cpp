#include "benchmarks/seeds/capture_store.h"

#include <string>

#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/seam_io.h"
#include "sim/dataset/truth_io.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

std::string capture_name(const SeedsRunConfig& config, std::uint64_t seed, int scene_index,
                         const TruthNeeds& needs) {
  SeedsRunConfig seen = config;
  seen.pipeline = SeedsPipelineConfig{};
  std::string key = std::string(COUSIN_VERSION) + "\n" + config_hash(seen, seed) + "\n" +
                    std::to_string(scene_index) + "\n";
  for (const bool need : {needs.depth, needs.normal, needs.position, needs.instance, needs.part,
                          needs.coverage, needs.visibility}) {
    key += need ? '1' : '0';
  }
  constexpr std::size_t kDigits = 16;
  return (config.scene.sphere ? "sphere" : config.scene.cultivar) + "_" +
         sha256_hex(key).substr(0, kDigits);
}

}  // namespace

SimulatedRun stored_seeds(const fs::path& folder, const SeedsRunConfig& config, std::uint64_t seed,
                          int scene_index, const TruthNeeds& needs, const Progress& progress) {
  if (folder.empty()) return simulate_seeds(config, seed, scene_index, needs, progress);
  const fs::path stored = folder / capture_name(config, seed, scene_index, needs);
  if (fs::exists(stored)) {
    if (progress) progress("read " + stored.filename().string(), 0, 1);
    SimulatedRun run;
    run.capture = read_capture(stored);
    run.truth = read_truth(stored);
    run.timings = read_timings(stored);
    return run;
  }
  SimulatedRun run = simulate_seeds(config, seed, scene_index, needs, progress);
  const fs::path part = stored.string() + ".part";
  fs::remove_all(part);
  write_capture(part, run.capture);
  write_truth(part, run.truth);
  write_timings(part, run.timings);
  fs::rename(part, stored);
  return run;
}

}  // namespace cousin
