#include "perception/cloud/board_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace cousin {
namespace {

constexpr double kInner = 0.75;  ///< an eighth of the side off at each edge
constexpr int kLeastPoints = 5;

double share_below(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Middle of the shortest interval that holds half of the values: where most lie, whatever stands
/// out above.
double mode_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  std::size_t best = 0;
  for (std::size_t i = 0; i + half < values.size(); ++i) {
    if (values[i + half] - values[i] < values[best + half] - values[best]) best = i;
  }
  return 0.5 * (values[best] + values[best + half]);
}

/// Sigma of a normal distribution about `centre` by the values below it: half of them lie within
/// 0.6745 sigmas. NaN of fewer than kLeastPoints values.
double lower_sigma(const std::vector<double>& values, double centre) {
  if (values.size() < std::size_t{kLeastPoints}) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> below;
  for (const double value : values) {
    if (value <= centre) below.push_back(centre - value);
  }
  return below.empty() ? 0 : 1.4826 * share_below(below, 0.5);
}

}  // namespace

BoardNoise board_noise(const Cloud& cloud, double plate_m, double patch_m) {
  if (!(plate_m > 0) || !(patch_m > 0)) {
    throw std::invalid_argument("board noise: a board of " + std::to_string(plate_m) +
                                " m and patches of " + std::to_string(patch_m) +
                                " m; both must be positive");
  }
  const double half_m = 0.5 * kInner * plate_m;
  struct Sum {
    double height_m = 0;
    int points = 0;
  };
  std::map<std::pair<int, int>, Sum> patches;
  std::vector<double> heights_m;
  for (const CloudPoint& point : cloud) {
    const Eigen::Vector3d p = point.position_m.cast<double>();
    if (!p.allFinite() || p.head<2>().cwiseAbs().maxCoeff() > half_m) continue;
    heights_m.push_back(p.z());
    Sum& patch = patches[{static_cast<int>(std::floor(p.x() / patch_m)),
                          static_cast<int>(std::floor(p.y() / patch_m))}];
    patch.height_m += p.z();
    ++patch.points;
  }
  BoardNoise noise;
  if (heights_m.empty()) return noise;
  noise.offset_m = mode_of(heights_m);
  noise.sigma_m = lower_sigma(heights_m, noise.offset_m);
  std::vector<double> means_m;
  for (const auto& [place, patch] : patches) {
    if (patch.points >= kLeastPoints) means_m.push_back(patch.height_m / patch.points);
  }
  noise.patches = static_cast<int>(means_m.size());
  if (!means_m.empty()) noise.patch_sigma_m = lower_sigma(means_m, mode_of(means_m));
  return noise;
}

}  // namespace cousin
