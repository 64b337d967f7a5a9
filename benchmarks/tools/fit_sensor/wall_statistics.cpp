#include "benchmarks/tools/fit_sensor/wall_statistics.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "benchmarks/score/distributions.h"
#include "benchmarks/tools/fit_sensor/robust_plane.h"
#include "benchmarks/tools/fit_sensor/rounding.h"
#include "benchmarks/tools/fit_sensor/tile_regression.h"

namespace cousin {
namespace {

constexpr double kWrong_px = 1;       ///< beyond this a depth is not the wall's
constexpr double kStill_px2 = 1e-10;  ///< a pixel's squares over the frames if nothing changes
constexpr double kLeastShare = 0.02;  ///< of the region with a depth, for a frame to count
constexpr std::array<int, 3> kPlane = {0, 1, 2};
constexpr std::array<int, 5> kPlaneAndWave = {0, 1, 2, 6, 7};
constexpr std::array<int, 6> kBent = {0, 1, 2, 3, 4, 5};
constexpr std::array<int, 8> kAll = {0, 1, 2, 3, 4, 5, 6, 7};

/// What is kept of a pixel over the frames.
struct PixelSums {
  float n = 0;
  double sum = 0, squares = 0;
};

/// Sums over the frames of one wall.
class WallSums {
 public:
  explicit WallSums(const DepthGeometry& g)
      : g_(g),
        middle_x_(0.5 * (g.width_px - 1)),
        middle_y_(0.5 * (g.height_px - 1)),
        pixels_(static_cast<std::size_t>(g.region.width) *
                static_cast<std::size_t>(g.region.height)) {
    const double area = static_cast<double>(g.region.width) * g.region.height;
    tile_px_ = std::clamp(static_cast<int>(std::sqrt(area / 64)), 12, 64);
    across_ = std::max(1, g.region.width / tile_px_);
    down_ = std::max(1, g.region.height / tile_px_);
    asked_.assign(tiles(), 0);
    found_.assign(tiles(), 0);
  }

  std::size_t tiles() const {
    return static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_);
  }
  std::size_t tile(int x, int y) const {
    const int i = std::min((x - g_.region.x) / tile_px_, across_ - 1);
    const int j = std::min((y - g_.region.y) / tile_px_, down_ - 1);
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(across_) +
           static_cast<std::size_t>(i);
  }
  double x_of(int x) const { return x - middle_x_; }
  double y_of(int y) const { return y - middle_y_; }
  const PixelSums& pixel(int x, int y) const { return pixels_[at(x, y)]; }
  const std::vector<double>& asked() const { return asked_; }
  const std::vector<double>& found() const { return found_; }
  const std::vector<Eigen::Vector3d>& planes() const { return planes_; }
  double wrong() const { return wrong_; }
  double all_found() const {
    double sum = 0;
    for (const double f : found_) sum += f;
    return sum;
  }

  /// Errors of a frame about its own plane.
  void add(const Image<std::uint16_t>& depth, const Rng& rng) {
    const double scale = g_.focal_px * g_.baseline_m / g_.depth_unit_m;
    std::vector<PlaneSample> samples;
    for_region([&](int x, int y) {
      asked_[tile(x, y)] += 1;
      if (depth(x, y) == 0) return;
      found_[tile(x, y)] += 1;
      samples.push_back({x_of(x), y_of(y), scale / depth(x, y)});
    });
    if (static_cast<double>(samples.size()) < kLeastShare * static_cast<double>(pixels_.size()))
      return;
    const RobustPlane plane = fit_robust_plane(samples, kWrong_px, rng);
    if (!plane.found) return;
    planes_.push_back(plane.coefficients);
    for_region([&](int x, int y) {
      if (depth(x, y) == 0) return;
      const double error = scale / depth(x, y) - plane.coefficients(0) -
                           plane.coefficients(1) * x_of(x) - plane.coefficients(2) * y_of(y);
      if (std::abs(error) > plane.gate_px) {
        wrong_ += 1;
        return;
      }
      PixelSums& p = pixels_[at(x, y)];
      p.n += 1;
      p.sum += error;
      p.squares += error * error;
    });
  }

  template <class Function>
  void for_region(const Function& function) const {
    for (int y = g_.region.y; y < g_.region.y + g_.region.height; ++y) {
      for (int x = g_.region.x; x < g_.region.x + g_.region.width; ++x) function(x, y);
    }
  }

 private:
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y - g_.region.y) * static_cast<std::size_t>(g_.region.width) +
           static_cast<std::size_t>(x - g_.region.x);
  }
  const DepthGeometry& g_;
  double middle_x_, middle_y_;
  int tile_px_ = 32, across_ = 1, down_ = 1;
  std::vector<PixelSums> pixels_;
  std::vector<double> asked_, found_;
  std::vector<Eigen::Vector3d> planes_;
  double wrong_ = 0;
};

/// What the pixels' means and spreads give, tile by tile.
struct TileSums {
  explicit TileSums(std::size_t tiles)
      : regression(tiles), within(tiles, 0), freedom(tiles, 0), pixels(tiles, 0) {}
  TileRegression regression;
  std::vector<double> within, freedom;  ///< squares about a pixel's own mean, and n - 1
  std::vector<double> pixels;
  double inverse_n = 0;  ///< sum of 1 / n
};

/// Where a pixel lies in the region: 1, and -1 to 1 across and down.
class RegionPlace {
 public:
  explicit RegionPlace(const DepthGeometry& g)
      : half_x_(0.5 * g.region.width),
        half_y_(0.5 * g.region.height),
        middle_x_(g.region.x + half_x_ - 0.5),
        middle_y_(g.region.y + half_y_ - 0.5) {}
  Eigen::Vector3d row(double x, double y) const {
    return {1, (x - middle_x_) / half_x_, (y - middle_y_) / half_y_};
  }

 private:
  double half_x_, half_y_, middle_x_, middle_y_;
};

TileSums gather(const WallSums& sums, const DepthGeometry& g, const Eigen::Vector3d& plane,
                int least_frames) {
  TileSums out(sums.tiles());
  const RegionPlace place(g);
  sums.for_region([&](int x, int y) {
    const PixelSums& p = sums.pixel(x, y);
    const auto n = static_cast<double>(p.n);
    if (n < least_frames) return;
    const double mean = p.sum / n;
    const std::size_t tile = sums.tile(x, y);
    out.within[tile] += std::max(0.0, p.squares - n * mean * mean);
    out.freedom[tile] += n - 1;
    out.pixels[tile] += 1;
    out.inverse_n += 1 / n;
    const Eigen::Vector3d at = place.row(x, y);
    const double u = at(1), v = at(2);
    const double d = plane(0) + plane(1) * sums.x_of(x) + plane(2) * sums.y_of(y);
    const double phase = 2 * std::numbers::pi * (d - std::floor(d));
    TileRegression::Row row;
    row << 1, u, v, u * u, u * v, v * v, std::sin(phase), std::cos(phase);
    out.regression.add(tile, row, mean);
  });
  return out;
}

double variance_of_means(const TileRegression::Fit& fit) {
  double squares = 0;
  for (const double s : fit.squares) squares += s;
  return squares / fit.pixels;
}

/// The standard deviation that belongs to a variance with its standard error.
Measured root(double variance, double sigma) {
  const double value = std::sqrt(std::max(variance, 0.0));
  return {value, value > 0 ? sigma / (2 * value) : std::sqrt(sigma)};
}

/// Spatial and temporal noise: rounding is taken from both.
void set_noise(const TileSums& tiles, const TileRegression::Fit& fit, const DepthGeometry& g,
               WallStatistics& s) {
  const TileRatio within = tile_ratio(tiles.within, tiles.freedom);
  const TileRatio about = tile_ratio(fit.squares, tiles.pixels);
  const double step = g.disparity_step_px, quantum = s.quantum_px;
  const double temporal = unrounded_sigma(within.value, step, quantum);
  // d(sigma) / d(variance) by a small step, since rounding bends it.
  const double more = unrounded_sigma(within.value + 0.01 * within.value, step, quantum);
  s.temporal_px = {temporal,
                   within.value > 0 ? (more - temporal) / (0.01 * within.value) * within.sigma : 0};
  const double rounding = (step * step + quantum * quantum) / 12;
  const double repeats = rounding - (within.value - temporal * temporal);
  const double left = within.value * tiles.inverse_n / fit.pixels;
  const double spatial = about.value - left - repeats;
  s.spatial_px = root(spatial, about.sigma);
  s.sigma_px = root(spatial + temporal * temporal,
                    std::hypot(about.sigma, 2 * temporal * s.temporal_px.sigma));
}

/// Second-order terms beside plane and ripple.
void set_bend(const TileSums& tiles, bool with_wave, double variance, WallStatistics& s) {
  const std::span<const int> all = with_wave ? std::span<const int>(kAll) : kBent;
  const std::span<const int> flat = with_wave ? std::span<const int>(kPlaneAndWave) : kPlane;
  if (s.tiles < 12) return;
  const TileRegression::Fit bent = tiles.regression.fit(all), plane = tiles.regression.fit(flat);
  const double gain = variance_of_means(plane) - variance_of_means(bent);
  s.bend_px = std::sqrt(std::max(gain, 0.0));
  s.bend_m = s.bend_px * s.depth_m / s.disparity_px;
  const Eigen::Vector3d terms = bent.coefficients.segment<3>(3);
  const Eigen::Matrix3d covariance = bent.covariance.block<3, 3>(3, 3);
  const double chi2 = terms.dot(covariance.inverse() * terms);
  s.bend_p = std::isfinite(chi2) && variance > 0 ? chi_square_above(chi2, 3) : 1;
}

/// Share with a depth; its error from the tiles. Where there are few holes, or few depths, at least
/// that of independent windows of 8 pixels a side: few fall into few tiles.
Measured fill_of(const WallSums& sums, int frames) {
  const TileRatio ratio = tile_ratio(sums.found(), sums.asked());
  double asked = 0;
  for (const double a : sums.asked()) asked += a;
  const double windows = std::max(1.0, asked / frames / 64);
  const double p = (ratio.value * windows + 1) / (windows + 2);
  const bool is_rare = std::min(p, 1 - p) * windows < 30;
  return {ratio.value,
          is_rare ? std::max(ratio.sigma, std::sqrt(p * (1 - p) / windows)) : ratio.sigma};
}

std::string numbered(const char* format, double a, double b) {
  char text[240];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// Why noise cannot be told from these frames.
std::string problem_of(const WallStatistics& s, const DepthGeometry& g,
                       const Eigen::Vector3d& plane, bool is_still) {
  const double span_px = std::abs(plane(1)) * g.region.width + std::abs(plane(2)) * g.region.height;
  const double units = (span_px + 4 * s.sigma_px.value) / s.quantum_px;
  if (is_still) return "its frames are all alike: a paused stream has no temporal noise";
  if (s.wrong > 0.2)
    return numbered(
        "%.0f %% of the depths lie off the plane (limit %.0f %%): no flat wall fills "
        "the region",
        100 * s.wrong, 20);
  if (s.sigma_px.value > 1)
    return numbered("depths scatter by %.2f px of disparity (limit %.0f): no flat wall",
                    s.sigma_px.value, 1);
  if (units < 1.5)
    return numbered(
        "noise and tilt span %.1f steps of the depth (at least %.1f): turn the wall by "
        "5 degrees or have the camera write finer steps",
        units, 1.5);
  return {};
}

void add_ripple_bins(const WallSums& sums, const RegionPlace& place, const Eigen::Vector3d& plane,
                     const Eigen::Vector3d& beside, WallStatistics& s) {
  s.ripple_bins.assign(kRippleBins, {});
  sums.for_region([&](int x, int y) {
    const PixelSums& p = sums.pixel(x, y);
    if (p.n < 1) return;
    const double d = plane(0) + plane(1) * sums.x_of(x) + plane(2) * sums.y_of(y);
    const auto bin = static_cast<std::size_t>((d - std::floor(d)) * kRippleBins);
    RippleBin& b = s.ripple_bins[std::min(bin, s.ripple_bins.size() - 1)];
    b.sum_px += p.sum / static_cast<double>(p.n) - beside.dot(place.row(x, y));
    b.pixels += 1;
  });
}

/// The plane beside the ripple: a plane fitted alone takes a part of a wave that has few periods.
void set_plane(const TileRegression::Fit& fit, const DepthGeometry& g, WallStatistics& s) {
  const Eigen::Vector3d middle =
      RegionPlace(g).row(0.5 * (g.width_px - 1), 0.5 * (g.height_px - 1));
  s.disparity_px += fit.coefficients.head<3>().dot(middle);
  s.disparity_sigma_px =
      std::sqrt(std::max(0.0, middle.dot(fit.covariance.topLeftCorner<3, 3>() * middle)));
  s.depth_m = g.focal_px * g.baseline_m / s.disparity_px;
}

double median_depth_m(const Image<std::uint16_t>& depth, const DepthGeometry& g) {
  std::vector<std::uint16_t> codes;
  for (int y = g.region.y; y < g.region.y + g.region.height; ++y) {
    for (int x = g.region.x; x < g.region.x + g.region.width; ++x) {
      if (depth(x, y) > 0) codes.push_back(depth(x, y));
    }
  }
  if (codes.empty()) return 0;
  const auto middle = codes.begin() + static_cast<std::ptrdiff_t>(codes.size() / 2);
  std::nth_element(codes.begin(), middle, codes.end());
  return g.depth_unit_m * *middle;
}

WallSums sums_of(const WallFrames& wall, const DepthGeometry& g, double& first_median_m) {
  WallSums sums(g);
  const Rng rng = Rng(1).fork("walls");
  for (int k = 0; k < wall.count; ++k) {
    const Image<std::uint16_t> depth = wall.frame(k);
    if (depth.width() != g.width_px || depth.height() != g.height_px) {
      throw std::runtime_error(wall.name + ": frame " + std::to_string(k) + " has " +
                               std::to_string(depth.width()) + " x " +
                               std::to_string(depth.height()) + " pixels; the others have " +
                               std::to_string(g.width_px) + " x " + std::to_string(g.height_px));
    }
    if (k == 0) first_median_m = median_depth_m(depth, g);
    sums.add(depth, rng);
  }
  return sums;
}

}  // namespace

WallStatistics wall_statistics(const WallFrames& wall, const DepthGeometry& g) {
  WallStatistics s;
  s.name = wall.name;
  s.distance_m = wall.distance_m;
  s.distance_sigma_m = wall.distance_sigma_m;
  s.albedo = wall.albedo;
  s.light = wall.light;
  s.frames = wall.count;
  const WallSums sums = sums_of(wall, g, s.median_depth_m);
  s.tiles = static_cast<int>(sums.tiles());
  s.fill = fill_of(sums, wall.count);
  s.wrong = sums.all_found() > 0 ? sums.wrong() / sums.all_found() : 0;
  if (sums.planes().size() < 2 || 2 * sums.planes().size() < static_cast<std::size_t>(wall.count)) {
    s.problem = "fewer than half of its frames show a plane";
    return s;
  }
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : sums.planes()) plane += p;
  plane /= static_cast<double>(sums.planes().size());
  double drift = 0;
  for (const Eigen::Vector3d& p : sums.planes()) drift += std::pow(p(0) - plane(0), 2);
  s.drift_px = std::sqrt(drift / static_cast<double>(sums.planes().size() - 1));
  const double focal_baseline = g.focal_px * g.baseline_m;
  s.disparity_px = plane(0);
  if (!(s.disparity_px > 0)) {
    s.problem = "the plane's disparity in the image's middle is not positive";
    return s;
  }
  s.depth_m = focal_baseline / plane(0);
  s.incidence_rad = std::atan2(g.focal_px * std::hypot(plane(1), plane(2)), plane(0));
  s.quantum_px = g.depth_unit_m * plane(0) * plane(0) / focal_baseline;

  const int least = std::max(2, (wall.count + 1) / 2);
  const TileSums tiles = gather(sums, g, plane, least);
  double within = 0;
  for (std::size_t t = 0; t < tiles.pixels.size(); ++t) {
    s.pixels += static_cast<std::int64_t>(tiles.pixels[t]);
    within += tiles.within[t];
  }
  if (s.pixels < 1000) {
    s.problem = "only " + std::to_string(s.pixels) +
                " pixels of the region have a depth in half of the frames; 1000 are needed";
    return s;
  }
  s.ripple_seen = tiles.regression.separation(kPlaneAndWave) > 0.1;
  const TileRegression::Fit fit =
      s.ripple_seen ? tiles.regression.fit(kPlaneAndWave) : tiles.regression.fit(kPlane);
  if (s.ripple_seen) {
    s.ripple_px = fit.coefficients.tail<2>();
    s.ripple_covariance = fit.covariance.bottomRightCorner<2, 2>();
  }
  set_plane(fit, g, s);
  set_noise(tiles, fit, g, s);
  set_bend(tiles, s.ripple_seen, variance_of_means(fit), s);
  if (s.ripple_seen) add_ripple_bins(sums, RegionPlace(g), plane, fit.coefficients.head<3>(), s);
  s.problem = problem_of(s, g, plane, within < kStill_px2 * static_cast<double>(s.pixels));
  return s;
}

}  // namespace cousin
