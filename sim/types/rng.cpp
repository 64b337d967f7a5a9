#include "sim/types/rng.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cousin {
namespace {

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Rng::Rng(std::uint64_t seed) : key_(mix(seed + 0x9e3779b97f4a7c15ULL)), state_(key_) {}

Rng Rng::fork(std::string_view purpose) const {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a, then mixed with the parent's key
  for (const char c : purpose) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return Rng(mix(key_ ^ mix(hash)) + 0x632be59bd9b4e019ULL);
}

Rng Rng::fork(std::uint64_t index) const {
  return Rng(mix(key_ + mix(index + 0xd1b54a32d192ed03ULL)) + 0x2545f4914f6cdd1dULL);
}

Rng::result_type Rng::operator()() {
  state_ += 0x9e3779b97f4a7c15ULL;
  return mix(state_);
}

double uniform(Rng& rng) { return static_cast<double>(rng() >> 11) * 0x1.0p-53; }

double uniform(Rng& rng, double low, double high) { return low + (high - low) * uniform(rng); }

std::uint64_t uniform_index(Rng& rng, std::uint64_t count) {
  // Rejection keeps it exact; the loop repeats with probability count / 2^64.
  const std::uint64_t limit = Rng::max() - Rng::max() % count;
  for (;;) {
    const std::uint64_t draw = rng();
    if (draw < limit) return draw % count;
  }
}

double normal(Rng& rng) {
  // Box-Muller, one of the pair: no state is kept between calls, so streams stay forkable.
  const double u = 1.0 - uniform(rng);
  const double v = uniform(rng);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

double truncated_normal(Rng& rng, double mean, double sigma, double limit_sigma) {
  for (;;) {
    const double z = normal(rng);
    if (std::abs(z) <= limit_sigma) return mean + sigma * z;
  }
}

double poisson(Rng& rng, double mean) {
  if (!(mean > 0)) return 0;
  if (mean < 30) {
    const double u = uniform(rng);
    double probability = std::exp(-mean);
    double cumulative = probability;
    double count = 0;
    while (u > cumulative && count < 200) {
      count += 1;
      probability *= mean / count;
      cumulative += probability;
    }
    return count;
  }
  const double z = normal(rng);
  return std::max(0.0, std::round(mean + std::sqrt(mean) * z + (z * z - 1) / 6));
}

}  // namespace cousin
