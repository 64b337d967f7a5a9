#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace cousin::ngp {

/// Samples of one ray, in order: raw outputs of the networks (colour channels `stride` apart) and
/// the length each stands for.
template <class T>
struct RaySamples {
  int count = 0;
  const T* log_density = nullptr;
  const T* color = nullptr;
  int stride = 0;
  const float* length = nullptr;
};

template <class T>
struct RayColor {
  std::array<T, 3> color{};
  T transmittance{1};
  int used = 0;  ///< samples before transmittance fell below kOpaque
};
inline constexpr double kOpaque = 1e-4;
inline constexpr double kLogLimit = 15;  ///< ln(density) is held within

template <class T>
T density_of(T log_density) {
  return std::exp(std::clamp(log_density, static_cast<T>(-kLogLimit), static_cast<T>(kLogLimit)));
}
template <class T>
T logistic(T x) {
  return 1 / (1 + std::exp(-x));
}

/// Emission and absorption along a ray, front to back [Max, IEEE TVCG 1(2), 1995]: adds samples
/// that lie behind those that `ray` has. `passed(i, weight)` is told of each sample that counts.
template <class T, class Passed>
void composite_on(const RaySamples<T>& samples, RayColor<T>& ray, const Passed& passed) {
  for (int i = 0; i < samples.count && ray.transmittance > static_cast<T>(kOpaque); ++i) {
    const T opacity = 1 - std::exp(-density_of(samples.log_density[i]) * samples.length[i]);
    const T weight = opacity * ray.transmittance;
    for (std::size_t c = 0; c < 3; ++c)
      ray.color[c] += weight * logistic(samples.color[static_cast<int>(c) * samples.stride + i]);
    ray.transmittance *= 1 - opacity;
    ++ray.used;
    passed(i, weight);
  }
}

/// The whole ray over `background`.
template <class T>
RayColor<T> composite(const RaySamples<T>& samples, const std::array<T, 3>& background) {
  RayColor<T> ray;
  composite_on(samples, ray, [](int, T) {});
  for (std::size_t c = 0; c < 3; ++c) ray.color[c] += ray.transmittance * background[c];
  return ray;
}

/// Derivatives of a loss by the raw outputs, given those by the ray's colour; zero for samples that
/// were not used.
template <class T>
void composite_backward(const RaySamples<T>& samples, const RayColor<T>& ray,
                        const std::array<T, 3>& d_color, T* d_log_density, T* d_raw_color) {
  // What lies behind a sample is the ray's colour less what has been passed.
  std::array<T, 3> behind = ray.color;
  T transmittance{1};
  for (int i = 0; i < samples.count; ++i) {
    if (i >= ray.used) {
      d_log_density[i] = T{0};
      for (int c = 0; c < 3; ++c) d_raw_color[c * samples.stride + i] = T{0};
      continue;
    }
    const T density = density_of(samples.log_density[i]);
    const T opacity = 1 - std::exp(-density * samples.length[i]);
    const T weight = opacity * transmittance;
    transmittance *= 1 - opacity;
    T d_depth{0};
    for (std::size_t c = 0; c < 3; ++c) {
      const int at = static_cast<int>(c) * samples.stride + i;
      const T value = logistic(samples.color[at]);
      behind[c] -= weight * value;
      d_depth += d_color[c] * (transmittance * value - behind[c]);
      d_raw_color[at] = d_color[c] * weight * value * (1 - value);
    }
    const bool held = std::abs(samples.log_density[i]) > static_cast<T>(kLogLimit);
    d_log_density[i] = held ? T{0} : d_depth * density * samples.length[i];
  }
}

}  // namespace cousin::ngp
