#include "sim/render/value_noise.h"

#include <cmath>

#include "sim/render/sample_points.h"

namespace cousin {
namespace {

float at_node(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t key) {
  const std::uint64_t h = hash64(
      key + hash64(static_cast<std::uint64_t>(x) +
                   hash64(static_cast<std::uint64_t>(y) + hash64(static_cast<std::uint64_t>(z)))));
  return static_cast<float>(h >> 40) * 0x1p-24F;
}

float smooth(float t) { return t * t * (3 - 2 * t); }

float one_octave(const Eigen::Vector3f& p, std::uint64_t key) {
  const Eigen::Vector3f floor(std::floor(p.x()), std::floor(p.y()), std::floor(p.z()));
  const auto x = static_cast<std::int64_t>(floor.x());
  const auto y = static_cast<std::int64_t>(floor.y());
  const auto z = static_cast<std::int64_t>(floor.z());
  const Eigen::Vector3f t = p - floor;
  const float u = smooth(t.x()), v = smooth(t.y()), w = smooth(t.z());
  const auto along_x = [&](std::int64_t j, std::int64_t k) {
    return at_node(x, y + j, z + k, key) * (1 - u) + at_node(x + 1, y + j, z + k, key) * u;
  };
  const float low = along_x(0, 0) * (1 - v) + along_x(1, 0) * v;
  const float high = along_x(0, 1) * (1 - v) + along_x(1, 1) * v;
  return low * (1 - w) + high * w;
}

}  // namespace

float value_noise(const Eigen::Vector3f& point, int octaves, std::uint64_t key) {
  float sum = 0, weight = 0, strength = 1, scale = 1;
  for (int i = 0; i < octaves; ++i, strength *= 0.5F, scale *= 2) {
    // Far beyond any object; keeps the casts to integers defined.
    if (!(point.cwiseAbs().maxCoeff() * scale < 1e9F)) break;
    sum += strength * one_octave(point * scale, key + static_cast<std::uint64_t>(i));
    weight += strength;
  }
  return weight > 0 ? sum / weight : 0;
}

}  // namespace cousin
