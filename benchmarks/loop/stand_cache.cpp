#include "benchmarks/loop/stand_cache.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLimit_bytes = std::size_t{16} << 20;
constexpr std::size_t kHash_chars = 64;
constexpr std::string_view kSum = "sha256 ";

/// Its first line is the hash of all that follows.
std::string sealed(const std::string& text) {
  return std::string(kSum) + sha256_hex(text) + "\n" + text;
}

std::string opened(const fs::path& file) {
  const std::string bytes = read_file(file, kLimit_bytes);
  const std::size_t head = kSum.size() + kHash_chars + 1;
  const std::string text = bytes.size() > head ? bytes.substr(head) : "";
  if (bytes != sealed(text))
    throw std::runtime_error(file.string() +
                             ": its sha256 is not that of its first line: it was cut off or "
                             "changed; delete it, and it is made anew");
  return text;
}

fs::path file_of(const std::string& folder, const std::string& description, std::uint64_t seed,
                 const std::string& which, const char* extension) {
  const std::string key = sha256_hex(description + "\nseed " + std::to_string(seed) + "\n" + which);
  return fs::path(folder) / (key.substr(0, 32) + extension);
}

}  // namespace

Rng stretch_rng(std::uint64_t seed, int plant) {
  return Rng(seed).fork("strawberry stretch").fork(static_cast<std::uint64_t>(plant));
}

fs::path stand_file(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant) {
  return file_of(config.cache, description(config.stand, config.bed), seed,
                 "stretch " + std::to_string(plant), ".stand");
}

StandRest stand_at_rest(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant) {
  const Rng rng = stretch_rng(seed, plant);
  if (config.cache.empty()) return settle_stand(config.stand, config.bed, rng);
  const fs::path file = stand_file(config, seed, plant);
  if (fs::exists(file))
    return rest_from_text(opened(file), file.string(), config.stand, config.bed, rng);
  StandRest rest = settle_stand(config.stand, config.bed, rng);
  write_file(file, sealed(to_text(rest)));
  return rest;
}

fs::path tree_file(const ApplesSceneConfig& config, std::uint64_t seed, int index) {
  return file_of(config.cache, description_of_tree(config), seed, "tree " + std::to_string(index),
                 ".tree");
}

BranchSettler tree_settler(const ApplesSceneConfig& config, std::uint64_t seed, int index) {
  if (config.cache.empty()) return settle_branches;
  return [file = tree_file(config, seed, index)](const std::vector<HangingBranch>& branches) {
    if (fs::exists(file)) return rests_from_text(opened(file), file.string(), branches);
    std::vector<SagResult> rests = settle_branches(branches);
    const bool can_be_kept = std::all_of(rests.begin(), rests.end(), [](const SagResult& sag) {
      return sag.status == PlantStatus::ok || sag.status == PlantStatus::not_at_rest ||
             sag.status == PlantStatus::penetrates;  // what overlaps is thinned
    });
    if (can_be_kept && !rests.empty()) write_file(file, sealed(rests_to_text(rests)));
    return rests;
  };
}

}  // namespace cousin
