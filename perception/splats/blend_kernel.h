#pragma once

#include "perception/splats/lane_functions.h"
#include "perception/splats/splat_kernels.h"

namespace cousin {

/// Offsets of a block's eight pixels, and where each block of a tile begins.
struct TileLayout {
  alignas(32) static constexpr float lane_x[8] = {0, 1, 2, 3, 0, 1, 2, 3};
  alignas(32) static constexpr float lane_y[8] = {0, 0, 0, 0, 1, 1, 1, 1};
  alignas(32) static constexpr float even_row[8] = {0, 2, 4, 6, 8, 10, 12, 14};
};

/// Bit 4 r + c: block c of block row r may hold a pixel where the Gaussian's alpha is 1/255.
/// (x, y) is the tile's first pixel minus the Gaussian's centre.
template <class L>
inline std::uint32_t blocks_touched(const ProjectedSplat& s, float x, float y) {
  // Of each pixel row: where across t^2 + (down dy^2 + room) = 0.
  const L tilt(s.tilt), down(s.down), room(s.log2_opacity - SplatLimits::smallest_log2_alpha);
  const L reach = L(-1) / L(s.across);
  const L pad(0.05F + 1e-5F * s.half_width_px);
  L low[2], high[2];
  typename L::Mask any[2];
  for (int odd = 0; odd < 2; ++odd) {
    const L dy = L::load(TileLayout::even_row) + L(y + static_cast<float>(odd));
    const L middle = tilt * dy;
    const L rest = multiply_add(down * dy, dy, room);
    any[odd] = at_least(rest, L(0));
    const L half = square_root(larger(rest, L(0)) * reach) + pad;
    low[odd] = middle - half;
    high[odd] = middle + half;
    low[odd] = where(any[odd], low[odd], L(1e9));
    high[odd] = where(any[odd], high[odd], L(-1e9));
  }
  const L from = smaller(low[0], low[1]) - L(x);
  const L to = larger(high[0], high[1]) - L(x);
  const auto valid = (any[0] | any[1]) & at_least(to, L(0)) & less(from, L(16));
  const L first = round_down(larger(round_up(from), L(0)) * L(0.25));
  const L last = round_down(smaller(round_down(to), L(15)) * L(0.25));
  return nibble_spans(first, smaller(larger(last, L(0)), L(3)), valid & at_least(last, first));
}

/// Where one tile lies, and which of its pixels are in the image.
struct TilePlace {
  int x0, y0, columns, rows;
};
inline TilePlace tile_place(const BlendTask& task, int tile) {
  TilePlace p;
  p.x0 = tile % task.tiles_across * SplatTile::side;
  p.y0 = tile / task.tiles_across * SplatTile::side;
  p.columns = task.width_px - p.x0 < SplatTile::side ? task.width_px - p.x0 : SplatTile::side;
  p.rows = task.height_px - p.y0 < SplatTile::side ? task.height_px - p.y0 : SplatTile::side;
  return p;
}
/// Place of pixel (x, y) of a tile among its blocks' lanes.
inline int lane_place(int x, int y) { return (y / 2 * 4 + x / 4) * 8 + y % 2 * 4 + x % 4; }

/// Copies a tile's part of an image to lanes and back.
inline void load_tile(const float* image, const BlendTask& task, const TilePlace& p, float* lanes) {
  for (int y = 0; y < p.rows; ++y) {
    const float* row =
        image + static_cast<std::size_t>(p.y0 + y) * static_cast<std::size_t>(task.width_px) + p.x0;
    for (int x = 0; x < p.columns; ++x) lanes[lane_place(x, y)] = row[x];
  }
}
inline void store_tile(const float* lanes, const BlendTask& task, const TilePlace& p,
                       float* image) {
  for (int y = 0; y < p.rows; ++y) {
    float* row =
        image + static_cast<std::size_t>(p.y0 + y) * static_cast<std::size_t>(task.width_px) + p.x0;
    for (int x = 0; x < p.columns; ++x) row[x] = lanes[lane_place(x, y)];
  }
}
/// Transmittance at the start: 1 in the image; negative = takes no more, as everywhere else.
inline std::uint32_t start_tile(const TilePlace& p, float* transmittance) {
  std::uint32_t alive = 0;
  for (int i = 0; i < 8 * SplatTile::blocks; ++i) transmittance[i] = -1;
  for (int y = 0; y < p.rows; ++y) {
    for (int x = 0; x < p.columns; ++x) {
      const int place = lane_place(x, y);
      transmittance[place] = 1;
      alive |= 1U << (place / 8);
    }
  }
  return alive;
}

/// Blocks with a pixel that takes more.
template <class L>
inline std::uint32_t alive_blocks(const float* transmittance) {
  std::uint32_t alive = 0;
  for (int block = 0; block < SplatTile::blocks; ++block) {
    const bool any = bits(less(L(0), L::load(transmittance + 8 * block))) != 0;
    alive |= (any ? 1U : 0U) << block;
  }
  return alive;
}

/// Entries of a list that are looked at together: the blocks of all first, without a branch that
/// waits for them.
constexpr std::uint32_t kEntryBatch = 32;
/// Entries ahead of which what they name is fetched from memory.
constexpr std::uint32_t kAhead = 8;

/// Below that share of its centre's inverse depth a disc is taken to end: no ray sees it at more
/// than four times the centre's depth.
constexpr float kLeastNearness = 0.25F;

/// Alpha of one Gaussian in one block, 0 below 1/255. `t` receives dx from the middle of its row,
/// `log2` the logarithm of what alpha is before it is limited.
template <class L>
inline L block_alpha(const L& dx, const L& dy, const L& across, const L& tilt, const L& down,
                     const L& log2_opacity, L& t, L& log2) {
  t = multiply_subtract(tilt, dy, dx);
  log2 = multiply_add(across * t, t, multiply_add(down * dy, dy, log2_opacity));
  const L alpha = smaller(exp2_blending(log2), L(SplatLimits::largest_alpha));
  return zero_unless(at_least(log2, L(SplatLimits::smallest_log2_alpha)), alpha);
}

template <class L, bool kDepth>
inline void blend_tile_as(const BlendTask& task, int tile) {
  const TilePlace place = tile_place(task, tile);
  alignas(32) float transmittance[8 * SplatTile::blocks];
  alignas(32) float color[3][8 * SplatTile::blocks] = {};
  alignas(32) float median[kDepth ? 8 * SplatTile::blocks : 8];
  alignas(32) float mean[kDepth ? 8 * SplatTile::blocks : 8];
  if constexpr (kDepth) {
    for (float& x : median) x = __builtin_nanf("");
    for (float& x : mean) x = 0;
  }
  std::uint32_t alive = start_tile(place, transmittance);

  const std::uint32_t begin = task.tile_begin[tile], end = task.tile_begin[tile + 1];
  std::uint32_t entry = begin;
  while (entry < end && alive != 0) {
    const std::uint32_t batch_end = end - entry < kEntryBatch ? end : entry + kEntryBatch;
    for (std::uint32_t e = entry; e < batch_end; ++e) {
      __builtin_prefetch(task.projected + task.tile_splat[e + kAhead < end ? e + kAhead : e]);
      const ProjectedSplat& s = task.projected[task.tile_splat[e]];
      task.touched[e] = blocks_touched<L>(s, static_cast<float>(place.x0) - s.x_px,
                                          static_cast<float>(place.y0) - s.y_px);
    }
    for (; entry < batch_end; ++entry) {
      std::uint32_t todo = task.touched[entry] & alive;
      const ProjectedSplat& s = task.projected[task.tile_splat[entry]];
      const L tile_dx = L::load(TileLayout::lane_x) + L(static_cast<float>(place.x0) - s.x_px);
      const L tile_dy = L::load(TileLayout::lane_y) + L(static_cast<float>(place.y0) - s.y_px);
      const L across(s.across), tilt(s.tilt), down(s.down), log2_opacity(s.log2_opacity);
      const L red(s.color[0]), green(s.color[1]), blue(s.color[2]);
      for (; todo != 0; todo &= todo - 1) {
        const int block = __builtin_ctz(todo);
        L from_middle, log2;
        const L dx = tile_dx + L(static_cast<float>(block % 4 * 4));
        const L dy = tile_dy + L(static_cast<float>(block / 4 * 2));
        const L alpha = block_alpha(dx, dy, across, tilt, down, log2_opacity, from_middle, log2);
        float* t = transmittance + 8 * block;
        const L before = L::load(t);
        const L after = multiply_subtract(alpha, before, before);
        const auto takes = at_least(after, L(SplatLimits::least_transmittance));
        const L weight = zero_unless(takes, alpha * before);
        const L next = where(takes, after, with_sign_set(before));
        next.store(t);
        multiply_add(weight, red, L::load(color[0] + 8 * block)).store(color[0] + 8 * block);
        multiply_add(weight, green, L::load(color[1] + 8 * block)).store(color[1] + 8 * block);
        multiply_add(weight, blue, L::load(color[2] + 8 * block)).store(color[2] + 8 * block);
        if constexpr (kDepth) {
          const float* slope = task.depth_slope + 2 * std::size_t{task.tile_splat[entry]};
          const L nearer =  // a plane's inverse depth is linear in the image
              multiply_subtract(L(slope[0]), dx, multiply_subtract(L(slope[1]), dy, L(1)));
          const L depth = L(s.depth_m) / larger(nearer, L(kLeastNearness));
          multiply_add(weight, depth, L::load(mean + 8 * block)).store(mean + 8 * block);
          const auto falls = takes & at_least(before, L(0.5)) & less(after, L(0.5));
          where(falls, depth, L::load(median + 8 * block)).store(median + 8 * block);
        }
      }
    }
    alive = alive_blocks<L>(transmittance);
  }
  task.tile_done[tile] = entry - begin;

  for (int i = 0; i < 8 * SplatTile::blocks; i += 8) {
    const L left = magnitude(L::load(transmittance + i));
    left.store(transmittance + i);
    for (int k = 0; k < 3; ++k) {
      multiply_add(left, L(task.background[k]), L::load(color[k] + i)).store(color[k] + i);
    }
    if constexpr (kDepth) {
      const L taken = L(1) - left;
      const L value = L::load(mean + i) / taken;
      where(less(L(0), taken), value, L(__builtin_nan(""))).store(mean + i);
    }
  }
  for (int k = 0; k < 3; ++k) store_tile(color[k], task, place, task.color[k]);
  store_tile(transmittance, task, place, task.transmittance);
  if constexpr (kDepth) {
    store_tile(median, task, place, task.depth_m);
    store_tile(mean, task, place, task.mean_depth_m);
  }
}

/// Composites one tile front to back, until every pixel's next Gaussian would leave less than 1e-4
/// of it.
template <class L>
inline void blend_tile(const BlendTask& task, int tile) {
  if (task.depth_m != nullptr) {
    blend_tile_as<L, true>(task, tile);
  } else {
    blend_tile_as<L, false>(task, tile);
  }
}

}  // namespace cousin
