#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cousin {

/// Fractal value noise in [0, 1] at a point in units of the largest feature: random values at whole
/// numbers, smooth between, each octave half the size and half the strength. Differs with `key`.
float value_noise(const Eigen::Vector3f& point, int octaves, std::uint64_t key = 0);

}  // namespace cousin
