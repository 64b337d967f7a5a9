#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cousin {

/// 64-bit finaliser of splitmix64: hashes of consecutive integers are independent for our purposes.
inline std::uint64_t hash64(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// Two numbers in [0, 1) from one hash.
inline Eigen::Vector2f unit_pair(std::uint64_t hash) {
  return {static_cast<float>(hash >> 40) * 0x1p-24F,
          static_cast<float>((hash >> 16) & 0xFFFFFFU) * 0x1p-24F};
}

/// Point of [0, 1)^2 moved by `shift` on the torus [Cranley & Patterson 1976].
inline Eigen::Vector2f rotated(const Eigen::Vector2f& point, const Eigen::Vector2f& shift) {
  Eigen::Vector2f p = point + shift;
  p.x() -= p.x() >= 1 ? 1.0F : 0.0F;
  p.y() -= p.y() >= 1 ? 1.0F : 0.0F;
  return p;
}

/// Radical inverse in base 2 and the second dimension of Sobol's sequence: a (0, 2) sequence.
inline Eigen::Vector2f sobol_point(std::uint32_t index) {
  std::uint32_t a = 0, b = 0, v = 1U << 31;
  for (std::uint32_t i = index, bit = 1U << 31; i; i >>= 1, bit >>= 1, v ^= v >> 1) {
    if (i & 1U) {
      a ^= bit;
      b ^= v;
    }
  }
  return {static_cast<float>(a >> 8) * 0x1p-24F, static_cast<float>(b >> 8) * 0x1p-24F};
}

/// The first `count` of them in Morton order, so that neighbours in the list are neighbours in the
/// square and packets of rays stay together.
std::vector<Eigen::Vector2f> coherent_points(int count);

/// Square to disk, areas kept [Shirley & Chiu 1997].
Eigen::Vector2f concentric_disk(const Eigen::Vector2f& u);

/// Tangent frame about a unit normal [Duff et al., JCGT 2017]. Columns: tangent, bitangent, normal.
Eigen::Matrix3f frame_about(const Eigen::Vector3f& normal);

}  // namespace cousin
