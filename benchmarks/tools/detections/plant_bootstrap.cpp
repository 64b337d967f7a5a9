#include "benchmarks/tools/detections/plant_bootstrap.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace cousin {

PlantBootstrap::PlantBootstrap(const std::vector<std::string>& plants, int resamples,
                               std::uint64_t seed)
    : resamples_(resamples), rng_(Rng(seed).fork("detections")) {
  std::map<std::string, std::vector<std::size_t>> places;
  for (std::size_t i = 0; i < plants.size(); ++i) {
    places[plants[i]].push_back(i);
    all_.push_back(i);
  }
  for (auto& [name, pictures] : places) clusters_.push_back(std::move(pictures));
  if (clusters_.size() != 1) return;
  clusters_.clear();
  for (const std::size_t i : all_) clusters_.push_back({i});
}

WithInterval PlantBootstrap::of(const Statistic& statistic, const std::string& name) const {
  constexpr std::size_t kFewest = 20;  ///< values that 2.5 and 97.5 % can be told of
  WithInterval result;
  result.value = statistic(all_);
  if (clusters_.size() < 2 || std::isnan(result.value)) return result;
  Rng rng = rng_.fork(name);
  std::vector<double> values;
  std::vector<std::size_t> drawn;
  for (int r = 0; r < resamples_; ++r) {
    drawn.clear();
    for (std::size_t c = 0; c < clusters_.size(); ++c) {
      const auto& cluster = clusters_[rng() % clusters_.size()];
      drawn.insert(drawn.end(), cluster.begin(), cluster.end());
    }
    const double value = statistic(drawn);
    if (!std::isnan(value)) values.push_back(value);
  }
  if (values.size() < kFewest) return result;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  result.low = at(0.025);
  result.high = at(0.975);
  return result;
}

}  // namespace cousin
