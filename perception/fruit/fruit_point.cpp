#include "perception/fruit/fruit_point.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "sim/config/limits.h"

namespace cousin {
namespace {

/// The pixel under the middle of a box: of an even number of pixels the one before it.
Eigen::Vector2i middle_px(const DetectedBox& box) {
  const Eigen::Vector2d middle = 0.5 * (box.low_px + box.high_px);
  return {static_cast<int>(std::floor(middle.x())), static_cast<int>(std::floor(middle.y()))};
}

struct DepthSample {
  Eigen::Vector2d from_middle_px;
  double depth_m = 0, sigma_m = kNaN;
};

/// Whether a pixel counts for an object: all do where only its box is known.
bool is_in_mask(const DetectedBox& box, int x, int y) {
  if (box.mask.empty()) return true;
  const int mx = x - box.mask_at_px.x(), my = y - box.mask_at_px.y();
  return box.mask.contains(mx, my) && box.mask(mx, my) != 0;
}

/// The middle, or where the mask shows something else there, the nearest pixel of the object.
Eigen::Vector2i seen_middle_px(const DetectedBox& box) {
  const Eigen::Vector2i middle = middle_px(box);
  if (is_in_mask(box, middle.x(), middle.y())) return middle;
  Eigen::Vector2i nearest = middle;
  int least = std::numeric_limits<int>::max();
  for (int y = 0; y < box.mask.height(); ++y) {
    for (int x = 0; x < box.mask.width(); ++x) {
      const Eigen::Vector2i at = box.mask_at_px + Eigen::Vector2i(x, y);
      const int away = (at - middle).squaredNorm();
      if (box.mask(x, y) == 0 || away >= least) continue;
      least = away;
      nearest = at;
    }
  }
  return nearest;
}

/// Pixels from `low` to `high`. A box may be far larger than its image.
struct PixelRange {
  Eigen::Vector2i low, high;
};
PixelRange inside(const Image<float>& image, const Eigen::Vector2i& low,
                  const Eigen::Vector2i& high) {
  return {low.cwiseMax(0), high.cwiseMin(Eigen::Vector2i(image.width() - 1, image.height() - 1))};
}

/// Depths about a pixel, and how many pixels there could have one.
struct DepthWindow {
  std::vector<DepthSample> samples;
  int pixels = 0;
};
DepthWindow window_of(const FrameDepth& depth, const DetectedBox& box,
                      const Eigen::Vector2i& middle, int side_px, bool by_mask) {
  DepthWindow window;
  std::vector<DepthSample>& samples = window.samples;
  const int half = side_px / 2;
  const PixelRange range = inside(depth.depth_m, middle.array() - half, middle.array() + half);
  for (int y = range.low.y(); y <= range.high.y(); ++y) {
    for (int x = range.low.x(); x <= range.high.x(); ++x) {
      if (by_mask && !is_in_mask(box, x, y)) continue;
      ++window.pixels;
      if (std::isnan(depth.depth_m(x, y))) continue;
      DepthSample sample{Eigen::Vector2d(x - middle.x(), y - middle.y()),
                         static_cast<double>(depth.depth_m(x, y)), kNaN};
      if (!depth.sigma_m.empty()) sample.sigma_m = static_cast<double>(depth.sigma_m(x, y));
      samples.push_back(sample);
    }
  }
  return window;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

FruitPoint none(const std::string& why) {
  FruitPoint point;
  point.why_none = why;
  return point;
}

/// A patch's depth under the middle, with the sigma that its spread gives.
struct Patch {
  double depth_m = kNaN, sigma_m = kNaN;
  double kept = 0;  ///< sum of the weights
};

Patch fit_patch(const std::vector<DepthSample>& samples, const FruitPointConfig& config) {
  constexpr int kRounds = 12;
  constexpr double kTukey = 4.685;        // 95 % as sharp as least squares where errors are normal
  constexpr double kLeastScale_m = 1e-4;  // steps of the sensor's own numbers
  const auto n = static_cast<Eigen::Index>(samples.size());
  double half_px = 1;
  for (const DepthSample& s : samples)
    half_px = std::max(half_px, s.from_middle_px.cwiseAbs().maxCoeff());
  Eigen::MatrixXd terms(n, 4);
  Eigen::VectorXd depths(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d at = samples[static_cast<std::size_t>(i)].from_middle_px / half_px;
    terms.row(i) << 1, at.x(), at.y(), at.squaredNorm();
    depths(i) = samples[static_cast<std::size_t>(i)].depth_m;
  }
  Eigen::Vector4d patch(median({depths.data(), depths.data() + n}), 0, 0, 0);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(n);
  double scale_m = kLeastScale_m;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Identity();
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd off = depths - terms * patch;
    const Eigen::VectorXd away = off.cwiseAbs();
    scale_m = std::max(kLeastScale_m, 1.4826 * median({away.data(), away.data() + n}));
    for (Eigen::Index i = 0; i < n; ++i) {
      const double r = off(i) / (kTukey * scale_m);
      weights(i) = std::abs(r) < 1 ? (1 - r * r) * (1 - r * r) : 0;
    }
    normal = terms.transpose() * weights.asDiagonal() * terms;
    normal.diagonal().array() += 1e-9 * normal.trace();  // a single column of depths is no patch
    patch = normal.ldlt().solve(terms.transpose() * weights.asDiagonal() * depths);
  }
  Patch result;
  result.depth_m = patch(0);
  result.kept = weights.sum();
  double sigma_m = scale_m;
  for (const DepthSample& s : samples) {
    if (std::isfinite(s.sigma_m)) sigma_m = std::max(sigma_m, s.sigma_m);
  }
  // Neighbours err alike: of as many depths as there are, only so many tell something of their own.
  const double alike = std::max(1.0, config.correlated_px * config.correlated_px);
  const double variance = normal.inverse()(0, 0) * sigma_m * sigma_m * alike;
  result.sigma_m = std::min(std::sqrt(std::max(0.0, variance)), 2 * sigma_m);
  return result;
}

}  // namespace

Fields fields(FruitPointConfig& c) {
  return {
      {"paper_window_px", &c.paper_window_px,
       "method paper: side of the window where the middle of a box has no depth", 1, 101},
      {"paper_outlier_m", &c.paper_outlier_m,
       "method paper: depths farther from the window's median are left out", 1e-4, 10},
      {"window_share", &c.window_share, "side of the window of depths over the box's shorter side",
       0.01, 1},
      {"least_window_px", &c.least_window_px, "and at least this", 3, 101},
      {"least_depths", &c.least_depths, "fewer depths in the window are no surface", 5, 10000},
      {"least_share", &c.least_share, "and so is less of its pixels with depth", 0, 1},
      {"ring_px", &c.ring_px, "width of the ring about a mask that neighbours are looked for in", 1,
       100},
      {"beside_m", &c.beside_m, "a neighbour is as deep within this", 0, 1},
      {"most_beside", &c.most_beside, "share of the ring that may be as deep; 1: all of it", 0, 1},
      {"correlated_px", &c.correlated_px, "depths within this err alike", 1, 100},
      {"unit_sigmas", &c.unit_sigmas,
       "sigma of what all depths of a unit are off, over the sigma of one", 0, 100},
      {"lens_sigma_px", &c.lens_sigma_px, "sigma of what the reported lens is off", 0, 100}};
}

void validate(const FruitPointConfig& config) {
  FruitPointConfig copy = config;
  check_limits(fields(copy), "point");
}

FruitPoint point_by_paper(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                          const FruitPointConfig& config) {
  if (depth.depth_m.empty()) return none("the frame has no depth");
  const Eigen::Vector2i at = middle_px(box);
  double z_m = kNaN;
  if (depth.depth_m.contains(at.x(), at.y()) && !std::isnan(depth.depth_m(at.x(), at.y()))) {
    z_m = static_cast<double>(depth.depth_m(at.x(), at.y()));
  } else {
    std::vector<double> found;
    const DepthWindow window = window_of(depth, box, at, config.paper_window_px, false);
    for (const DepthSample& s : window.samples) found.push_back(s.depth_m);
    if (found.empty()) return none("no depth in the window");
    const double middle_m = median(found);
    std::erase_if(found, [&](double z) { return std::abs(z - middle_m) > config.paper_outlier_m; });
    z_m = 0;
    for (const double z : found) z_m += z / static_cast<double>(found.size());
  }
  FruitPoint point;
  point.point_m = {(at.x() - camera.cx_px) * z_m / camera.fx_px,
                   (at.y() - camera.cy_px) * z_m / camera.fy_px, z_m};
  return point;
}

namespace {

bool is_of_another(std::span<const DetectedBox> others, const DetectedBox& box, int x, int y) {
  return std::any_of(others.begin(), others.end(), [&](const DetectedBox& other) {
    if (other.id == box.id) return false;
    if (!other.mask.empty()) return is_in_mask(other, x, y);
    return x > other.low_px.x() && x < other.high_px.x() && y > other.low_px.y() &&
           y < other.high_px.y();
  });
}

/// Whether what is beside the object, and of no other, is as deep as the patch.
bool has_like_neighbour(const FrameDepth& depth, const DetectedBox& box,
                        std::span<const DetectedBox> others, double patch_m,
                        const FruitPointConfig& config) {
  if (box.mask.empty()) return false;
  const int ring = config.ring_px;
  const auto near_mask = [&](int x, int y) {
    for (const auto& [dx, dy] : {std::pair(ring, 0), {-ring, 0}, {0, ring}, {0, -ring}}) {
      if (is_in_mask(box, x + dx, y + dy)) return true;
    }
    return false;
  };
  int beside = 0, like = 0;
  const PixelRange range = inside(depth.depth_m, box.low_px.array().ceil().cast<int>() - ring,
                                  box.high_px.array().floor().cast<int>() + ring);
  for (int y = range.low.y(); y <= range.high.y(); ++y) {
    for (int x = range.low.x(); x <= range.high.x(); ++x) {
      if (std::isnan(depth.depth_m(x, y))) continue;
      if (is_in_mask(box, x, y) || !near_mask(x, y) || is_of_another(others, box, x, y)) continue;
      ++beside;
      if (std::abs(static_cast<double>(depth.depth_m(x, y)) - patch_m) < config.beside_m) ++like;
    }
  }
  return like > config.most_beside * beside;
}

}  // namespace

FruitPoint point_by_patch(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                          std::span<const DetectedBox> others, const FruitPointConfig& config) {
  if (depth.depth_m.empty()) return none("the frame has no depth");
  const Eigen::Vector2d size_px = box.high_px - box.low_px;
  const int side_px =
      std::max(config.least_window_px,
               static_cast<int>(std::lround(config.window_share * size_px.minCoeff())));
  const Eigen::Vector2i at = seen_middle_px(box);
  const DepthWindow window = window_of(depth, box, at, side_px, true);
  const std::vector<DepthSample>& samples = window.samples;
  const auto found = static_cast<double>(samples.size());
  // A sensor that misses most of a surface matches what is beside it there.
  if (found < config.least_depths || found < config.least_share * window.pixels)
    return none(std::to_string(samples.size()) + " of " + std::to_string(window.pixels) +
                " pixels about its middle have depth");
  const Patch patch = fit_patch(samples, config);
  if (!(patch.depth_m > 0) || patch.kept < 0.5 * config.least_depths)
    return none("the window's depths are of no one surface");
  if (has_like_neighbour(depth, box, others, patch.depth_m, config))
    return none("what is beside it is as deep: the depth may be a neighbour's");
  const auto ray = unproject(camera, at.cast<double>());
  if (!ray || !(ray->z() > 0)) return none("the lens shows no ray there");
  const Eigen::Vector3d way = *ray / ray->z();
  double unit_m = 0;
  for (const DepthSample& s : samples) {
    if (std::isfinite(s.sigma_m)) unit_m = std::max(unit_m, config.unit_sigmas * s.sigma_m);
  }
  FruitPoint point;
  point.point_m = patch.depth_m * way;
  const double lens_m = config.lens_sigma_px * patch.depth_m / camera.fx_px;
  const double along_m = std::hypot(patch.sigma_m, unit_m);
  point.covariance_m2 = along_m * along_m * way * way.transpose();
  point.covariance_m2(0, 0) += lens_m * lens_m;
  point.covariance_m2(1, 1) += lens_m * lens_m;
  return point;
}

}  // namespace cousin
