#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace cousin::ngp {

inline constexpr int kFeatures = 2;  ///< numbers a corner

/// One grid of the encoding: corners of cubes of 1 / resolution, each with kFeatures numbers in a
/// table; grids with more corners than the table share entries by a hash.
struct GridLevel {
  double resolution = 16;  ///< cubes along a side of the unit cube
  std::uint32_t side = 0;  ///< corners along a side
  bool hashed = false;
  std::uint32_t entries = 0;  ///< a power of two where hashed
  std::size_t offset = 0;     ///< of the first number, in numbers
};

struct HashGridConfig {
  int levels = 16;
  int log2_table = 17;  ///< largest number of entries of a level
  int coarsest = 16;    ///< cubes along a side
  int finest = 1024;
};

/// Levels of growing resolution in geometric progression [Müller et al., ACM TOG 41(4), 2022,
/// eqs. 2-4].
std::vector<GridLevel> grid_levels(const HashGridConfig& config);
/// Numbers of all levels' tables together.
std::size_t table_size(const std::vector<GridLevel>& levels);

inline constexpr int kBlock = 8;  ///< points whose corners are found together

/// The eight corners about each point of a block, with trilinear weights: corner 4 z + 2 y + x.
struct CornerBlock {
  alignas(32) std::uint32_t entry[8][kBlock];
  alignas(32) float weight[8][kBlock];
};
/// @param x, y, z  of `count` points of the unit cube, at most kBlock; the others' corners are
/// those of the cube's corner. What lies outside, or is not a number, counts as on its surface.
inline void find_corners(const GridLevel& level, const float* x, const float* y, const float* z,
                         int count, CornerBlock& out) {
  typedef std::uint32_t Entries __attribute__((vector_size(4 * kBlock)));
  typedef std::int32_t Integers __attribute__((vector_size(4 * kBlock)));
  typedef float Numbers __attribute__((vector_size(4 * kBlock)));
  const float scale = static_cast<float>(level.resolution);
  Entries cell[3];
  Numbers weight[3][2];
  const float* const rows[3] = {x, y, z};
  for (int axis = 0; axis < 3; ++axis) {
    Numbers at{};
    if (count == kBlock)
      std::memcpy(&at, rows[axis], sizeof at);
    else
      std::memcpy(&at, rows[axis], sizeof(float) * static_cast<std::size_t>(count));
    at = at > 0.0F ? at : Numbers{};
    at = at < 1.0F ? at : Numbers{} + 1.0F;
    // Half a cube off, so that the faces of levels do not coincide.
    at = at * scale + 0.5F;
    const Integers below = __builtin_convertvector(at, Integers);
    weight[axis][1] = at - __builtin_convertvector(below, Numbers);
    weight[axis][0] = 1 - weight[axis][1];
    cell[axis] = __builtin_convertvector(below, Entries);
  }
  const auto keep = [&](unsigned k, const Entries& entries) {
    std::memcpy(out.entry[k], &entries, sizeof entries);
    const Numbers product = weight[0][k & 1U] * weight[1][k >> 1U & 1U] * weight[2][k >> 2U];
    std::memcpy(out.weight[k], &product, sizeof product);
  };
  if (level.hashed) {
    constexpr std::uint32_t kY = 2654435761U, kZ = 805459861U;
    const Entries hx[2] = {cell[0], cell[0] + 1};
    const Entries hy[2] = {cell[1] * kY, cell[1] * kY + kY};
    const Entries hz[2] = {cell[2] * kZ, cell[2] * kZ + kZ};
    for (unsigned k = 0; k < 8; ++k)
      keep(k, (hx[k & 1U] ^ hy[k >> 1U & 1U] ^ hz[k >> 2U]) & (level.entries - 1));
  } else {
    const Entries first = cell[0] + level.side * (cell[1] + level.side * cell[2]);
    for (unsigned k = 0; k < 8; ++k)
      keep(k, first + ((k & 1U) + level.side * ((k >> 1U & 1U) + level.side * (k >> 2U))));
  }
}

/// The numbers of one corner, to be taken together.
template <class T>
struct CornerNumbers {
  typedef T Pair __attribute__((vector_size(kFeatures * sizeof(T))));
  static Pair load(const T* at) { return Pair{at[0], at[1]}; }
  static void store(T* at, Pair pair) {
    at[0] = pair[0];
    at[1] = pair[1];
  }
};

/// Calls use(point, block, place in the block) in order. The numbers of a block's corners are
/// fetched while the block before is used: most of a level's table is not in the nearest cache.
template <class T, class Use>
void for_corners(const GridLevel& level, const float* x, const float* y, const float* z, int count,
                 const T* numbers, const Use& use) {
  CornerBlock blocks[2];
  const auto begin = [&](int first) {
    CornerBlock& block = blocks[first / kBlock % 2];
    find_corners(level, x + first, y + first, z + first, std::min(kBlock, count - first), block);
    for (const auto& entries : block.entry) {
      for (const std::uint32_t entry : entries)
        __builtin_prefetch(numbers + std::size_t{kFeatures} * entry);
    }
  };
  if (count > 0) begin(0);
  for (int first = 0; first < count; first += kBlock) {
    if (first + kBlock < count) begin(first + kBlock);
    for (int i = 0; i < std::min(kBlock, count - first); ++i)
      use(first + i, blocks[first / kBlock % 2], i);
  }
}

/// Two features of one level for `count` points of the unit cube.
template <class T>
void encode_level(const GridLevel& level, const T* table, const float* x, const float* y,
                  const float* z, int count, T* first, T* second) {
  using Numbers = CornerNumbers<T>;
  const T* numbers = table + level.offset;
  for_corners(level, x, y, z, count, numbers, [&](int s, const CornerBlock& block, int i) {
    typename Numbers::Pair sum{};
    for (std::size_t k = 0; k < 8; ++k)
      sum += static_cast<T>(block.weight[k][i]) *
             Numbers::load(numbers + std::size_t{kFeatures} * block.entry[k][i]);
    first[s] = sum[0];
    second[s] = sum[1];
  });
}

/// Adds the derivatives by one level's numbers, given those by its two features.
template <class T>
void add_derivatives(const GridLevel& level, const float* x, const float* y, const float* z,
                     int count, const T* d_first, const T* d_second, T* d_table) {
  using Numbers = CornerNumbers<T>;
  T* numbers = d_table + level.offset;
  for_corners(level, x, y, z, count, numbers, [&](int s, const CornerBlock& block, int i) {
    if (d_first[s] == T{0} && d_second[s] == T{0}) return;
    const typename Numbers::Pair derivatives{d_first[s], d_second[s]};
    for (std::size_t k = 0; k < 8; ++k) {
      T* entry = numbers + std::size_t{kFeatures} * block.entry[k][i];
      Numbers::store(entry,
                     Numbers::load(entry) + static_cast<T>(block.weight[k][i]) * derivatives);
    }
  });
}

}  // namespace cousin::ngp
