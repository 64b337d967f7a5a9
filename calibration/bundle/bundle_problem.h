#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/bundle/bundle_adjustment.h"
#include "calibration/solve/lens_value.h"
#include "calibration/solve/observation_cost.h"

namespace cousin {

/// A bundle adjustment about the cameras' middle, in units of their spread. Private to calibration.
struct BundleProblem {
  BundleAdjustmentConfig config;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double unit_m = 1;
  std::vector<LensShape> shapes;                         ///< of lenses
  std::vector<Camera> like;                              ///< as given
  std::vector<Eigen::VectorXd> lenses;                   ///< parameters
  std::vector<std::vector<bool>> free;                   ///< of each
  std::vector<Eigen::VectorXd> prior_mean, prior_sigma;  ///< infinity: none
  std::vector<int> lens_of_image;
  std::vector<double> zoom;     ///< of each image; free where config.zoom_share is not 0
  std::vector<Vector6d> poses;  ///< camera_from_world
  std::vector<Eigen::Vector3d> points;
  std::vector<BundleObservation> observations;
  std::vector<bool> used;                ///< of observations
  std::vector<KnownPoint> known_points;  ///< in these units
  std::vector<KnownDistance> known_distances;
  BundleGauge gauge = BundleGauge::similarity;
};

/// What the normal equations say at the solution.
struct BundleCovariance {
  bool solved = false;  ///< false: singular beyond the gauge
  /// Of the free parameters, lens by lens, before `sigma`^2; focal lengths as the mean of images'.
  Eigen::MatrixXd lens;
  std::vector<Eigen::Matrix<double, 6, 6>> poses;  ///< before `sigma`^2
};

/// Points are eliminated, the gauge is held by inner constraints on the poses.
BundleCovariance bundle_covariance(const BundleProblem& problem);

/// Residual of an observation over its sigma, before the loss; NaN where the point has no pixel.
Eigen::Vector2d bundle_residual(const BundleProblem& problem, const BundleObservation& seen);

/// Whether what is left to gain is below what the images can tell. `costs`: half chi squared,
/// before the first step and after each. True when the last third of at least 60 steps together
/// lowered it by less than 1e-3: about a minimum, to second order, that moves no parameter by more
/// than a twentieth of its standard deviation.
bool cost_has_settled(const std::vector<double>& costs);

/// Minimises over lenses, poses and points (Ceres); `iterations` grows. Steps that are at an end
/// after `config.max_iterations` have converged if their cost has settled: near sightings that
/// contradict each other it can creep for hundreds of steps just above `config.tolerance`.
/// @returns "" or why it did not converge
std::string minimise_bundle(BundleProblem& problem, int& iterations);

}  // namespace cousin
