#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/score/trait_statistics.h"
#include "sim/types/rng.h"

namespace cousin {

/// 95 % intervals of numbers over pictures. Pictures of the same plants are drawn together. Where
/// all are of one plant, the pictures are drawn: the interval then misses what they share.
class PlantBootstrap {
 public:
  /// @param plants  of each picture, by a name
  PlantBootstrap(const std::vector<std::string>& plants, int resamples, std::uint64_t seed);

  using Statistic = std::function<double(std::span<const std::size_t> pictures)>;
  /// Without an interval where there is one picture, or where too few draws have a value.
  WithInterval of(const Statistic& statistic, const std::string& name) const;

 private:
  int resamples_;
  Rng rng_;
  std::vector<std::vector<std::size_t>> clusters_;
  std::vector<std::size_t> all_;
};

}  // namespace cousin
