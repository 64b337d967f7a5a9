#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "sim/render/sample_points.h"

namespace cousin {

/// Points of one sample of one pixel, two dimensions at a time: a (0, 2) sequence, its order and
/// both axes scrambled by Owen's method as a hash [Laine & Karras 2011; Burley, JCGT 2020;
/// constants by Vegdahl 2021]. Any first 2^k samples of a pixel are stratified in every pair.
/// Private to sim/render.
struct PathSampler {
  std::uint64_t pixel_key = 0;
  std::uint32_t sample = 0;

  Eigen::Vector2f pair(std::uint32_t dimension) const {
    const std::uint64_t key = hash64(pixel_key + dimension);
    const std::uint64_t axes = hash64(key);
    const std::uint32_t index =
        reversed(scrambled(reversed(sample), static_cast<std::uint32_t>(key)));
    const std::uint32_t a = reversed(scrambled(index, static_cast<std::uint32_t>(axes)));
    const std::uint32_t b =
        reversed(scrambled(second_axis(index), static_cast<std::uint32_t>(axes >> 32)));
    return {static_cast<float>(a >> 8) * 0x1p-24F, static_cast<float>(b >> 8) * 0x1p-24F};
  }

 private:
  static std::uint32_t reversed(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x >> 8) & 0x00FF00FFU) | ((x & 0x00FF00FFU) << 8);
    x = ((x >> 4) & 0x0F0F0F0FU) | ((x & 0x0F0F0F0FU) << 4);
    x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
    return ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
  }
  /// Owen's scrambling of reversed bits: each bit flips by a hash of the lower ones.
  static std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeaU;
    x += seed;
    x *= (seed >> 16) | 1U;
    x ^= x * 0x05526c56U;
    x ^= x * 0x53a22864U;
    return x;
  }
  /// Pascal's matrix modulo 2 on the bits of the index: reversed, it is the second dimension of
  /// Sobol's sequence.
  static std::uint32_t second_axis(std::uint32_t x) {
    x ^= (x >> 1) & 0x55555555U;
    x ^= (x >> 2) & 0x33333333U;
    x ^= (x >> 4) & 0x0F0F0F0FU;
    x ^= (x >> 8) & 0x00FF00FFU;
    x ^= (x >> 16) & 0x0000FFFFU;
    return x;
  }
};

}  // namespace cousin
