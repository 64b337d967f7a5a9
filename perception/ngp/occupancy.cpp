#include "perception/ngp/occupancy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cousin::ngp {

int cube_of(const NgpVolume& volume, const Eigen::Vector3f& at) {
  float half = 0.5F;
  for (int k = 0; k < volume.cascades; ++k, half *= 2) {
    if (at.cwiseAbs().maxCoeff() < half) return k;
  }
  return volume.cascades;
}

float cell_side(const Occupancy& occupancy, std::size_t cell) {
  const auto cube = static_cast<unsigned>(cell / occupancy.cells_of_cube());
  return static_cast<float>(1U << cube) / static_cast<float>(occupancy.resolution);
}

Eigen::Vector3f cell_middle(const Occupancy& occupancy, std::size_t cell) {
  const auto r = static_cast<std::size_t>(occupancy.resolution);
  const std::size_t in_cube = cell % occupancy.cells_of_cube();
  const Eigen::Vector3f index(static_cast<float>(in_cube % r), static_cast<float>(in_cube / r % r),
                              static_cast<float>(in_cube / (r * r)));
  const float half = 0.5F * static_cast<float>(occupancy.resolution);
  return ((index.array() + 0.5F - half) * cell_side(occupancy, cell)).matrix();
}

void march(const NgpVolume& volume, const Occupancy& occupancy, const MarchConfig& config,
           const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float jitter,
           std::vector<RaySample>& samples) {
  samples.clear();
  const auto reach = static_cast<float>(volume.reach());
  const auto shortest = static_cast<float>(config.shortest), cone = static_cast<float>(config.cone);
  float begin = static_cast<float>(config.near), end = std::numeric_limits<float>::max();
  Eigen::Vector3f inverse;
  for (int k = 0; k < 3; ++k) {
    inverse(k) =
        std::abs(direction(k)) > 1e-12F ? 1 / direction(k) : std::copysign(1e12F, direction(k));
    const float a = (-reach - origin(k)) * inverse(k), b = (reach - origin(k)) * inverse(k);
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  if (!(begin < end)) return;
  const float longest =
      shortest * static_cast<float>(1U << static_cast<unsigned>(volume.cascades - 1)) * 4;
  const auto step_at = [&](float t) { return std::clamp(t * cone, shortest, longest); };
  const auto resolution = static_cast<float>(occupancy.resolution);
  float t = begin + jitter * step_at(begin);
  while (t < end && static_cast<int>(samples.size()) < config.most) {
    const Eigen::Vector3f at = origin + t * direction;
    const float step = step_at(t);
    const int cube = cube_of(volume, at);
    // Far away a step may be less than what a float tells apart.
    const auto goes_on = [&t](float next) { return next > t ? (t = next, true) : false; };
    if (cube >= volume.cascades) {  // on a face, by rounding
      if (!goes_on(t + step)) return;
      continue;
    }
    const float side = static_cast<float>(1U << static_cast<unsigned>(cube)) / resolution;
    std::size_t cell = static_cast<std::size_t>(cube) * occupancy.cells_of_cube();
    std::size_t stride = 1;
    float leave = std::numeric_limits<float>::max();
    for (int k = 0; k < 3; ++k) {
      const float place = at(k) / side + 0.5F * resolution;
      const int index = std::clamp(static_cast<int>(place), 0, occupancy.resolution - 1);
      cell += stride * static_cast<std::size_t>(index);
      stride *= static_cast<std::size_t>(occupancy.resolution);
      const float face =
          (static_cast<float>(index + (direction(k) > 0 ? 1 : 0)) - 0.5F * resolution) * side;
      leave = std::min(leave, (face - at(k)) * inverse(k));
    }
    if (occupancy.filled[cell]) {
      samples.push_back({at, t, step});
      if (!goes_on(t + step)) return;
      continue;
    }
    // Whole steps to the cell's far face.
    if (!goes_on(t + step * std::max(1.0F, std::ceil(leave / step)))) return;
  }
}

}  // namespace cousin::ngp
