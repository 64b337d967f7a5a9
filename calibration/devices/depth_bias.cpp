#include "calibration/devices/depth_bias.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "calibration/solve/normal_mad.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr int kMostBiasPasses = 10;
constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kMostGap = 0.4;     ///< of a disparity's fractions that no sample has
constexpr double kRounding = 1e-12;  ///< an eigenvalue below is what rounding leaves of zero

double radius2(const Eigen::Vector2d& pixel, int width_px, int height_px) {
  const Eigen::Vector2d middle(0.5 * (width_px - 1), 0.5 * (height_px - 1));
  return (pixel - middle).squaredNorm() / middle.squaredNorm();
}

std::vector<std::string> terms_of(const DepthBiasConfig& config) {
  std::vector<std::string> terms;
  if (config.offset) terms.emplace_back("offset_m");
  if (config.scale) terms.emplace_back("scale");
  if (config.bowl) terms.emplace_back("bowl");
  if (config.disparity_shift) terms.emplace_back("disparity_shift_per_m");
  if (config.ripple) terms.insert(terms.end(), {"ripple_sin_px", "ripple_cos_px"});
  return terms;
}

Eigen::VectorXd row_of(const DepthBiasConfig& config, double depth_m, double r2) {
  Eigen::VectorXd row(config.offset + config.scale + config.bowl + config.disparity_shift +
                      2 * config.ripple);
  Eigen::Index at = 0;
  if (config.offset) row(at++) = 1;
  if (config.scale) row(at++) = depth_m;
  if (config.bowl) row(at++) = r2 * depth_m;
  if (config.disparity_shift) row(at++) = depth_m * depth_m;
  if (config.ripple) {
    const double turn = kTurn * config.focal_baseline_px_m / depth_m;
    const double per_px = -depth_m * depth_m / config.focal_baseline_px_m;
    row(at++) = per_px * std::sin(turn);
    row(at++) = per_px * std::cos(turn);
  }
  return row;
}

/// One least-squares fit over samples, and what it leaves of each.
struct Fit {
  Eigen::VectorXd solution;
  Eigen::MatrixXd inverse;     ///< of the normal equations
  std::vector<int> open;       ///< terms that the samples do not tell apart
  std::vector<double> left_m;  ///< absolute, of each sample
  double squares_m2 = 0;
};

Fit fit(const std::vector<DepthSample>& samples, const DepthBiasConfig& config, Eigen::Index n,
        int width_px, int height_px) {
  Fit result;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  const auto row_at = [&](const DepthSample& s) {
    return row_of(config, s.true_m, radius2(s.pixel_px, width_px, height_px));
  };
  for (const DepthSample& s : samples) {
    const Eigen::VectorXd row = row_at(s);
    normal += row * row.transpose();
    right += row * (s.measured_m - s.true_m);
  }
  // Scaled by each term's own size: what is then below rounding is not determined.
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(scale.asDiagonal() * normal * scale.asDiagonal()));
  for (Eigen::Index k = 0; k < n && !(solver.eigenvalues()(0) > kRounding); ++k) {
    if (!std::isfinite(scale(k)) || std::abs(solver.eigenvectors()(k, 0)) > 0.1)
      result.open.push_back(static_cast<int>(k));
  }
  if (!result.open.empty()) return result;
  result.inverse = scale.asDiagonal() * solver.eigenvectors() *
                   solver.eigenvalues().cwiseInverse().asDiagonal() *
                   solver.eigenvectors().transpose() * scale.asDiagonal();
  result.solution = result.inverse * right;
  for (const DepthSample& s : samples) {
    result.left_m.push_back(std::abs(s.measured_m - s.true_m - row_at(s).dot(result.solution)));
    result.squares_m2 += result.left_m.back() * result.left_m.back();
  }
  return result;
}

/// The samples within `sigmas` robust deviations of the fit; all if there is no spread.
std::vector<DepthSample> kept(const std::vector<DepthSample>& samples, const Fit& fitted,
                              double sigmas) {
  std::vector<double> sorted = fitted.left_m;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double limit = sigmas * kNormalMad * *middle;
  if (!(limit > 0)) return samples;
  std::vector<DepthSample> result;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (fitted.left_m[i] <= limit) result.push_back(samples[i]);
  }
  return result;
}

/// A fit that says nothing, with the terms that are open.
DepthBias open_bias(DepthBias bias, const std::vector<int>& open, const std::string& reason) {
  bias.status = CalibrationStatus::not_determined;
  for (const int k : open) bias.not_determined.push_back(bias.terms[static_cast<std::size_t>(k)]);
  if (open.empty()) bias.not_determined = bias.terms;
  bias.reason = reason;
  return bias;
}

/// The longest stretch of a pixel's period that no sample's disparity falls into.
double longest_gap(const std::vector<DepthSample>& samples, double focal_baseline_px_m) {
  std::vector<double> fractions;
  for (const DepthSample& s : samples) {
    const double disparity_px = focal_baseline_px_m / s.true_m;
    fractions.push_back(disparity_px - std::floor(disparity_px));
  }
  std::sort(fractions.begin(), fractions.end());
  double longest = 1 + fractions.front() - fractions.back();
  for (std::size_t i = 1; i < fractions.size(); ++i)
    longest = std::max(longest, fractions[i] - fractions[i - 1]);
  return longest;
}

/// Why a ripple is not to be used; empty if it is.
std::string ripple_complaint(const DepthBias& bias, const DepthBiasConfig& config,
                             const std::vector<DepthSample>& samples) {
  std::ostringstream text;
  const double gap = longest_gap(samples, config.focal_baseline_px_m);
  const Eigen::Index n = bias.covariance.rows();
  const double sigma_px = std::sqrt(bias.covariance.diagonal().tail<2>().maxCoeff());
  const double amplitude_px = std::hypot(bias.ripple_sin_px, bias.ripple_cos_px);
  if (gap > kMostGap) {
    text << "the planes' disparities leave " << gap << " of a pixel's period out (at most "
         << kMostGap << ")";
  } else if (!(sigma_px <= config.max_ripple_deviation_px) || n < 2) {
    text << "the ripple has a deviation of " << sigma_px << " px (at most "
         << config.max_ripple_deviation_px << ")";
  } else if (kTurn * amplitude_px >= 1) {
    text << "a ripple of " << amplitude_px << " px is no function of depth (below " << 1 / kTurn
         << ")";
  }
  return text.str();
}

}  // namespace

Fields fields(DepthBiasConfig& config) {
  return {
      {"offset", &config.offset, "solve for a constant"},
      {"scale", &config.scale, "solve for a share of the depth"},
      {"bowl", &config.bowl, "solve for a share of the depth that grows with the radius squared"},
      {"disparity_shift", &config.disparity_shift, "solve for a term in the depth squared"},
      {"ripple", &config.ripple, "solve for a sine of the disparity's fraction; needs f B"},
      {"focal_baseline_px_m", &config.focal_baseline_px_m, "of the depth's pixels; 0 = unknown", 0,
       1e9},
      {"max_ripple_deviation_px", &config.max_ripple_deviation_px,
       "of the ripple's terms, above which they are not determined", 1e-9, 10},
      {"reject_sigmas", &config.reject_sigmas, "samples beyond are left out; 0 = none", 0, 1e6},
      {"max_deviation_m", &config.max_deviation_m,
       "of the bias at the mean depth, above which it is not determined", 1e-9, 10},
  };
}

void validate(const DepthBiasConfig& config) {
  DepthBiasConfig copy = config;
  check_limits(fields(copy));
  if (terms_of(config).empty()) throw std::invalid_argument("depth bias: no term to solve for");
  if (config.ripple && !(config.focal_baseline_px_m > 0))
    throw std::invalid_argument("depth bias: ripple needs focal_baseline_px_m > 0, not " +
                                std::to_string(config.focal_baseline_px_m));
}

DepthBias fit_depth_bias(const std::vector<DepthSample>& samples, int width_px, int height_px,
                         const DepthBiasConfig& config) {
  validate(config);
  DepthBias bias;
  bias.terms = terms_of(config);
  const auto n = static_cast<Eigen::Index>(bias.terms.size());
  std::vector<DepthSample> used;
  for (const DepthSample& s : samples) {
    if (std::isfinite(s.measured_m) && std::isfinite(s.true_m) && s.true_m > 0 &&
        s.pixel_px.allFinite())
      used.push_back(s);
  }
  const std::size_t all = used.size();
  Fit fitted;
  for (int pass = 0; pass < kMostBiasPasses; ++pass) {
    if (static_cast<Eigen::Index>(used.size()) <= n) {
      return open_bias(
          bias, {}, std::to_string(used.size()) + " samples for " + std::to_string(n) + " terms");
    }
    fitted = fit(used, config, n, width_px, height_px);
    if (!fitted.open.empty()) {
      return open_bias(bias, fitted.open,
                       "the samples' depths and places do not tell these terms apart");
    }
    std::vector<DepthSample> next = kept(used, fitted, config.reject_sigmas);
    if (next.size() == used.size()) break;
    used = std::move(next);
  }
  const auto count = static_cast<double>(fitted.left_m.size());
  Eigen::Index at = 0;
  if (config.offset) bias.offset_m = fitted.solution(at++);
  if (config.scale) bias.scale = fitted.solution(at++);
  if (config.bowl) bias.bowl = fitted.solution(at++);
  if (config.disparity_shift) bias.disparity_shift_per_m = fitted.solution(at++);
  if (config.ripple) {
    bias.ripple_sin_px = fitted.solution(at++);
    bias.ripple_cos_px = fitted.solution(at++);
    bias.focal_baseline_px_m = config.focal_baseline_px_m;
  }
  bias.covariance = fitted.squares_m2 / (count - static_cast<double>(n)) * fitted.inverse;
  bias.rms_m = std::sqrt(fitted.squares_m2 / count);
  bias.samples = static_cast<int>(used.size());
  bias.rejected = static_cast<int>(all - used.size());
  double mean_m = 0;
  for (const DepthSample& s : used) mean_m += s.true_m / static_cast<double>(used.size());
  const Eigen::VectorXd row = row_of(config, mean_m, 0);
  const double deviation_m = std::sqrt(row.dot(bias.covariance * row));
  bias.status = CalibrationStatus::ok;
  if (config.ripple) {
    const std::string complaint = ripple_complaint(bias, config, used);
    const int first = static_cast<int>(n) - 2;
    if (!complaint.empty()) return open_bias(bias, {first, first + 1}, complaint);
  }
  if (deviation_m <= config.max_deviation_m) return bias;
  return open_bias(bias, {},
                   "the bias at the mean depth has a deviation of " + std::to_string(deviation_m) +
                       " m (at most " + std::to_string(config.max_deviation_m) + ")");
}

DepthRipple ripple_of(const DepthBias& bias) {
  const Eigen::Index n = bias.covariance.rows();
  if (bias.status != CalibrationStatus::ok || bias.terms.empty() ||
      bias.terms.back() != "ripple_cos_px" || n < 2)
    throw std::invalid_argument("ripple: this depth bias was fitted without one");
  DepthRipple ripple;
  const Eigen::Vector2d at(bias.ripple_sin_px, bias.ripple_cos_px);
  ripple.amplitude_px = at.norm();
  ripple.phase_rad = std::atan2(at.y(), at.x());
  const Eigen::Matrix2d covariance = bias.covariance.bottomRightCorner<2, 2>();
  const Eigen::Vector2d along = at / ripple.amplitude_px, across(-along.y(), along.x());
  ripple.amplitude_sigma_px = std::sqrt(along.dot(covariance * along));
  ripple.phase_sigma_rad = std::sqrt(across.dot(covariance * across)) / ripple.amplitude_px;
  return ripple;
}

double corrected_depth_m(const DepthBias& bias, const Eigen::Vector2d& pixel_px, double measured_m,
                         int width_px, int height_px) {
  const double slope = 1 + bias.scale + bias.bowl * radius2(pixel_px, width_px, height_px);
  // Root of shift z^2 + slope z = measured - offset that goes to the linear one for no shift.
  const double d = bias.disparity_shift_per_m;
  const auto smooth_m = [&](double depth_m) {
    const double c = depth_m - bias.offset_m;
    return 2 * c / (slope + std::sqrt(std::max(0.0, slope * slope + 4 * d * c)));
  };
  const double around_m = smooth_m(measured_m);
  const double fb = bias.focal_baseline_px_m;
  if (!(fb > 0) || !(around_m > 0)) return around_m;

  // Depth grows with distance: Newton's steps within a bracket of twice the ripple's amplitude.
  const double most_m =
      std::hypot(bias.ripple_sin_px, bias.ripple_cos_px) * around_m * around_m / fb;
  double low = around_m - 2 * most_m, high = around_m + 2 * most_m, z = around_m;
  constexpr int kMostSteps = 60;
  for (int i = 0; i < kMostSteps; ++i) {
    const double turn = kTurn * fb / z;
    const double wave = bias.ripple_sin_px * std::sin(turn) + bias.ripple_cos_px * std::cos(turn);
    const double by_turn =
        bias.ripple_sin_px * std::cos(turn) - bias.ripple_cos_px * std::sin(turn);
    const double miss = bias.offset_m + slope * z + d * z * z - z * z / fb * wave - measured_m;
    (miss > 0 ? high : low) = z;
    const double rise = slope + 2 * d * z - 2 * z / fb * wave + kTurn * by_turn;
    double next = z - miss / rise;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - z) <= 1e-14 * z) return next;
    z = next;
  }
  return z;
}

double biased_depth_m(const DepthBias& bias, const Eigen::Vector2d& pixel_px, double true_m,
                      int width_px, int height_px) {
  const double slope = 1 + bias.scale + bias.bowl * radius2(pixel_px, width_px, height_px);
  double measured_m = bias.offset_m + true_m * (slope + bias.disparity_shift_per_m * true_m);
  if (bias.focal_baseline_px_m > 0) {
    const double turn = kTurn * bias.focal_baseline_px_m / true_m;
    measured_m -= true_m * true_m / bias.focal_baseline_px_m *
                  (bias.ripple_sin_px * std::sin(turn) + bias.ripple_cos_px * std::cos(turn));
  }
  return measured_m;
}

double plane_depth_m(const Camera& camera, const Pose& camera_from_target,
                     const Eigen::Vector2d& pixel_px) {
  const std::optional<Eigen::Vector3d> ray = unproject(camera, pixel_px);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (!ray) return nan;
  const Eigen::Vector3d normal = camera_from_target.rotation * Eigen::Vector3d::UnitZ();
  const double t = normal.dot(camera_from_target.translation_m) / normal.dot(*ray);
  return t > 0 && std::isfinite(t) ? t * ray->z() : nan;
}

}  // namespace cousin
