#include "perception/splats/splat_growth.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "perception/splats/splat_growth_kinds.h"

namespace cousin {
namespace {

/// Spreads the lowest ten bits to every third.
std::uint32_t spread_bits(std::uint32_t x) {
  x &= 0x3ffU;
  x = (x | x << 16) & 0x030000ffU;
  x = (x | x << 8) & 0x0300f00fU;
  x = (x | x << 4) & 0x030c30c3U;
  return (x | x << 2) & 0x09249249U;
}

std::vector<int> morton_order(const SplatPlanes& values) {
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::max());
  Eigen::Array3f high = -low;
  for (int i = 0; i < values.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], values.at(k, i));
      high[k] = std::max(high[k], values.at(k, i));
    }
  }
  // The index in the lower half: all differ, and equal codes keep their order.
  std::vector<std::uint64_t> keys(static_cast<std::size_t>(values.size()));
  for (int i = 0; i < values.size(); ++i) {
    std::uint32_t bits = 0;
    for (int k = 0; k < 3; ++k) {
      // A quarter of each, so that no difference of finite numbers is infinite.
      const float extent = 0.25F * high[k] - 0.25F * low[k];
      const float share = (0.25F * values.at(k, i) - 0.25F * low[k]) / std::max(extent, 0.25e-30F);
      bits |= spread_bits(static_cast<std::uint32_t>(std::clamp(share, 0.0F, 1.0F) * 1023)) << k;
    }
    keys[static_cast<std::size_t>(i)] = std::uint64_t{bits} << 32 | static_cast<std::uint32_t>(i);
  }
  tbb::parallel_sort(keys);
  std::vector<int> order(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = static_cast<int>(keys[i] & 0xffffffffU);
  return order;
}

bool finite(const SplatPlanes& values, int i) {
  for (int k = 0; k < SplatPlane::count; ++k) {
    if (!std::isfinite(values.at(k, i))) return false;
  }
  return true;
}

void drop_infinite(SplatTrainState& state) {
  std::vector<std::uint8_t> good(static_cast<std::size_t>(state.values.size()));
  tbb::parallel_for(0, state.values.size(), [&](int i) {
    good[static_cast<std::size_t>(i)] = finite(state.values, i) ? 1 : 0;
  });
  std::vector<int> kept;
  for (int i = 0; i < state.values.size(); ++i) {
    if (good[static_cast<std::size_t>(i)] != 0) kept.push_back(i);
  }
  if (static_cast<int>(kept.size()) == state.values.size()) return;
  std::vector<float> sums, counts;
  for (const int i : kept) {
    sums.push_back(state.gradient_sum[static_cast<std::size_t>(i)]);
    counts.push_back(state.gradient_count[static_cast<std::size_t>(i)]);
  }
  gather(state, kept);
  std::copy(sums.begin(), sums.end(), state.gradient_sum.begin());
  std::copy(counts.begin(), counts.end(), state.gradient_count.begin());
}

}  // namespace

void grow_splats(SplatTrainState& state, const SplatTrainConfig& config, double extent_m,
                 double progress, const Rng& rng) {
  drop_infinite(state);
  switch (config.growth) {
    case SplatGrowth::fixed:
      break;
    case SplatGrowth::adaptive:
      grow_adaptive(state, config, extent_m, rng);
      break;
    case SplatGrowth::budgeted:
      grow_budgeted(state, config, progress);
      break;
    case SplatGrowth::mcmc:
      grow_mcmc(state, config, rng);
      break;
  }
  gather(state, morton_order(state.values));
}

void reset_opacity(SplatTrainState& state) {
  const auto limit = static_cast<float>(std::log(0.01 / 0.99));
  for (int i = 0; i < state.values.size(); ++i) {
    float& logit = state.values.at(SplatPlane::opacity, i);
    logit = std::min(logit, limit);
    state.first_moment.at(SplatPlane::opacity, i) = 0;
    state.second_moment.at(SplatPlane::opacity, i) = 0;
  }
}

void add_centre_noise(SplatPlanes& values, double scale, const Rng& rng) {
  for (int i = 0; i < values.size(); ++i) {
    const double opacity = 1 / (1 + std::exp(-double{values.at(SplatPlane::opacity, i)}));
    // 1 for the transparent, falling where opacity is 0.005.
    const double gate = 1 / (1 + std::exp(-100 * ((1 - opacity) - 0.995)));
    if (gate < 1e-4) continue;
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    Eigen::Vector3d noise;
    for (int k = 0; k < 3; ++k) noise[k] = normal(own);
    const Eigen::Matrix3d axes = splat_axes(values, i);
    const Eigen::Vector3d moved = axes * (axes.transpose() * noise) * gate * scale;
    if (!moved.allFinite()) continue;
    for (int k = 0; k < 3; ++k) values.at(k, i) += static_cast<float>(moved[k]);
  }
}

SharedOpacity share_opacity(double opacity, int copies) {
  SharedOpacity shared{};
  const double bounded = std::clamp(opacity, 0.0, 1 - 1e-6);
  shared.opacity = 1 - std::pow(1 - bounded, 1.0 / copies);
  double sum = 0;
  for (int i = 1; i <= copies; ++i) {
    double binomial = 1;
    for (int k = 0; k < i; ++k) {
      const double sign = k % 2 == 0 ? 1 : -1;
      sum += binomial * sign * std::pow(shared.opacity, k + 1) / std::sqrt(k + 1.0);
      binomial = binomial * (i - 1 - k) / (k + 1);
    }
  }
  shared.scale_factor = sum > 0 ? bounded / sum : 1;
  return shared;
}

}  // namespace cousin
