#include "benchmarks/score/trait_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

#include "benchmarks/score/distributions.h"

namespace cousin {
namespace {

/// Sums over a set of specimens, from which every statistic follows. Adding the sums of runs is
/// drawing them together, so a resample costs a few additions. Values are relative to the mean
/// truth: no digits are lost.
constexpr std::size_t kSums = 8;
using Sums = std::array<double, kSums>;
/// Draws whole clusters with replacement and gives each statistic its expanded percentile interval.
template <std::size_t kCount>
std::array<WithInterval, kCount> bootstrap(
    const std::vector<Sums>& clusters,
    const std::function<std::array<double, kCount>(const Sums&)>& statistics, Rng rng,
    const BootstrapConfig& config) {
  Sums all{};
  for (const Sums& cluster : clusters) {
    for (std::size_t i = 0; i < kSums; ++i) all[i] += cluster[i];
  }
  const std::array<double, kCount> values = statistics(all);
  std::array<WithInterval, kCount> result;
  for (std::size_t s = 0; s < kCount; ++s) result[s].value = values[s];
  if (clusters.size() < 2) return result;

  std::array<std::vector<double>, kCount> draws;
  for (int b = 0; b < config.resamples; ++b) {
    Rng stream = rng.fork(static_cast<std::uint64_t>(b));
    Sums sums{};
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      const Sums& cluster = clusters[uniform_index(stream, clusters.size())];
      for (std::size_t k = 0; k < kSums; ++k) sums[k] += cluster[k];
    }
    const std::array<double, kCount> drawn = statistics(sums);
    for (std::size_t s = 0; s < kCount; ++s) {
      if (std::isfinite(drawn[s])) draws[s].push_back(drawn[s]);
    }
  }
  const auto k = static_cast<double>(clusters.size());
  const double tail = normal_cdf(-std::sqrt(k / (k - 1)) * student_t_quantile(0.05, k - 1));
  for (std::size_t s = 0; s < kCount; ++s) {
    if (draws[s].empty() || !std::isfinite(values[s])) continue;
    std::sort(draws[s].begin(), draws[s].end());
    const double last = static_cast<double>(draws[s].size() - 1);
    const auto at = [&](double probability) {
      const double rank = probability * last;
      const auto below = static_cast<std::size_t>(rank);
      const std::size_t above = std::min(below + 1, draws[s].size() - 1);
      return draws[s][below] + (rank - std::floor(rank)) * (draws[s][above] - draws[s][below]);
    };
    result[s].low = at(tail);
    result[s].high = at(1 - tail);
  }
  return result;
}

void require_finite(double value, const char* what, std::size_t index) {
  if (std::isfinite(value)) return;
  throw std::invalid_argument(std::string(what) + " of pair " + std::to_string(index) +
                              " is not finite");
}

/// Sums of each run, in the order of their names and, within a run, of the values, so that the
/// order of the input does not matter; of each specimen if there is one run only.
template <class Pair, class Key, class ToSums>
std::vector<Sums> cluster_sums(std::span<const Pair> pairs, Key key, ToSums to_sums, int& runs) {
  std::map<std::string, std::vector<Pair>> by_run;
  for (const Pair& pair : pairs) by_run[pair.run].push_back(pair);
  runs = static_cast<int>(by_run.size());
  std::vector<Sums> clusters;
  for (auto& [name, members] : by_run) {
    std::sort(members.begin(), members.end(),
              [&](const Pair& a, const Pair& b) { return key(a) < key(b); });
    Sums sums{};
    for (const Pair& pair : members) {
      const Sums one = to_sums(pair);
      if (by_run.size() == 1) clusters.push_back(one);
      for (std::size_t i = 0; i < kSums; ++i) sums[i] += one[i];
    }
    if (by_run.size() > 1) clusters.push_back(sums);
  }
  return clusters;
}

/// rmse, mape, bias, slope, intercept, r2 about the true mean, r2 of the paper, limits of
/// agreement. Sums: n, t, e, tt, te, ee, |e / true|, unused; t is relative to `origin`.
std::array<double, 9> statistics_of(const Sums& s, double origin) {
  const auto [n, t, e, tt, te, ee, relative, unused] = s;
  const double spread_tt = tt - t * t / n;
  const double spread_te = te - t * e / n;
  const double spread_ee = ee - e * e / n;
  // measured = true + e, so sums over the measured values follow from those of t and e.
  const double spread_mm = spread_tt + 2 * spread_te + spread_ee;
  const double bias = e / n;
  const double slope = spread_tt > 0 ? 1 + spread_te / spread_tt : NAN;
  const double mean_truth = origin + t / n;
  const double intercept = mean_truth + bias - slope * mean_truth;
  const double sd = n > 1 ? std::sqrt(std::max(0.0, spread_ee) / (n - 1)) : NAN;
  return {std::sqrt(ee / n),
          relative / n,
          bias,
          slope,
          intercept,
          spread_tt > 0 ? 1 - ee / spread_tt : NAN,
          spread_mm > 0 ? 1 - ee / spread_mm : NAN,
          bias - kSigmas95 * sd,
          bias + kSigmas95 * sd};
}

}  // namespace

TraitStatistics trait_statistics(std::span<const TraitPair> pairs, Rng rng,
                                 const BootstrapConfig& config) {
  TraitStatistics result;
  result.n = static_cast<int>(pairs.size());
  if (pairs.empty()) return result;
  std::vector<double> truths;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    require_finite(pairs[i].truth, "true value", i);
    require_finite(pairs[i].measured, "measured value", i);
    truths.push_back(pairs[i].truth);
  }
  // The middle one, not the mean: a sum would depend on the order of the pairs.
  std::nth_element(truths.begin(), truths.begin() + result.n / 2, truths.end());
  const double origin = truths[truths.size() / 2];

  const auto key = [](const TraitPair& p) { return std::pair(p.truth, p.measured); };
  const auto to_sums = [&](const TraitPair& p) -> Sums {
    const double t = p.truth - origin;
    const double e = p.measured - p.truth;
    return {1, t, e, t * t, t * e, e * e, std::abs(e / p.truth), 0};
  };
  const std::vector<Sums> clusters = cluster_sums<TraitPair>(pairs, key, to_sums, result.runs);
  result.by_run = result.runs > 1;
  const auto all = bootstrap<9>(
      clusters, [&](const Sums& sums) { return statistics_of(sums, origin); }, rng, config);
  result.rmse = all[0];
  result.mape = all[1];
  result.bias = all[2];
  result.slope = all[3];
  result.intercept = all[4];
  result.r2_about_true_mean = all[5];
  result.r2_paper = all[6];
  result.limit_low = all[7];
  result.limit_high = all[8];
  return result;
}

SigmaCoverage sigma_coverage(std::span<const TraitPair> pairs) {
  SigmaCoverage result;
  long long within_68 = 0;
  long long within_95 = 0;
  double sum = 0, squares = 0, widths = 0;
  for (const TraitPair& pair : pairs) {
    if (!(pair.sigma > 0) || !std::isfinite(pair.measured)) continue;
    const double z = (pair.measured - pair.truth) / pair.sigma;
    ++result.n;
    within_68 += std::abs(z) <= 1 ? 1 : 0;
    within_95 += std::abs(z) <= kSigmas95 ? 1 : 0;
    sum += z * z;
    squares += (pair.measured - pair.truth) * (pair.measured - pair.truth);
    widths += 2 * kSigmas95 * pair.sigma;
  }
  const BinomialInterval a = binomial_interval(within_68, result.n);
  const BinomialInterval b = binomial_interval(within_95, result.n);
  result.within_68 = {a.share, a.low, a.high};
  result.within_95 = {b.share, b.low, b.high};
  if (result.n > 0) result.normalised_rms = std::sqrt(sum / result.n);
  if (squares > 0) result.width_over_rmse = widths / result.n / std::sqrt(squares / result.n);
  return result;
}

PairedComparison compare_paired(std::span<const PairedMeasurement> pairs, Rng rng,
                                const BootstrapConfig& config) {
  PairedComparison result;
  result.n = static_cast<int>(pairs.size());
  if (pairs.empty()) return result;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    require_finite(pairs[i].truth, "true value", i);
    require_finite(pairs[i].measured_a, "measurement a", i);
    require_finite(pairs[i].measured_b, "measurement b", i);
  }
  const auto key = [](const PairedMeasurement& p) {
    return std::tuple(p.truth, p.measured_a, p.measured_b);
  };
  const auto to_sums = [](const PairedMeasurement& p) -> Sums {
    const double a = p.measured_a - p.truth;
    const double b = p.measured_b - p.truth;
    const double d = std::abs(a) - std::abs(b);
    return {1, a * a, b * b, d, d * d, 0, 0, 0};
  };
  const std::vector<Sums> clusters =
      cluster_sums<PairedMeasurement>(pairs, key, to_sums, result.runs);
  const auto both = bootstrap<2>(
      clusters,
      [](const Sums& s) -> std::array<double, 2> {
        return {s[2] > 0 ? std::sqrt(s[1] / s[2]) : NAN, s[3] / s[0]};
      },
      rng, config);
  result.rmse_ratio = both[0];
  result.absolute_difference = both[1];

  Sums all{};
  for (const Sums& cluster : clusters) {
    for (std::size_t i = 0; i < kSums; ++i) all[i] += cluster[i];
  }
  const double n = all[0];
  const double variance = n > 1 ? (all[4] - all[3] * all[3] / n) / (n - 1) : NAN;
  if (variance > 0) {
    result.t = all[3] / n / std::sqrt(variance / n);
    result.p_value = student_t_two_sided(result.t, n - 1);
  }
  return result;
}

}  // namespace cousin
