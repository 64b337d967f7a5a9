#include "perception/splats/view_exposures.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace cousin {
namespace {

constexpr int kLeastViews = 2;   // that show a point
constexpr int kRounds = 30;      // of weights
constexpr double kWidest = 0.5;  // Cauchy's scale at first: gains are unknown
constexpr double kNarrowest = 0.02;
constexpr double kOfScatter = 2;     // Cauchy's scale at last
constexpr double kPriorSigma = 0.5;  // of each of vignetting's two numbers

/// sRGB's curve, which goes on above 1.
double light_of(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double encoded(double light) {
  return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// Squared distance from the principal point over the half diagonal's.
double radius2(const Camera& camera, double x_px, double y_px) {
  const double dx = x_px - camera.cx_px, dy = y_px - camera.cy_px;
  const double w = camera.width_px, h = camera.height_px;
  return 4 * (dx * dx + dy * dy) / (w * w + h * h);
}

struct Sighting {
  int view, pixel;  ///< nearest
  double log_light, r2;
};
/// Sightings of one point after another.
struct Sightings {
  std::vector<Sighting> all;
  std::vector<std::size_t> first{0};  ///< of each point, and the end

  std::size_t points() const { return first.size() - 1; }
  std::span<const Sighting> of(std::size_t point) const {
    return std::span(all).subspan(first[point], first[point + 1] - first[point]);
  }
  void append(const Sightings& other) {
    const std::size_t from = all.size();
    all.insert(all.end(), other.all.begin(), other.all.end());
    for (std::size_t p = 1; p < other.first.size(); ++p) first.push_back(from + other.first[p]);
  }
};

/// Looks at surfaces in all views.
class SurfaceLight {
 public:
  SurfaceLight(std::span<const SplatView> views, std::span<const Image<float>> depths_m,
               const ExposureConfig& config)
      : views_(views), depths_m_(depths_m), config_(config) {
    for (const SplatView& view : views) lenses_.emplace_back(view.full.camera);
  }

  /// Of the surfaces that a view has depths of, in the views that have the same; in those of
  /// `unsure` also where these have no depth, so that something may be before the surface.
  Sightings of_view(std::size_t view, const std::vector<std::uint8_t>& unsure) const {
    Sightings found;
    const Image<float>& depth_m = depths_m_[view];
    const Pose world_from_camera = inverse(views_[view].camera_from_world);
    for (int y = 0; y < depth_m.height(); y += config_.stride_px) {
      for (int x = 0; x < depth_m.width(); x += config_.stride_px) {
        const double z_m = depth_m(x, y);
        if (!(z_m > 0) || !std::isfinite(z_m)) continue;
        const auto ray = lenses_[view].unproject({x, y});
        if (!ray) continue;
        const Eigen::Vector3d at_m = world_from_camera * Eigen::Vector3d(*ray * (z_m / ray->z()));
        add_point(at_m, unsure, found);
      }
    }
    return found;
  }

 private:
  void add_point(const Eigen::Vector3d& at_m, const std::vector<std::uint8_t>& unsure,
                 Sightings& found) const {
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (const auto sighting = in_view(v, at_m, unsure[v] != 0)) found.all.push_back(*sighting);
    }
    if (found.all.size() - found.first.back() < kLeastViews)
      found.all.resize(found.first.back());
    else
      found.first.push_back(found.all.size());
  }

  std::optional<Sighting> in_view(std::size_t v, const Eigen::Vector3d& at_m,
                                  bool is_unsure) const {
    const Image<float>& depth_m = depths_m_[v];
    if (depth_m.empty() && !is_unsure) return std::nullopt;
    const Eigen::Vector3d in_camera_m = views_[v].camera_from_world * at_m;
    if (!(in_camera_m.z() > 0)) return std::nullopt;
    const auto pixel = lenses_[v].project(in_camera_m);
    if (!pixel) return std::nullopt;
    const double x0 = std::floor(pixel->x()), y0 = std::floor(pixel->y());
    const SplatViewLevel& level = views_[v].full;
    if (!(x0 >= 0 && y0 >= 0 && x0 + 1 < level.camera.width_px && y0 + 1 < level.camera.height_px))
      return std::nullopt;
    const int x = static_cast<int>(x0), y = static_cast<int>(y0);
    const double right = pixel->x() - x0, down = pixel->y() - y0;
    const double there_m =
        depth_m.empty()
            ? kNaN
            : static_cast<double>(depth_m(x + (right >= 0.5 ? 1 : 0), y + (down >= 0.5 ? 1 : 0)));
    const double most_m = config_.depth_agreement * in_camera_m.z();
    if (!(std::abs(there_m - in_camera_m.z()) <= most_m || (is_unsure && std::isnan(there_m))))
      return std::nullopt;
    double light = 0, sum = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const int i = corner % 2, j = corner / 2;
      const double share = (i ? right : 1 - right) * (j ? down : 1 - down);
      if (!level.weight.empty() && !(level.weight(x + i, y + j) > 0.999F)) return std::nullopt;
      if (!level.behind.empty() && level.behind(x + i, y + j) > 0.001F) return std::nullopt;
      for (const Image<float>& channel : level.color.channel) {
        const double value = channel(x + i, y + j);
        if (!(value <= config_.brightest)) return std::nullopt;
        light += share * light_of(value);
        sum += share * value;
      }
    }
    if (!(sum >= 3 * config_.darkest)) return std::nullopt;
    const int nearest = (y + (down >= 0.5 ? 1 : 0)) * level.camera.width_px + x + (right >= 0.5);
    return Sighting{static_cast<int>(v), nearest, std::log(light),
                    radius2(level.camera, pixel->x(), pixel->y())};
  }

  std::span<const SplatView> views_;
  std::span<const Image<float>> depths_m_;
  ExposureConfig config_;
  std::vector<Lens> lenses_;
};

/// TBB over views; in their order.
Sightings all_sightings(const SurfaceLight& light, const std::vector<std::uint8_t>& unsure) {
  std::vector<Sightings> by_view(unsure.size());
  tbb::parallel_for(std::size_t{0}, unsure.size(),
                    [&](std::size_t v) { by_view[v] = light.of_view(v, unsure); });
  Sightings all;
  for (const Sightings& of_one : by_view) all.append(of_one);
  return all;
}

std::int64_t sightings_of(const Sightings& sightings, std::size_t view) {
  return std::count_if(sightings.all.begin(), sightings.all.end(),
                       [&](const Sighting& s) { return s.view == static_cast<int>(view); });
}

/// Which views are in the largest set that is linked: two views are by as many common points as a
/// view needs sightings, so that no single wrong one says how bright one set is beside another.
std::vector<std::uint8_t> linked_views(const Sightings& sightings, std::size_t views, int least) {
  std::map<std::pair<int, int>, int> common;
  for (std::size_t p = 0; p < sightings.points(); ++p) {
    const std::span<const Sighting> of = sightings.of(p);
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
  if (size[largest] < kLeastViews) return linked;
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
  ExposureFit(const Sightings& sightings, const std::vector<std::uint8_t>& linked)
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
      const std::span<const Sighting> of = sightings_.of(p);
      const auto seen = std::count_if(of.begin(), of.end(), [&](const Sighting& s) {
        return place_[static_cast<std::size_t>(s.view)] >= 0;
      });
      if (seen < kLeastViews) continue;
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
  double without_point(const Sighting& s) const {
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
    const std::span<const Sighting> of = sightings_.of(p);
    for (std::size_t k = 0; k < of.size(); ++k) {
      if (!is_used(sightings_.first[p] + k)) continue;
      const Sighting& s = of[k];
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
      const std::span<const Sighting> of = sightings_.of(p);
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

  const Sightings& sightings_;
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

void check(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument("exposures: " + std::string(name) + " = " + std::to_string(value) +
                              " is not in " + std::to_string(low) + " .. " + std::to_string(high));
}

void check_sizes(std::size_t view, const SplatViewLevel& level, const Image<float>& depth_m) {
  const auto check_size = [&](const char* what, const Image<float>& image) {
    if (image.width() == level.camera.width_px && image.height() == level.camera.height_px) return;
    throw std::invalid_argument("exposures: view " + std::to_string(view) + ": " + what + " is " +
                                std::to_string(image.width()) + " x " +
                                std::to_string(image.height()) + " px, its camera " +
                                std::to_string(level.camera.width_px) + " x " +
                                std::to_string(level.camera.height_px));
  };
  for (const Image<float>& channel : level.color.channel) check_size("a channel", channel);
  if (!level.weight.empty()) check_size("the weight", level.weight);
  if (!level.behind.empty()) check_size("what is behind", level.behind);
  if (!depth_m.empty()) check_size("the depth image", depth_m);
}

template <typename Curve>
void for_colors(ColorPlanes& planes, const Camera& camera, const Curve& curve) {
  const Image<float>& first = planes.channel[0];
  tbb::parallel_for(0, first.height(), [&](int y) {
    for (int x = 0; x < first.width(); ++x) {
      const double r2 = radius2(camera, x, y);
      for (Image<float>& channel : planes.channel)
        channel(x, y) = static_cast<float>(curve(static_cast<double>(channel(x, y)), r2));
    }
  });
}

}  // namespace

double ViewExposures::gain_of(std::size_t view) const {
  return view < log_gain.size() && std::isfinite(log_gain[view]) ? log_gain[view] : 0;
}

void validate(const ExposureConfig& config) {
  check("stride_px", config.stride_px, 1, 1e6);
  check("depth_agreement", config.depth_agreement, 1e-9, 1);
  check("darkest", config.darkest, 1e-3, 1);
  check("brightest", config.brightest, config.darkest, 1);
  check("least_sightings", config.least_sightings, 1, 1e9);
}

ViewExposures estimate_exposures(std::span<const SplatView> views,
                                 std::span<const Image<float>> depths_m,
                                 const ExposureConfig& config) {
  validate(config);
  if (views.size() != depths_m.size())
    throw std::invalid_argument("exposures: " + std::to_string(depths_m.size()) +
                                " depth images for " + std::to_string(views.size()) + " views");
  for (std::size_t v = 0; v < views.size(); ++v) check_sizes(v, views[v].full, depths_m[v]);
  ViewExposures result;
  result.log_gain.assign(views.size(), kNaN);
  result.sigma.assign(views.size(), kNaN);
  if (views.size() < kLeastViews) return result;

  const SurfaceLight light(views, depths_m, config);
  std::vector<std::uint8_t> unsure(views.size(), 0);
  Sightings sightings = all_sightings(light, unsure);
  for (std::size_t v = 0; v < views.size(); ++v)
    unsure[v] = sightings_of(sightings, v) < config.least_sightings ? 1 : 0;
  if (std::count(unsure.begin(), unsure.end(), 1) > 0) sightings = all_sightings(light, unsure);
  const std::vector<std::uint8_t> linked =
      linked_views(sightings, views.size(), config.least_sightings);
  result.status = ExposureStatus::too_few_sightings;
  if (std::count(linked.begin(), linked.end(), 1) < kLeastViews) return result;

  ExposureFit fit(sightings, linked);
  fit.run();
  for (std::size_t v = 0; v < views.size(); ++v) {
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

SplatViewLevel at_mean_exposure(SplatViewLevel level, double log_gain,
                                const Vignetting& vignetting) {
  for_colors(level.color, level.camera, [&](double value, double r2) {
    return encoded(light_of(value) * std::exp(-log_gain - vignetting.log_at(r2)));
  });
  return level;
}

ColorPlanes as_exposed(ColorPlanes image, const Camera& camera, double log_gain,
                       const Vignetting& vignetting) {
  for_colors(image, camera, [&](double value, double r2) {
    const double light =
        light_of(std::max(value, 0.0)) * std::exp(log_gain + vignetting.log_at(r2));
    return std::clamp(encoded(light), 0.0, 1.0);
  });
  return image;
}

}  // namespace cousin
