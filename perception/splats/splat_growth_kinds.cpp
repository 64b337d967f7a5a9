#include "perception/splats/splat_growth_kinds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace cousin {
namespace {

/// A Gaussian that parts in two: `first` stays in its place in the list, `second` is its copy.
struct Pair {
  int first, second;
};

/// Two drawn from the one they replace, each smaller by 1.6 [Kerbl et al. 2023, section 5].
void split(SplatPlanes& values, const Pair& pair, const Rng& rng) {
  const Eigen::Matrix3d axes = splat_axes(values, pair.first);
  for (const int i : {pair.first, pair.second}) {
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    Eigen::Vector3d offset;
    for (int k = 0; k < 3; ++k) offset[k] = normal(own);
    offset = axes * offset;
    for (int k = 0; k < 3; ++k) {
      values.at(k, i) += static_cast<float>(offset[k]);
      values.at(SplatPlane::log_scale + k, i) -= std::log(1.6F);
    }
  }
}

/// Two along the longest axis that together keep its mass and variance: half of the mass each, at
/// 0.7 sigma to both sides, 0.714 times as long.
void split_along(SplatPlanes& values, const Pair& pair) {
  const Eigen::Matrix3d axes = splat_axes(values, pair.first);
  int longest = 0;
  for (int k = 1; k < 3; ++k) {
    if (axes.col(k).squaredNorm() > axes.col(longest).squaredNorm()) longest = k;
  }
  const double opacity = splat_opacity(values, pair.first);
  for (const int i : {pair.first, pair.second}) {
    const double side = i == pair.first ? 0.7 : -0.7;
    for (int k = 0; k < 3; ++k) {
      values.at(k, i) += static_cast<float>(side * axes(k, longest));
    }
    values.at(SplatPlane::log_scale + longest, i) += std::log(0.714F);
    set_opacity(values, i, 0.7 * opacity);
  }
}

double mean_gradient(const SplatTrainState& state, int i) {
  const auto n = static_cast<std::size_t>(i);
  return state.gradient_count[n] > 0 ? state.gradient_sum[n] / state.gradient_count[n] : 0;
}

/// Replaces the state's Gaussians by `kept`, then copies of `copied`; returns the pairs that these
/// make. Those of `copied` must be among `kept`.
std::vector<Pair> add_copies(SplatTrainState& state, const std::vector<int>& kept,
                             const std::vector<int>& copied) {
  std::vector<int> place(static_cast<std::size_t>(state.values.size()), -1);
  std::vector<int> source = kept;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    place[static_cast<std::size_t>(kept[i])] = static_cast<int>(i);
  }
  std::vector<Pair> pairs;
  for (const int i : copied) {
    pairs.push_back({place[static_cast<std::size_t>(i)], static_cast<int>(source.size())});
    source.push_back(-1 - i);
  }
  gather(state, source);
  return pairs;
}

void clear_moments(SplatTrainState& state, int i) {
  for (int k = 0; k < SplatPlane::count; ++k) {
    state.first_moment.at(k, i) = 0;
    state.second_moment.at(k, i) = 0;
  }
}

}  // namespace

Eigen::Matrix3d splat_axes(const SplatPlanes& values, int i) {
  Eigen::Quaterniond q(values.at(6, i), values.at(7, i), values.at(8, i), values.at(9, i));
  q = q.norm() > 1e-12 ? q.normalized() : Eigen::Quaterniond::Identity();
  Eigen::Vector3d scale;
  for (int k = 0; k < 3; ++k) {
    scale[k] = std::exp(double{values.at(SplatPlane::log_scale + k, i)});
  }
  return q.toRotationMatrix() * scale.asDiagonal();
}

double splat_opacity(const SplatPlanes& values, int i) {
  return 1 / (1 + std::exp(-double{values.at(SplatPlane::opacity, i)}));
}

void set_opacity(SplatPlanes& values, int i, double opacity) {
  const double bounded = std::clamp(opacity, 1e-6, 1 - 1e-6);
  values.at(SplatPlane::opacity, i) = static_cast<float>(std::log(bounded / (1 - bounded)));
}

double largest_scale_m(const SplatPlanes& values, int i) {
  return std::exp(double{std::max({values.at(3, i), values.at(4, i), values.at(5, i)})});
}

void grow_adaptive(SplatTrainState& state, const SplatTrainConfig& config, double extent_m,
                   const Rng& rng) {
  const SplatPlanes& values = state.values;
  std::vector<int> kept, chosen;
  for (int i = 0; i < values.size(); ++i) {
    if (splat_opacity(values, i) < config.least_opacity) continue;
    kept.push_back(i);
    if (mean_gradient(state, i) >= config.gradient_limit) chosen.push_back(i);
  }
  const std::size_t most = static_cast<std::size_t>(config.most_splats);
  const std::size_t room = most - std::min(most, kept.size());
  if (chosen.size() > room) {  // those that ask for it most; in memory neighbours are side by side
    std::stable_sort(chosen.begin(), chosen.end(), [&](int i, int j) {
      return mean_gradient(state, i) > mean_gradient(state, j);
    });
    chosen.resize(room);
    std::sort(chosen.begin(), chosen.end());
  }
  const std::vector<Pair> pairs = add_copies(state, kept, chosen);
  for (const Pair& pair : pairs) {
    if (largest_scale_m(state.values, pair.first) > config.split_size * extent_m) {
      split(state.values, pair, rng);
      clear_moments(state, pair.first);
    }
  }
  if (config.reset_every == 0 || state.step <= config.reset_every * config.steps) return;
  // After the splits, as the reference: what is too large may have become two that are not.
  std::vector<int> small;
  for (int i = 0; i < state.values.size(); ++i) {
    if (largest_scale_m(state.values, i) <= config.largest_size * extent_m) small.push_back(i);
  }
  gather(state, small);
}

void grow_budgeted(SplatTrainState& state, const SplatTrainConfig& config, double progress) {
  const SplatPlanes& values = state.values;
  std::vector<int> kept;
  std::vector<std::pair<double, int>> ranked;
  for (int i = 0; i < values.size(); ++i) {
    if (splat_opacity(values, i) < config.least_opacity) continue;
    kept.push_back(i);
    ranked.emplace_back(-mean_gradient(state, i), i);
  }
  // Growth is even in the logarithm when its power is 1.
  const double most = config.most_splats;
  const double wanted = progress >= 1
                            ? most
                            : most * std::pow(std::min(1.0, state.started_with / most),
                                              std::pow(1 - progress, config.growth_power));
  const double room = std::max(0.0, wanted - static_cast<double>(kept.size()));
  const auto count = std::min(ranked.size(), static_cast<std::size_t>(room));
  std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count),
                    ranked.end());
  std::vector<int> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    if (ranked[i].first < 0) chosen.push_back(ranked[i].second);
  }
  std::sort(chosen.begin(), chosen.end());
  const std::vector<Pair> pairs = add_copies(state, kept, chosen);
  for (const Pair& pair : pairs) {
    split_along(state.values, pair);
    clear_moments(state, pair.first);
  }
}

void grow_mcmc(SplatTrainState& state, const SplatTrainConfig& config, const Rng& rng) {
  const SplatPlanes& values = state.values;
  const auto size = static_cast<std::size_t>(values.size());
  std::vector<int> alive;
  std::vector<double> cumulated;
  double sum = 0;
  for (int i = 0; i < values.size(); ++i) {
    const double opacity = splat_opacity(values, i);
    if (opacity <= config.least_opacity) continue;
    alive.push_back(i);
    cumulated.push_back(sum += opacity);
  }
  if (alive.empty()) {
    gather(state, {});
    return;
  }
  // The dead move onto living ones drawn by opacity, and 5 % more come to be, up to the budget.
  const std::size_t most = static_cast<std::size_t>(config.most_splats);
  const std::size_t wanted =
      std::max(alive.size(), std::min(most, std::max(size, size + size / 20)));
  Rng draws = rng.fork("places");
  std::vector<int> copied;
  std::vector<int> copies(size, 1);
  for (std::size_t n = alive.size(); n < wanted; ++n) {
    const double at = uniform(draws, 0, sum);
    const auto found = std::upper_bound(cumulated.begin(), cumulated.end(), at);
    const auto index =
        std::min(alive.size() - 1, static_cast<std::size_t>(found - cumulated.begin()));
    copied.push_back(alive[index]);
    ++copies[static_cast<std::size_t>(alive[index])];
  }
  // Those that are shared change before they are copied.
  for (const int i : alive) {
    const int n = copies[static_cast<std::size_t>(i)];
    if (n < 2) continue;
    const SharedOpacity shared = share_opacity(splat_opacity(values, i), std::min(n, 51));
    set_opacity(state.values, i, std::max(shared.opacity, config.least_opacity));
    for (int k = 0; k < 3; ++k) {
      state.values.at(SplatPlane::log_scale + k, i) +=
          static_cast<float>(std::log(shared.scale_factor));
    }
    clear_moments(state, i);
  }
  add_copies(state, alive, copied);
}

}  // namespace cousin
