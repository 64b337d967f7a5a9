#include "benchmarks/scenes/stand_cache.h"

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

}  // namespace

Rng stretch_rng(std::uint64_t seed, int plant) {
  return Rng(seed).fork("strawberry stretch").fork(static_cast<std::uint64_t>(plant));
}

fs::path stand_file(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant) {
  const std::string key = sha256_hex(description(config.stand, config.bed) + "\nseed " +
                                     std::to_string(seed) + "\nstretch " + std::to_string(plant));
  return fs::path(config.cache) / (key.substr(0, 32) + ".stand");
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

}  // namespace cousin
