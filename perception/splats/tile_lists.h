#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "perception/splats/splat_kernels.h"

namespace cousin {

/// Which Gaussians each tile composites, front to back; ties of depth by index. The (Gaussian,
/// tile) pairs are numbered Gaussian by Gaussian, in the order of their indices.
struct TileLists {
  int tiles_across = 0, tiles_down = 0;
  std::vector<std::uint32_t> tile_begin;              ///< tiles + 1
  std::vector<std::uint32_t> tile_splat, tile_pair;   ///< entries of all tiles
  std::vector<std::uint32_t> pair_first, pair_count;  ///< of each Gaussian; count 0 = not shown
  std::vector<std::uint32_t> front_to_back;           ///< those shown

  /// A part of the Gaussians' order, with its pairs and how many each tile has of them.
  struct Part {
    std::vector<std::uint32_t> pair_tile, tile_count;
  };
  std::vector<Part> parts;                   ///< scratch
  std::vector<std::uint32_t> keys, scratch;  ///< scratch of the sort
};

/// More pairs in one view than are listed at once: the lists, and training's partial derivatives of
/// each pair, would take gigabytes.
inline constexpr std::size_t kMostPairs = std::size_t{1} << 26;
struct TooManyPairs : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Sorts by depth (stable radix sort) and makes the lists: each pair's ellipse where alpha is 1/255
/// meets its tile's pixels. The result does not depend on the number of threads.
/// @param depth_order  as ProjectTask leaves it, one of each of `count` Gaussians
/// @param most  tests set less
/// @throws TooManyPairs
void make_tile_lists(const ProjectedSplat* projected, const std::uint32_t* depth_order, int count,
                     int width_px, int height_px, TileLists& lists, std::size_t most = kMostPairs);

}  // namespace cousin
