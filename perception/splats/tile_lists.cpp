#include "perception/splats/tile_lists.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr std::uint32_t kHidden = 0xffffffffU;
constexpr std::size_t kPart = 2048;     ///< Gaussians
constexpr std::size_t kTold = 4096;     ///< pairs of a part that the others need not know of
constexpr std::size_t kListsAhead = 8;  ///< Gaussians ahead of which they are fetched from memory

/// Positive floats sort as their bits do: three stable passes of 11 bits.
void sort_by_depth(const std::uint32_t* depth_order, int count, TileLists& lists) {
  std::vector<std::uint32_t>& order = lists.front_to_back;
  std::vector<std::uint32_t>& keys = lists.keys;
  order.clear();
  keys.clear();
  std::array<std::array<std::uint32_t, 2048>, 3> histogram{};
  for (int i = 0; i < count; ++i) {
    const std::uint32_t key = depth_order[i];
    if (key == kHidden) continue;
    order.push_back(static_cast<std::uint32_t>(i));
    keys.push_back(key);
    for (std::size_t pass = 0; pass < 3; ++pass) ++histogram[pass][key >> (11 * pass) & 2047U];
  }
  const std::size_t n = order.size();
  lists.scratch.resize(2 * n);
  std::uint32_t* from_order = order.data();
  std::uint32_t* from_key = keys.data();
  std::uint32_t* to_order = lists.scratch.data();
  std::uint32_t* to_key = lists.scratch.data() + n;
  for (std::size_t pass = 0; pass < 3; ++pass) {
    std::uint32_t sum = 0;
    for (std::uint32_t& bin : histogram[pass]) {
      const std::uint32_t size = bin;
      bin = sum;
      sum += size;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t to = histogram[pass][from_key[i] >> (11 * pass) & 2047U]++;
      to_order[to] = from_order[i];
      to_key[to] = from_key[i];
    }
    std::swap(from_order, to_order);
    std::swap(from_key, to_key);
  }
  if (from_order != order.data()) std::copy_n(from_order, n, order.data());
}

/// Where the ellipse reaches in x, in the strip dy0 <= dy <= dy1, from its centre. False if it does
/// not meet the strip.
bool strip_extent(const ProjectedSplat& s, float dy0, float dy1, float& low, float& high) {
  const float room = s.log2_opacity - SplatLimits::smallest_log2_alpha;
  const float height = s.half_height_px;
  if (dy0 > height || dy1 < -height) return false;
  // The ends in x lie at these heights; where those are outside the strip, at its nearer border.
  const float slope = s.tilt * height / s.half_width_px * height;
  const auto end = [&](float dy_of_end, float sign) {
    if (dy_of_end >= dy0 && dy_of_end <= dy1) return sign * s.half_width_px;
    const float dy = std::clamp(std::clamp(dy_of_end, dy0, dy1), -height, height);
    const float rest = std::max(0.0F, s.down * dy * dy + room);
    return s.tilt * dy + sign * std::sqrt(rest / -s.across);
  };
  high = end(slope, 1);
  low = end(-slope, -1);
  return true;
}

int tile_of(float pixel, int tiles) {
  const float tile = std::floor(pixel / SplatTile::side);
  return static_cast<int>(std::clamp(tile, -1.0F, static_cast<float>(tiles)));
}

void list_pairs(const ProjectedSplat& s, const TileLists& lists, TileLists::Part& part) {
  const float pad = 0.05F + 1e-5F * (s.half_width_px + s.half_height_px);
  const int first_row = std::max(0, tile_of(s.y_px - s.half_height_px - pad, lists.tiles_down));
  const int last_row =
      std::min(lists.tiles_down - 1, tile_of(s.y_px + s.half_height_px + pad, lists.tiles_down));
  for (int row = first_row; row <= last_row; ++row) {
    const float y = static_cast<float>(row * SplatTile::side) - s.y_px;
    float low = 0, high = 0;
    if (!strip_extent(s, y - pad, y + SplatTile::side - 1 + pad, low, high)) continue;
    const int first = std::max(0, tile_of(s.x_px + low - pad, lists.tiles_across));
    const int last =
        std::min(lists.tiles_across - 1, tile_of(s.x_px + high + pad, lists.tiles_across));
    for (int column = first; column <= last; ++column) {
      const auto tile = static_cast<std::uint32_t>(row * lists.tiles_across + column);
      part.pair_tile.push_back(tile);
      ++part.tile_count[tile];
    }
  }
}

}  // namespace

void make_tile_lists(const ProjectedSplat* projected, const std::uint32_t* depth_order, int count,
                     int width_px, int height_px, TileLists& lists, std::size_t most) {
  lists.tiles_across = (width_px + SplatTile::side - 1) / SplatTile::side;
  lists.tiles_down = (height_px + SplatTile::side - 1) / SplatTile::side;
  const auto tiles =
      static_cast<std::size_t>(lists.tiles_across) * static_cast<std::size_t>(lists.tiles_down);
  sort_by_depth(depth_order, count, lists);
  const std::size_t shown = lists.front_to_back.size();
  const std::size_t parts = (shown + kPart - 1) / kPart;
  lists.parts.resize(parts);
  lists.pair_first.assign(static_cast<std::size_t>(count), 0);
  lists.pair_count.assign(static_cast<std::size_t>(count), 0);

  // Pairs of each part. Too many of all together are noticed before they are all in memory.
  std::atomic<std::size_t> told = 0;
  tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t p) {
    std::size_t told_of_part = 0;
    TileLists::Part& part = lists.parts[p];
    part.pair_tile.clear();
    part.tile_count.assign(tiles, 0);
    for (std::size_t i = p * kPart; i < std::min(shown, (p + 1) * kPart); ++i) {
      const std::uint32_t splat = lists.front_to_back[i];
      __builtin_prefetch(projected + lists.front_to_back[std::min(i + kListsAhead, shown - 1)]);
      const std::size_t before = part.pair_tile.size();
      if (before - told_of_part >= kTold) {
        told += before - told_of_part;
        told_of_part = before;
      }
      if (told > most) break;
      list_pairs(projected[splat], lists, part);
      lists.pair_count[splat] = static_cast<std::uint32_t>(part.pair_tile.size() - before);
    }
  });
  std::size_t pairs = 0;
  for (const TileLists::Part& part : lists.parts) pairs += part.pair_tile.size();
  if (pairs > most) {
    lists.parts = {};  // gigabytes
    throw TooManyPairs(
        std::to_string(lists.pair_first.size()) + " splats cover " + std::to_string(pairs) +
        " tiles in one view, all taken together, more than the limit of " + std::to_string(most));
  }

  // Neighbours in memory are neighbours in space: numbered in that order, their pairs are too.
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < lists.pair_first.size(); ++i) {
    lists.pair_first[i] = next;
    next += lists.pair_count[i];
  }

  // Counting sort into tiles; parts in their order keep it stable.
  lists.tile_begin.assign(tiles + 1, 0);
  std::uint32_t sum = 0;
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    lists.tile_begin[tile] = sum;
    for (TileLists::Part& part : lists.parts) {
      const std::uint32_t size = part.tile_count[tile];
      part.tile_count[tile] = sum;
      sum += size;
    }
  }
  lists.tile_begin[tiles] = sum;
  lists.tile_splat.resize(pairs);
  lists.tile_pair.resize(pairs);
  tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t p) {
    TileLists::Part& part = lists.parts[p];
    std::size_t pair = 0;
    for (std::size_t i = p * kPart; i < std::min(shown, (p + 1) * kPart); ++i) {
      const std::uint32_t splat = lists.front_to_back[i];
      for (std::uint32_t k = 0; k < lists.pair_count[splat]; ++k, ++pair) {
        const std::uint32_t to = part.tile_count[part.pair_tile[pair]]++;
        lists.tile_splat[to] = splat;
        lists.tile_pair[to] = lists.pair_first[splat] + k;
      }
    }
  });
}

}  // namespace cousin
