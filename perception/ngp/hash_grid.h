#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

/// The eight corners about a point of the unit cube, with trilinear weights.
struct GridCorners {
  std::array<std::uint32_t, 8> entry;
  std::array<float, 8> weight;
};
inline GridCorners grid_corners(const GridLevel& level, float x, float y, float z) {
  GridCorners corners;
  const float scale = static_cast<float>(level.resolution);
  // Half a cube off, so that the faces of levels do not coincide.
  const float px = std::clamp(x, 0.0F, 1.0F) * scale + 0.5F;
  const float py = std::clamp(y, 0.0F, 1.0F) * scale + 0.5F;
  const float pz = std::clamp(z, 0.0F, 1.0F) * scale + 0.5F;
  const auto ix = static_cast<std::uint32_t>(px), iy = static_cast<std::uint32_t>(py),
             iz = static_cast<std::uint32_t>(pz);
  const float fx = px - static_cast<float>(ix), fy = py - static_cast<float>(iy),
              fz = pz - static_cast<float>(iz);
  for (unsigned k = 0; k < 8; ++k) {
    const std::uint32_t cx = ix + (k & 1U), cy = iy + (k >> 1U & 1U), cz = iz + (k >> 2U);
    corners.entry[k] = level.hashed
                           ? (cx ^ (cy * 2654435761U) ^ (cz * 805459861U)) & (level.entries - 1)
                           : cx + level.side * (cy + level.side * cz);
    corners.weight[k] = (k & 1U ? fx : 1 - fx) * (k & 2U ? fy : 1 - fy) * (k & 4U ? fz : 1 - fz);
  }
  return corners;
}

/// Features of `count` points of the unit cube: row 2 * level + f of `out` (rows `stride` apart).
template <class T>
void encode(const std::vector<GridLevel>& levels, const T* table, const float* x, const float* y,
            const float* z, int count, T* out, int stride) {
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const GridLevel& level = levels[l];
    const T* numbers = table + level.offset;
    T* first = out + 2 * l * static_cast<std::size_t>(stride);
    T* second = first + stride;
    for (int s = 0; s < count; ++s) {
      const GridCorners corners = grid_corners(level, x[s], y[s], z[s]);
      T a{0}, b{0};
      for (std::size_t k = 0; k < 8; ++k) {
        const T* entry = numbers + std::size_t{kFeatures} * corners.entry[k];
        a += corners.weight[k] * entry[0];
        b += corners.weight[k] * entry[1];
      }
      first[s] = a;
      second[s] = b;
    }
  }
}

/// Adds the derivatives by one level's numbers, given those by its two features.
template <class T>
void add_derivatives(const GridLevel& level, const float* x, const float* y, const float* z,
                     int count, const T* d_first, const T* d_second, T* d_table) {
  T* numbers = d_table + level.offset;
  for (int s = 0; s < count; ++s) {
    if (d_first[s] == T{0} && d_second[s] == T{0}) continue;
    const GridCorners corners = grid_corners(level, x[s], y[s], z[s]);
    for (std::size_t k = 0; k < 8; ++k) {
      T* entry = numbers + std::size_t{kFeatures} * corners.entry[k];
      entry[0] += corners.weight[k] * d_first[s];
      entry[1] += corners.weight[k] * d_second[s];
    }
  }
}

}  // namespace cousin::ngp
