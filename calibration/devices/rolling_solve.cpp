#include "calibration/devices/rolling_solve.h"

#include <algorithm>
#include <cmath>

#include "calibration/boards/planar_pose.h"
#include "calibration/solve/normal_mad.h"

namespace cousin {
namespace {

constexpr int kNoisePasses = 3;
constexpr int kRejectionPasses = 20;

/// Freedoms that the data, and not the priors, pay for: trace of the covariance times the data's
/// part of the normal equations.
double freedoms_of(const RollingSystem& system, const ChainFactor& factor,
                   const Eigen::MatrixXd& gain, const Eigen::MatrixXd& covariance) {
  const FrameChain inverse = factor.inverse_blocks();
  double held = 0;
  for (std::size_t v = 0; v < inverse.own.size(); ++v) {
    const auto at = 12 * static_cast<Eigen::Index>(v);
    const Eigen::MatrixXd here = gain.middleRows<12>(at);
    held += (inverse.own[v] + here * covariance * here.transpose())
                .cwiseProduct(system.chain_of_priors.own[v])
                .sum();
    if (v + 1 == inverse.own.size()) continue;
    const Eigen::MatrixXd after = gain.middleRows<12>(at + 12);
    held += 2 * (inverse.next[v] + here * covariance * after.transpose())
                    .cwiseProduct(system.chain_of_priors.next[v])
                    .sum();
  }
  held += covariance.diagonal().dot(system.shared_priors);
  return static_cast<double>(system.right.size() + system.shared_right.size()) - held;
}

RollingCovariance covariance_of(const RollingState& state, const RollingSystem& system,
                                const std::vector<std::string>& names) {
  RollingCovariance result;
  const ChainFactor factor(system.chain);
  if (!factor.ok()) return result;
  const Eigen::MatrixXd gain = factor.solve(system.mixed);
  SharedSystem shared;
  shared.names = names;
  shared.diagonal = system.shared.diagonal();
  shared.reduced = system.shared - system.mixed.transpose() * gain;
  result.shared = invert(shared);
  result.freedoms = freedoms_of(system, factor, gain, result.shared.covariance);
  // A turn and a shift of the target's middle as a twist about the camera.
  Eigen::MatrixXd twist = Eigen::MatrixXd::Zero(6, system.mixed.rows());
  const double share = 1 / static_cast<double>(state.poses.size());
  for (std::size_t v = 0; v < state.poses.size(); ++v) {
    const auto at = 12 * static_cast<Eigen::Index>(v);
    twist.block<6, 6>(0, at).setIdentity();
    twist.block<3, 3>(3, at) = cross_matrix(state.poses[v].translation_m);
    twist.middleCols<6>(at) *= share;
  }
  result.mean_frame_gain = -twist * gain;
  result.mean_frame_covariance = twist * factor.solve(twist.transpose());
  result.ok = true;
  return result;
}

/// @return how many observations beyond the limit are newly rejected
int reject(RollingProblem& all, const RollingState& state, double sigmas) {
  std::vector<double> sizes;
  std::vector<std::vector<double>> largest(state.poses.size());
  for (std::size_t v = 0; v < state.poses.size(); ++v) {
    const std::vector<Eigen::Vector2d> residuals = rolling_residuals(all, state, v);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const ProblemPoint& p = all.problem.views[v].points[i];
      const Eigen::Vector2d r = (p.white * residuals[i]).cwiseAbs();
      largest[v].push_back(r.maxCoeff());
      if (!p.rejected && r.allFinite()) sizes.insert(sizes.end(), {r.x(), r.y()});
    }
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double limit = sigmas * kNormalMad * *middle;
  int rejected = 0;
  for (std::size_t v = 0; v < state.poses.size(); ++v) {
    for (std::size_t i = 0; i < largest[v].size(); ++i) {
      ProblemPoint& p = all.problem.views[v].points[i];
      if (p.rejected || largest[v][i] <= limit) continue;
      p.rejected = true;
      ++rejected;
    }
  }
  return rejected;
}

}  // namespace

std::vector<std::string> rolling_names(const RollingProblem& all) {
  const ProblemLens& lens = all.problem.lenses.front();
  const std::vector<std::string> every = lens_parameter_names(lens.shape);
  std::vector<std::string> names;
  for (std::size_t k = 0; k < every.size(); ++k) {
    if (lens.free[k]) names.push_back("camera0." + every[k]);
  }
  if (all.delay_is_free) names.emplace_back(kLineDelay);
  return names;
}

std::string solve_rolling(RollingProblem& all, RollingState& state, RollingCovariance& covariance,
                          int& iterations, double& squares) {
  const std::vector<std::string> names = rolling_names(all);
  const CalibrationConfig& config = all.problem.config;
  for (int pass = 0, noise_passes = 0; pass < kNoisePasses + kRejectionPasses; ++pass) {
    const int steps = minimise_rolling(all, state, config.max_iterations);
    if (steps < 0) return "the refinement with a rolling shutter did not converge";
    iterations += steps;
    const RollingSystem system = rolling_system(all, state);
    covariance = covariance_of(state, system, names);
    if (!covariance.ok) return "the normal equations of a view are singular";
    const double spare = system.coordinates - covariance.freedoms;
    if (!(spare > 0.5)) return std::to_string(system.coordinates) + " coordinates are too few";
    squares = system.squares;
    if (noise_passes == kNoisePasses) return "";
    // Without noise the corners still have rounding, and information must stay finite.
    constexpr double kLeastNoise = 1e-9;
    all.noise = std::max(kLeastNoise, std::sqrt(system.squares / spare));
    const double sigmas = config.reject_sigmas;
    if (sigmas > 0 && pass < kRejectionPasses && reject(all, state, sigmas) > 0) continue;
    ++noise_passes;
  }
  return "";
}

}  // namespace cousin
