#include "perception/splats/exposure_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace cousin {
namespace {

constexpr int kRounds = 30;      // of weights
constexpr double kWidest = 0.5;  // Cauchy's scale at first: gains are unknown
constexpr double kNarrowest = 0.02;
constexpr double kOfScatter = 2;     // Cauchy's scale at last
constexpr double kPriorSigma = 0.5;  // of each of vignetting's two numbers

/// Which views are in the largest set that is linked: two views are by as many common points as a
/// view needs sightings, so that no single wrong one says how bright one set is beside another.
std::vector<std::uint8_t> linked_views(const LightSightings& sightings, std::size_t views,
                                       int least) {
  std::map<std::pair<int, int>, int> common;
  for (std::size_t p = 0; p < sightings.points(); ++p) {
    const std::span<const LightSighting> of = sightings.of(p);
    for (std::size_t i = 0; i < of.size(); ++i) {
      for (std::size_t j = i + 1; j < of.size(); ++j) ++common[{of[i].view, of[j].view}];
    }
  }
  std::vector<std::size_t> root(views);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (const auto& [pair, count] : common) {
    if (count >= least)
      root[find(static_cast<std::size_t>(pair.first))] =
          find(static_cast<std::size_t>(pair.second));
  }
  std::vector<int> size(views, 0);
  for (std::size_t v = 0; v < views; ++v) ++size[find(v)];
  const auto largest =
      static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
  std::vector<std::uint8_t> linked(views, 0);
  if (size[largest] < kLeastSharingViews) return linked;
  for (std::size_t v = 0; v < views; ++v) linked[v] = find(v) == largest ? 1 : 0;
  return linked;
}

struct Entry {
  int column;
  double value;
};

/// Least squares of ln of light with each point's own eliminated. Unknowns: a gain a linked view,
/// then the vignetting's two.
class ExposureFit {
 public:
  ExposureFit(const LightSightings& sightings, const std::vector<std::uint8_t>& linked)
      : sightings_(sightings), place_(linked.size(), -1) {
    for (std::size_t v = 0; v < linked.size(); ++v) {
      if (linked[v] != 0) place_[v] = gains_++;
    }
    solution_ = Eigen::VectorXd::Zero(gains_ + 2);
    residual_.resize(sightings.all.size(), 0);
    find_used();
  }

  void run() {
    double scale = kWidest;
    for (int round = 0; round < kRounds; ++round) {
      solve(scale);
      find_residuals(scale);
      scatter_ = robust_scatter();
      scale = std::max({kNarrowest, kOfScatter * scatter(), 0.7 * scale});
    }
  }

  double gain(std::size_t view) const { return place_[view] < 0 ? kNaN : solution_[place_[view]]; }
  double gain_sigma(std::size_t view) const {
    if (place_[view] < 0) return kNaN;
    return scatter_ * std::sqrt(repeats_ * covariance_(place_[view], place_[view]));
  }
  Vignetting vignetting() const { return {solution_[gains_], solution_[gains_ + 1]}; }
  double corner_sigma() const {
    return scatter_ * std::sqrt(repeats_ * covariance_.bottomRightCorner<2, 2>().sum());
  }
  /// Robust, of one sighting about its point.
  double scatter() const { return scatter_; }
  std::int64_t points() const { return points_; }
  std::int64_t sightings() const { return used_; }

 private:
  double robust_scatter() const {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < residual_.size(); ++i) {
      if (is_used(i)) sizes.push_back(std::abs(residual_[i]));
    }
    if (sizes.empty()) return kNaN;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    // A point takes one degree of freedom of its sightings.
    const double freedom = 1 - static_cast<double>(points_) / static_cast<double>(sizes.size());
    return 1.4826 * *middle / std::sqrt(std::max(freedom, 0.1));
  }
  bool is_used(std::size_t i) const { return used_by_[i] != 0; }
  /// Of views that are linked, and not alone in showing their point.
  void find_used() {
    used_by_.resize(sightings_.all.size(), 0);
    std::vector<std::pair<int, int>> pixels;
    for (std::size_t p = 0; p < sightings_.points(); ++p) {
      const std::span<const LightSighting> of = sightings_.of(p);
      const auto seen = std::count_if(of.begin(), of.end(), [&](const LightSighting& s) {
        return place_[static_cast<std::size_t>(s.view)] >= 0;
      });
      if (seen < kLeastSharingViews) continue;
      ++points_;
      used_ += seen;
      for (std::size_t k = 0; k < of.size(); ++k) {
        if (place_[static_cast<std::size_t>(of[k].view)] < 0) continue;
        used_by_[sightings_.first[p] + k] = 1;
        pixels.emplace_back(of[k].view, of[k].pixel);
      }
    }
    std::sort(pixels.begin(), pixels.end());
    const auto distinct = std::unique(pixels.begin(), pixels.end()) - pixels.begin();
    if (distinct > 0) repeats_ = static_cast<double>(used_) / static_cast<double>(distinct);
  }
  double without_point(const LightSighting& s) const {
    return s.log_light - solution_[place_[static_cast<std::size_t>(s.view)]] -
           vignetting().log_at(s.r2);
  }
  double weight(std::size_t i, double scale) const {
    const double share = residual_[i] / scale;
    return 1 / (1 + share * share);
  }

  void solve(double scale) {
    const int size = gains_ + 2;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    for (std::size_t p = 0; p < sightings_.points(); ++p) add_point(p, scale, normal, right);
    // Sum of gains zero, about as heavy as the rest; and surfaces in the middle of the images say
    // little of the corners.
    normal.topLeftCorner(gains_, gains_).array() += normal.trace() / size / gains_;
    const double noise = std::max(kNarrowest, scatter_);
    normal.bottomRightCorner<2, 2>().diagonal().array() +=
        repeats_ * noise * noise / (kPriorSigma * kPriorSigma);
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal);
    solution_ = factor.solve(right);
    covariance_ = factor.solve(Eigen::MatrixXd::Identity(size, size));
    // What holds the sum is known of no view.
    covariance_.topLeftCorner(gains_, gains_).array() -=
        covariance_.topLeftCorner(gains_, gains_).sum() / (gains_ * gains_);
  }

  /// Normal equations of a point's sightings less what its own light takes: entries are few, so
  /// they are added one by one.
  void add_point(std::size_t p, double scale, Eigen::MatrixXd& normal, Eigen::VectorXd& right) {
    double weights = 0, sum = 0, sum_r2 = 0, sum_r4 = 0;
    std::vector<Entry> row;  // sum of weights times unknowns' factors
    const std::span<const LightSighting> of = sightings_.of(p);
    for (std::size_t k = 0; k < of.size(); ++k) {
      if (!is_used(sightings_.first[p] + k)) continue;
      const LightSighting& s = of[k];
      const int g = place_[static_cast<std::size_t>(s.view)];
      const double w = weight(sightings_.first[p] + k, scale), r4 = s.r2 * s.r2;
      const int a = gains_, b = gains_ + 1;
      weights += w;
      sum += w * s.log_light;
      sum_r2 += w * s.r2;
      sum_r4 += w * r4;
      row.push_back({g, w});
      normal(g, g) += w;
      normal(g, a) += w * s.r2;
      normal(a, g) += w * s.r2;
      normal(g, b) += w * r4;
      normal(b, g) += w * r4;
      normal(a, a) += w * s.r2 * s.r2;
      normal(a, b) += w * s.r2 * r4;
      normal(b, a) += w * s.r2 * r4;
      normal(b, b) += w * r4 * r4;
      right[g] += w * s.log_light;
      right[a] += w * s.r2 * s.log_light;
      right[b] += w * r4 * s.log_light;
    }
    if (row.empty()) return;
    row.push_back({gains_, sum_r2});
    row.push_back({gains_ + 1, sum_r4});
    for (const Entry& i : row) {
      right[i.column] -= i.value * sum / weights;
      for (const Entry& j : row) normal(i.column, j.column) -= i.value * j.value / weights;
    }
  }

  void find_residuals(double scale) {
    for (std::size_t p = 0; p < sightings_.points(); ++p) {
      const std::span<const LightSighting> of = sightings_.of(p);
      double weights = 0, sum = 0;
      for (std::size_t k = 0; k < of.size(); ++k) {
        if (!is_used(sightings_.first[p] + k)) continue;
        const double w = weight(sightings_.first[p] + k, scale);
        weights += w;
        sum += w * without_point(of[k]);
      }
      for (std::size_t k = 0; k < of.size(); ++k) {
        if (is_used(sightings_.first[p] + k))
          residual_[sightings_.first[p] + k] = without_point(of[k]) - sum / weights;
      }
    }
  }

  const LightSightings& sightings_;
  std::vector<int> place_;  ///< of a view's gain; -1 = not linked
  int gains_ = 0;
  Eigen::VectorXd solution_;
  Eigen::MatrixXd covariance_;
  std::vector<double> residual_;
  std::vector<std::uint8_t> used_by_;  ///< whether a sighting counts
  double scatter_ = kWidest;
  /// A patch is followed from each view that has depths of it: so many sightings are of one pixel.
  double repeats_ = 1;
  std::int64_t points_ = 0, used_ = 0;
};

}  // namespace

ViewExposures fit_exposures(const LightSightings& sightings, std::size_t views,
                            int least_sightings) {
  ViewExposures result;
  result.status = ExposureStatus::too_few_sightings;
  result.log_gain.assign(views, kNaN);
  result.sigma.assign(views, kNaN);
  const std::vector<std::uint8_t> linked = linked_views(sightings, views, least_sightings);
  if (std::count(linked.begin(), linked.end(), 1) < kLeastSharingViews) return result;

  ExposureFit fit(sightings, linked);
  fit.run();
  for (std::size_t v = 0; v < views; ++v) {
    result.log_gain[v] = fit.gain(v);
    result.sigma[v] = fit.gain_sigma(v);
  }
  result.vignetting = fit.vignetting();
  result.vignetting_sigma = fit.corner_sigma();
  result.scatter = fit.scatter();
  result.points = fit.points();
  result.sightings = fit.sightings();
  result.status = ExposureStatus::ok;
  return result;
}

}  // namespace cousin
