#pragma once

#include <cstdint>
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

/// Sorts by depth (stable radix sort) and makes the lists: each pair's ellipse where alpha is 1/255
/// meets its tile's pixels. The result does not depend on the number of threads.
/// @param depth_order  as ProjectTask leaves it, one of each of `count` Gaussians
/// @throws std::runtime_error if there are more than 2^26 pairs
void make_tile_lists(const ProjectedSplat* projected, const std::uint32_t* depth_order, int count,
                     int width_px, int height_px, TileLists& lists);

}  // namespace cousin
