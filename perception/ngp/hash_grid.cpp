#include "perception/ngp/hash_grid.h"

#include <cmath>

namespace cousin::ngp {

std::vector<GridLevel> grid_levels(const HashGridConfig& config) {
  std::vector<GridLevel> levels;
  const double growth =
      config.levels > 1
          ? std::log(static_cast<double>(config.finest) / config.coarsest) / (config.levels - 1)
          : 0;
  std::size_t offset = 0;
  for (int l = 0; l < config.levels; ++l) {
    GridLevel level;
    level.resolution = std::floor(config.coarsest * std::exp(growth * l) + 1e-9);
    level.side = static_cast<std::uint32_t>(level.resolution) + 2;
    const std::uint64_t dense = std::uint64_t{level.side} * level.side * level.side;
    const std::uint64_t most = std::uint64_t{1} << static_cast<unsigned>(config.log2_table);
    level.hashed = dense > most;
    level.entries = static_cast<std::uint32_t>(std::min(dense, most));
    level.offset = offset;
    offset += std::size_t{kFeatures} * level.entries;
    levels.push_back(level);
  }
  return levels;
}

std::size_t table_size(const std::vector<GridLevel>& levels) {
  return levels.empty() ? 0 : levels.back().offset + std::size_t{kFeatures} * levels.back().entries;
}

}  // namespace cousin::ngp
