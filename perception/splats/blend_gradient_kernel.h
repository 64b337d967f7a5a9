#pragma once

#include "perception/splats/blend_kernel.h"

namespace cousin {

/// Gradients of one tile, front to back as it was composited. Behind each Gaussian lies what the
/// finished colour has beyond the sum so far, so no division by transmittances is needed:
/// d loss / d alpha_i = T_i (g . c_i) - (g . (C - C_0..i)) / (1 - alpha_i),
/// where g is d loss / d colour of the pixel. Writes one partial a pair; pairs that the tile's
/// pixels did not get to are zero.
template <class L>
inline void blend_gradient_tile(const BlendGradientTask& task, int tile) {
  const BlendTask& blend = task.blend;
  const TilePlace place = tile_place(blend, tile);
  constexpr int kLanes = 8 * SplatTile::blocks;
  alignas(32) float transmittance[kLanes];
  alignas(32) float gradient[3][kLanes] = {};
  alignas(32) float behind[kLanes] = {};
  alignas(32) float color[kLanes] = {};
  for (int k = 0; k < 3; ++k) {
    load_tile(task.color_gradient[k], blend, place, gradient[k]);
    load_tile(blend.color[k], blend, place, color);
    for (int i = 0; i < kLanes; ++i) behind[i] += gradient[k][i] * color[i];
  }
  std::uint32_t alive = start_tile(place, transmittance);

  const std::uint32_t begin = blend.tile_begin[tile], end = blend.tile_begin[tile + 1];
  const std::uint32_t done = begin + blend.tile_done[tile];
  std::uint32_t entry = begin;
  for (; entry < done; ++entry) {
    if ((entry - begin) % kEntryBatch == 0) alive = alive_blocks<L>(transmittance);
    const std::uint32_t ahead = entry + kAhead < done ? entry + kAhead : entry;
    __builtin_prefetch(blend.projected + blend.tile_splat[ahead]);
    __builtin_prefetch(task.partials + blend.tile_pair[ahead], 1);
    auto* to = reinterpret_cast<float*>(task.partials + blend.tile_pair[entry]);
    std::uint32_t todo = blend.touched[entry] & alive;
    if (todo == 0) {
      for (int k = 0; k < 12; ++k) to[k] = 0;
      continue;
    }
    const ProjectedSplat& s = blend.projected[blend.tile_splat[entry]];
    const L tile_dx = L::load(TileLayout::lane_x) + L(static_cast<float>(place.x0) - s.x_px);
    const L tile_dy = L::load(TileLayout::lane_y) + L(static_cast<float>(place.y0) - s.y_px);
    const L across(s.across), tilt(s.tilt), down(s.down), log2_opacity(s.log2_opacity);
    const L red(s.color[0]), green(s.color[1]), blue(s.color[2]);
    const L zero(0);
    L sums[8] = {zero, zero, zero, zero, zero, zero, zero, zero};
    L sum_red = zero, sum_green = zero, sum_blue = zero;
    for (; todo != 0; todo &= todo - 1) {
      const int block = __builtin_ctz(todo);
      const L dx = tile_dx + L(static_cast<float>(block % 4 * 4));
      const L dy = tile_dy + L(static_cast<float>(block / 4 * 2));
      L from_middle, log2;
      const L alpha = block_alpha(dx, dy, across, tilt, down, log2_opacity, from_middle, log2);
      float* t = transmittance + 8 * block;
      const L before = L::load(t);
      const L after = multiply_subtract(alpha, before, before);
      const auto takes = at_least(after, L(SplatLimits::least_transmittance));
      const L weight = zero_unless(takes, alpha * before);
      const L next = where(takes, after, with_sign_set(before));
      next.store(t);

      const L gr = L::load(gradient[0] + 8 * block);
      const L gg = L::load(gradient[1] + 8 * block);
      const L gb = L::load(gradient[2] + 8 * block);
      sum_red = multiply_add(weight, gr, sum_red);
      sum_green = multiply_add(weight, gg, sum_green);
      sum_blue = multiply_add(weight, gb, sum_blue);
      const L own = weight * multiply_add(gr, red, multiply_add(gg, green, gb * blue));
      const L left = L::load(behind + 8 * block) - own;
      left.store(behind + 8 * block);
      // Alpha that is held at its limit has no gradient, nor has one that is not taken.
      const auto free = takes & less(log2, L(-0.014499569695115089));
      const L g = zero_unless(free, own - left * (alpha / (L(1) - alpha)));
      const L gt = g * from_middle;
      const L gdy = g * dy;
      sums[0] = sums[0] + g;
      sums[1] = sums[1] + gt;
      sums[2] = sums[2] + gdy;
      sums[3] = multiply_add(gt, from_middle, sums[3]);
      sums[4] = multiply_add(gt, dy, sums[4]);
      sums[5] = multiply_add(gdy, dy, sums[5]);
      sums[6] = sums[6] + weight;
    }
    lane_sums(sums).store(to);
    to[8] = lane_sum(sum_red);
    to[9] = lane_sum(sum_green);
    to[10] = lane_sum(sum_blue);
    to[11] = 0;
  }
  for (; entry < end; ++entry) {
    auto* to = reinterpret_cast<float*>(task.partials + blend.tile_pair[entry]);
    for (int k = 0; k < 12; ++k) to[k] = 0;
  }
}

}  // namespace cousin
