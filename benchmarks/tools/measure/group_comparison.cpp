#include "benchmarks/tools/measure/group_comparison.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "benchmarks/score/distributions.h"
#include "benchmarks/score/length_units.h"

namespace cousin {
namespace {

struct Values {
  std::string unit;
  std::vector<double> value, own_sigma;
};

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

/// Seeds a group for a difference of `share` of the mean: 2 (z_0.975 + z_0.8)^2 (sd /
/// difference)^2.
int seeds_needed(double sd, double mean, double share) {
  constexpr double kZ80 = 0.8416212335729143;
  const double ratio = sd / (share * std::abs(mean));
  const double count = 2 * (kSigmas95 + kZ80) * (kSigmas95 + kZ80) * ratio * ratio;
  return count < 1e6 ? std::max(2, static_cast<int>(std::ceil(count))) : 0;  // false for NaN
}

GroupTrait group_trait(const std::string& group, const std::string& trait, const Values& values) {
  GroupTrait result{.group = group, .trait = trait, .unit = values.unit};
  result.seeds = static_cast<int>(values.value.size());
  result.mean = mean_of(values.value);
  if (result.seeds < 2) return result;
  double squares = 0, own_squares = 0;
  for (std::size_t i = 0; i < values.value.size(); ++i) {
    squares += (values.value[i] - result.mean) * (values.value[i] - result.mean);
    own_squares += values.own_sigma[i] * values.own_sigma[i];
  }
  result.sd = std::sqrt(squares / (result.seeds - 1));
  result.measurement_sd = std::sqrt(own_squares / result.seeds);
  const double rest = result.sd * result.sd - result.measurement_sd * result.measurement_sd;
  if (std::isfinite(rest)) result.seed_sd = std::sqrt(std::max(0.0, rest));
  result.seeds_for_two_percent = seeds_needed(result.sd, result.mean, 0.02);
  return result;
}

/// Deviation of a difference of means that two different prints give.
double scale_sigma(const GroupTrait& a, const PrintScale& of_a, const GroupTrait& b,
                   const PrintScale& of_b) {
  const bool is_same = of_a.factor == of_b.factor && of_a.sigma == of_b.sigma;
  const int power = length_unit(a.unit).power;
  const double relative_a = power * of_a.sigma / of_a.factor;
  const double relative_b = power * of_b.sigma / of_b.factor;
  if (is_same) return std::abs(a.mean - b.mean) * relative_a;
  return std::hypot(a.mean * relative_a, b.mean * relative_b);
}

GroupDifference difference_of(const GroupTrait& first, const PrintScale& of_first,
                              const GroupTrait& other, const PrintScale& of_other) {
  GroupDifference result{
      .trait = other.trait, .unit = other.unit, .group = other.group, .first = first.group};
  const double difference = other.mean - first.mean;
  result.difference.value = difference;
  result.relative.value = difference / first.mean;
  if (first.seeds < 2 || other.seeds < 2) return result;
  const double va = first.sd * first.sd / first.seeds, vb = other.sd * other.sd / other.seeds;
  const double error = std::sqrt(va + vb);
  // Welch's degrees of freedom; equal values have none.
  const double degrees =
      (va + vb) * (va + vb) / (va * va / (first.seeds - 1) + vb * vb / (other.seeds - 1));
  if (!(error > 0) || !std::isfinite(degrees)) return result;
  const double of_print = scale_sigma(first, of_first, other, of_other);
  const double half = std::hypot(student_t_quantile(0.05, degrees) * error, kSigmas95 * of_print);
  result.difference.low = difference - half;
  result.difference.high = difference + half;
  result.relative.low = result.difference.low / first.mean;
  result.relative.high = result.difference.high / first.mean;
  result.p_value = student_t_two_sided(difference / std::hypot(error, of_print), degrees);
  return result;
}

}  // namespace

GroupComparison compare_groups(const std::vector<MeasuredRow>& rows,
                               const std::vector<std::pair<std::string, PrintScale>>& scales) {
  std::vector<std::string> traits;
  std::map<std::pair<std::string, std::string>, Values> found;  // by trait and group
  for (const MeasuredRow& row : rows) {
    if (row.trait.empty() || !std::isfinite(row.value)) continue;
    if (std::find(traits.begin(), traits.end(), row.trait) == traits.end())
      traits.push_back(row.trait);
    Values& values = found[{row.trait, row.source}];
    values.unit = row.unit;
    values.value.push_back(row.value);
    values.own_sigma.push_back(row.own_sigma);
  }
  GroupComparison result;
  for (const std::string& trait : traits) {
    const GroupTrait* first = nullptr;
    const PrintScale* of_first = nullptr;
    std::vector<GroupTrait> groups;
    groups.reserve(scales.size());  // `first` stays where it is
    for (const auto& [group, scale] : scales) {
      const auto values = found.find({trait, group});
      if (values == found.end()) continue;
      groups.push_back(group_trait(group, trait, values->second));
      if (first == nullptr) {
        first = &groups.back();
        of_first = &scale;
      } else {
        result.differences.push_back(difference_of(*first, *of_first, groups.back(), scale));
      }
    }
    result.traits.insert(result.traits.end(), groups.begin(), groups.end());
  }
  return result;
}

}  // namespace cousin
