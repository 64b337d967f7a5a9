#include "sim/geometry/gradient_noise.h"

#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

std::uint64_t mix(std::uint64_t z) {  // finaliser of splitmix64
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// Dot product of a lattice point's gradient (one of twelve cube edges) with the offset from it.
double gradient_dot(std::int64_t ix, std::int64_t iy, std::int64_t iz,
                    const Eigen::Vector3d& offset, std::uint64_t key) {
  const std::uint64_t h =
      mix(key ^ mix(static_cast<std::uint64_t>(ix) * 0x9e3779b97f4a7c15ULL ^
                    mix(static_cast<std::uint64_t>(iy) * 0xc2b2ae3d27d4eb4fULL ^
                        mix(static_cast<std::uint64_t>(iz) + 0x165667b19e3779f9ULL))));
  const double u = (h & 1) != 0 ? 1 : -1;
  const double v = (h & 2) != 0 ? 1 : -1;
  switch ((h >> 8) % 3) {
    case 0:
      return u * offset.x() + v * offset.y();
    case 1:
      return u * offset.y() + v * offset.z();
    default:
      return u * offset.z() + v * offset.x();
  }
}

double fade(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

}  // namespace

double noise3(const Eigen::Vector3d& point, std::uint64_t key) {
  const Eigen::Vector3d cell(std::floor(point.x()), std::floor(point.y()), std::floor(point.z()));
  const Eigen::Vector3d f = point - cell;
  const auto ix = static_cast<std::int64_t>(cell.x());
  const auto iy = static_cast<std::int64_t>(cell.y());
  const auto iz = static_cast<std::int64_t>(cell.z());
  const double wx = fade(f.x());
  const double wy = fade(f.y());
  const double wz = fade(f.z());
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1;
    const int dy = (corner >> 1) & 1;
    const int dz = (corner >> 2) & 1;
    const double weight =
        (dx != 0 ? wx : 1 - wx) * (dy != 0 ? wy : 1 - wy) * (dz != 0 ? wz : 1 - wz);
    sum += weight * gradient_dot(ix + dx, iy + dy, iz + dz, f - Eigen::Vector3d(dx, dy, dz), key);
  }
  return sum;
}

double fractal_noise3(const Eigen::Vector3d& point, int octaves, std::uint64_t key) {
  double sum = 0;
  double amplitude = 1;
  double total = 0;
  double frequency = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * noise3(frequency * point, key + static_cast<std::uint64_t>(i));
    total += amplitude;
    amplitude *= 0.5;
    frequency *= 2;
  }
  return sum / total;
}

double smoothstep(double low, double high, double value) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace cousin
