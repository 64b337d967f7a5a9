#include "benchmarks/tools/fit_sensor/depth_law.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <map>
#include <stdexcept>

#include "benchmarks/score/distributions.h"

namespace cousin {
namespace {

/// The standard error of a logarithm that even 10^6 pixels do not go below: light and wall are
/// never quite the same.
constexpr double kLeastLogError = 0.002;

WithInterval interval(double value, double sigma) {
  return {value, value - kSigmas95 * sigma, value + kSigmas95 * sigma};
}

__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...) {
  char out[600];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(out, sizeof out, format, arguments);
  va_end(arguments);
  return out;
}

using Walls = std::vector<const WallStatistics*>;

/// Walls without a problem, of the light and albedo that most of them share.
Walls walls_of_laws(const std::vector<WallStatistics>& walls) {
  std::map<std::pair<double, double>, Walls> groups;
  for (const WallStatistics& w : walls) {
    if (w.problem.empty()) groups[{w.light, w.albedo}].push_back(&w);
  }
  Walls best;
  for (const auto& [conditions, group] : groups) {
    if (group.size() > best.size()) best = group;
  }
  return best;
}

/// Temporal noise below this share of the depth's step cannot be told from rounding.
bool is_resolved(const WallStatistics& w) {
  return w.temporal_px.value > 0.05 * w.quantum_px && w.temporal_px.value > 0;
}

struct Laws {
  PowerLaw spatial, temporal;
  bool temporal_solved = false;
};

Laws laws_of(const Walls& walls, double reference_m) {
  std::vector<PowerPoint> spatial, temporal;
  for (const WallStatistics* w : walls) {
    if (w->spatial_px.value > 0) spatial.push_back({w->depth_m, w->spatial_px});
    if (is_resolved(*w)) temporal.push_back({w->depth_m, w->temporal_px});
  }
  Laws laws;
  laws.spatial = fit_power_law(spatial, reference_m);
  laws.temporal_solved = temporal.size() >= 3;
  if (laws.temporal_solved) laws.temporal = fit_power_law(temporal, reference_m);
  return laws;
}

double sigma_d(const Laws& laws, double z_m) {
  const double spatial = value_at(laws.spatial, z_m);
  return laws.temporal_solved ? std::hypot(spatial, value_at(laws.temporal, z_m)) : spatial;
}

/// Variance of log sigma_d that the laws' covariances give, and its gradient's use at a distance.
double log_sigma_variance(const Laws& laws, double z_m) {
  const Eigen::Vector2d row(1, std::log(z_m / laws.spatial.reference_m));
  const double all = std::pow(sigma_d(laws, z_m), 2);
  const double share = std::pow(value_at(laws.spatial, z_m), 2) / all;
  double variance = share * share * row.dot(laws.spatial.covariance * row);
  if (laws.temporal_solved)
    variance += (1 - share) * (1 - share) * row.dot(laws.temporal.covariance * row);
  return variance;
}

double log_error(const Measured& m) {
  return std::hypot(m.sigma / std::max(m.value, 1e-12), kLeastLogError);
}

/// What the laws' sigma is compared with: without temporal noise, the spatial part alone.
const Measured& compared(const WallStatistics& w, const Laws& laws) {
  return laws.temporal_solved ? w.sigma_px : w.spatial_px;
}

/// sigma_d and the exponent of sigma_Z at the reference distance, by first-order propagation.
void set_sigma(const Laws& laws, DepthFit& fit) {
  const double z = fit.reference_m;
  const double sigma = sigma_d(laws, z);
  fit.sigma_d_px = interval(sigma, sigma * std::sqrt(log_sigma_variance(laws, z)));
  // exponent = 2 + share a + (1 - share) b, with share = s^2 / (s^2 + t^2).
  const double share = std::pow(value_at(laws.spatial, z) / sigma, 2);
  const double a = laws.spatial.exponent, b = laws.temporal_solved ? laws.temporal.exponent : 0;
  const double tilt = 2 * share * (1 - share) * (a - b);
  const Eigen::Vector2d of_spatial(tilt, share), of_temporal(-tilt, 1 - share);
  double variance = of_spatial.dot(laws.spatial.covariance * of_spatial);
  if (laws.temporal_solved) variance += of_temporal.dot(laws.temporal.covariance * of_temporal);
  fit.sigma_z_exponent = interval(2 + share * a + (1 - share) * b, std::sqrt(variance));
}

void set_goodness(const Walls& walls, const Laws& laws, DepthFit& fit) {
  fit.chi2 = 0;
  for (const WallStatistics* w : walls) {
    const Measured& m = compared(*w, laws);
    fit.chi2 += std::pow(std::log(sigma_d(laws, w->depth_m) / m.value) / log_error(m), 2);
  }
  fit.degrees = static_cast<int>(walls.size()) - 2;
  fit.p = chi_square_above(fit.chi2, fit.degrees);
  double squares = 0;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    Walls others = walls;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const Laws without = laws_of(others, fit.reference_m);
    const WallStatistics& w = *walls[i];
    const double of_wall = log_error(compared(w, without));
    HeldOut h{w.name, w.depth_m, sigma_d(without, w.depth_m) / compared(w, without).value,
              std::sqrt(log_sigma_variance(without, w.depth_m) + of_wall * of_wall)};
    squares += std::pow(std::log(h.ratio), 2);
    fit.held_out.push_back(std::move(h));
  }
  fit.held_out_rms = std::sqrt(squares / static_cast<double>(walls.size()));
}

/// One sine over all walls, by the weights of their covariances.
void set_ripple(const Walls& walls, DepthFit& fit) {
  Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const WallStatistics* w : walls) {
    if (!w->ripple_seen) continue;
    const Eigen::Matrix2d weight = w->ripple_covariance.inverse();
    if (!weight.allFinite()) continue;
    a += weight;
    b += weight * w->ripple_px;
    fit.ripple_solved = true;
  }
  if (!fit.ripple_solved) return;
  const Eigen::Matrix2d covariance = a.inverse();
  const Eigen::Vector2d wave = covariance * b;
  const double amplitude = wave.norm();
  const Eigen::Vector2d along =
      amplitude > 0 ? Eigen::Vector2d(wave / amplitude) : Eigen::Vector2d(1, 0);
  const double variance = along.dot(covariance * along);
  // The length of a noisy vector is too long, by half the variance across over the length.
  const double across = covariance.trace() - variance;
  fit.ripple_px =
      interval(std::sqrt(std::max(0.0, amplitude * amplitude - across)), std::sqrt(variance));
  fit.ripple_px.low = std::max(0.0, fit.ripple_px.low);
  fit.ripple_phase_rad = std::atan2(wave(1), wave(0));
}

/// Disparity against f B over the stated distance: a straight line by weighted least squares.
void set_bias(const Walls& walls, const DepthGeometry& geometry, DepthFit& fit) {
  Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  const auto weight_of = [&](const WallStatistics& w) {
    // Of the tape, and of the plane's mean.
    const double tape = w.disparity_px * w.distance_sigma_m / w.distance_m;
    const double plane = w.disparity_sigma_px;
    return 1 / (tape * tape + plane * plane);
  };
  const double focal_baseline = geometry.focal_px * geometry.baseline_m;
  for (const WallStatistics* w : walls) {
    const Eigen::Vector2d row(focal_baseline / w->distance_m, 1);
    a += weight_of(*w) * row * row.transpose();
    b += weight_of(*w) * w->disparity_px * row;
  }
  const Eigen::Matrix2d covariance = a.inverse();
  const Eigen::Vector2d line = covariance * b;
  double chi2 = 0;
  const WallStatistics* worst = nullptr;
  double worst_share = 0;
  for (const WallStatistics* w : walls) {
    const double off = w->disparity_px - line(0) * focal_baseline / w->distance_m - line(1);
    chi2 += weight_of(*w) * off * off;
    if (std::abs(off / w->disparity_px) > worst_share) {
      worst_share = std::abs(off / w->disparity_px);
      worst = w;
    }
  }
  fit.distance_p = chi_square_above(chi2, static_cast<int>(walls.size()) - 2);
  fit.scale = interval(line(0), std::sqrt(covariance(0, 0)));
  fit.bias_px = interval(line(1), std::sqrt(covariance(1, 1)));
  fit.bias_solved = kSigmas95 * std::sqrt(covariance(1, 1)) < 0.1;
  if (std::abs(line(0) - 1) > 0.1) {
    fit.problems.push_back(
        text("depths are %.3f times the stated distances: depth_unit_m, focal_px "
             "or baseline_m of recordings.toml is not this device's",
             1 / line(0)));
  } else if (fit.distance_p < 1e-3 && worst_share > 0.02) {
    fit.problems.push_back(text("%s: depth says %.3f m, the distance stated is %.3f m",
                                worst->name.c_str(), worst->depth_m, worst->distance_m));
  }
}

void add_problems(const Walls& walls, DepthFit& fit) {
  for (const WallStatistics* w : walls) {
    if (w->bend_p < 1e-3 && w->bend_px > 0.3 * w->sigma_px.value)
      fit.problems.push_back(
          text("%s bends: RMS %.2f mm about a plane (%.3f px; limit 0.3 of the noise, %.3f px), "
               "p = %.1g: the wall or the calibration is not flat",
               w->name.c_str(), 1000 * w->bend_m, w->bend_px, 0.3 * w->sigma_px.value, w->bend_p));
  }
  const WithInterval& e = fit.sigma_z_exponent;
  if (e.high < kLeastExponent || e.low > kLargestExponent)
    fit.problems.push_back(text(
        "sigma_Z grows as Z to the power %.2f [%.2f, %.2f]; stereo grows as Z^2 (accepted: %.1f to "
        "%.1f): not a stereo camera, or recordings in changing light",
        e.value, e.low, e.high, kLeastExponent, kLargestExponent));
  if (fit.p < 0.01 && fit.held_out_rms > kHeldOutLimit)
    fit.problems.push_back(
        text("sigma_Z does not follow the law: held-out distances are off by %.0f %% (limit %.0f "
             "%%), chi-square %.0f of %d degrees, p = %.1g",
             100 * fit.held_out_rms, 100 * kHeldOutLimit, fit.chi2, fit.degrees, fit.p));
}

/// Depth over stated distance: the median over the walls; 1 if none has a depth.
double median_ratio(const std::vector<WallStatistics>& walls) {
  std::vector<double> ratios;
  for (const WallStatistics& w : walls) {
    if (w.median_depth_m > 0) ratios.push_back(w.median_depth_m / w.distance_m);
  }
  if (ratios.empty()) return 1;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

/// Units that depth cameras write: metres a step.
constexpr std::array<double, 7> kUnits_m = {0.01, 0.001, 0.0005, 0.00025, 0.0002, 0.000125, 0.0001};

/// What to say of depths that are far from the stated distances, whatever else they are like; else
/// empty.
std::string unit_problem(const std::vector<WallStatistics>& walls, const DepthGeometry& geometry) {
  constexpr double kFar = 1.5, kNear = 1.1;
  const double ratio = median_ratio(walls);
  if (ratio < kFar && ratio > 1 / kFar) return "";
  std::string told = text(
      "depths are %.3f times the stated distances: depth_unit_m, focal_px or baseline_m of "
      "recordings.toml is not this device's",
      ratio);
  for (const double unit_m : kUnits_m) {
    const double off = unit_m * ratio / geometry.depth_unit_m;
    if (off < kNear && off > 1 / kNear)
      return told + text(
                        "; the likely reason is the depth's unit: it was taken as %g mm, and %g mm "
                        "fits (depth_unit_m = %g)",
                        1000 * geometry.depth_unit_m, 1000 * unit_m, unit_m);
  }
  return told;
}

/// Walls whose spatial noise is above their rounding.
std::size_t noisy(const Walls& walls) {
  return static_cast<std::size_t>(std::count_if(
      walls.begin(), walls.end(), [](const WallStatistics* w) { return w->spatial_px.value > 0; }));
}

}  // namespace

PowerLaw fit_power_law(const std::vector<PowerPoint>& points, double reference_m) {
  if (points.size() < 2)
    throw std::invalid_argument("power law: " + std::to_string(points.size()) +
                                " points; at least 2 are needed");
  PowerLaw law;
  law.reference_m = reference_m;
  Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const PowerPoint& p : points) {
    if (!(p.z_m > 0) || !(p.value.value > 0))
      throw std::invalid_argument("power law: a point is not positive");
    const double weight = std::pow(log_error(p.value), -2);
    const Eigen::Vector2d row(1, std::log(p.z_m / reference_m));
    a += weight * row * row.transpose();
    b += weight * std::log(p.value.value) * row;
  }
  law.covariance = a.inverse();
  const Eigen::Vector2d solution = law.covariance * b;
  law.log_value = solution(0);
  law.exponent = solution(1);
  for (const PowerPoint& p : points) {
    const double off = std::log(p.value.value / value_at(law, p.z_m)) / log_error(p.value);
    law.chi2 += off * off;
  }
  law.degrees = static_cast<int>(points.size()) - 2;
  if (law.degrees > 0) law.covariance *= std::max(1.0, law.chi2 / law.degrees);
  return law;
}

double value_at(const PowerLaw& law, double z_m) {
  return std::exp(law.log_value + law.exponent * std::log(z_m / law.reference_m));
}

double sigma_z_m(const DepthFit& fit, const DepthGeometry& geometry, double z_m) {
  return z_m * z_m / (geometry.focal_px * geometry.baseline_m) *
         sigma_d({fit.spatial, fit.temporal, fit.temporal_solved}, z_m);
}

DepthFit fit_depth(std::vector<WallStatistics> walls, const DepthGeometry& geometry) {
  DepthFit fit;
  fit.walls = std::move(walls);
  const Walls used = walls_of_laws(fit.walls);
  double least = 0, most = 0, logs = 0;
  for (const WallStatistics* w : used) {
    least = least == 0 ? w->depth_m : std::min(least, w->depth_m);
    most = std::max(most, w->depth_m);
    logs += std::log(w->depth_m);
  }
  for (const WallStatistics& w : fit.walls) {
    if (!w.problem.empty()) fit.problems.push_back(w.name + ": " + w.problem);
  }
  const std::string unit = unit_problem(fit.walls, geometry);
  if (!unit.empty()) {
    fit.problems.insert(fit.problems.begin(), unit);
    return fit;
  }
  if (used.size() < static_cast<std::size_t>(kLeastWalls) || most < 1.5 * least) {
    fit.problems.push_back(
        text("%zu usable walls of one light at %.2f to %.2f m; at least %d are "
             "needed, the farthest 1.5 times as far as the nearest",
             used.size(), least, most, kLeastWalls));
    return fit;
  }
  // A wall that cannot be used is no reason to reject what the others say.
  fit.problems.clear();
  fit.reference_m = std::exp(logs / static_cast<double>(used.size()));
  // One is left out at a time, and two are a law.
  if (noisy(used) < 3) {
    fit.problems.push_back(
        text("noise is above the rounding of the depth's step at %zu of %zu walls; at least 3 are "
             "needed: have the camera write finer steps, or check depth_unit_m, focal_px and "
             "baseline_m",
             noisy(used), used.size()));
    return fit;
  }
  const Laws laws = laws_of(used, fit.reference_m);
  fit.spatial = laws.spatial;
  fit.temporal = laws.temporal;
  fit.temporal_solved = laws.temporal_solved;
  set_sigma(laws, fit);
  set_goodness(used, laws, fit);
  set_ripple(used, fit);
  set_bias(used, geometry, fit);
  add_problems(used, fit);
  return fit;
}

}  // namespace cousin
