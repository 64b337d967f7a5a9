#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace cousin {

/// Gradient noise in 3D, smooth to the second derivative, about [-1, 1], zero on the integer
/// lattice [Perlin, "Improving Noise", SIGGRAPH 2002; lattice gradients by hash instead of a
/// table]. One feature a unit.
double noise3(const Eigen::Vector3d& point, std::uint64_t key);

/// Sum of `octaves` of noise3, each of twice the frequency and half the amplitude; about [-1, 1].
double fractal_noise3(const Eigen::Vector3d& point, int octaves, std::uint64_t key);

/// 0 below `low`, 1 above `high`, 3t^2 - 2t^3 between; low < high.
double smoothstep(double low, double high, double value);

}  // namespace cousin
