#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/solve/calibration_problem.h"

namespace cousin {

/// Normal equations of a problem at a state, the frames' poses eliminated. Parameters are the free
/// ones of lenses, then cameras 1.., then the deformation, in the problem's units.
struct SharedSystem {
  std::vector<std::string> names;
  Eigen::VectorXd values;
  Eigen::VectorXd scale;            ///< unit of each in the input's lengths
  Eigen::MatrixXd reduced;          ///< Schur complement of the frames, priors added
  Eigen::VectorXd diagonal;         ///< before the elimination
  Eigen::MatrixXd mean_frame_gain;  ///< as in CalibrationResult, problem's units
  Eigen::Matrix<double, 6, 6> mean_frame_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::VectorXd right;  ///< gradient, the frames eliminated
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>>
      frame_gain;                   ///< for each frame: its step is
  std::vector<Vector6d> frame_own;  ///< -(frame_own + frame_gain times the shared step)
  double squares = 0;               ///< sum of whitened squares under the loss' weights
  double cost = 0;                  ///< sum of rho
  int coordinates = 0;
};
SharedSystem shared_system(const CalibrationProblem& problem, const CalibrationState& state);

/// Inverse of the reduced normal equations where they have one.
struct SharedCovariance {
  Eigen::MatrixXd covariance;               ///< for a residual variance of 1
  std::vector<std::string> not_determined;  ///< parameters that the equations do not fix at all
};
/// Directions whose eigenvalue, with every parameter scaled by its own curvature, is below 1e-13
/// are not determined: that is what rounding leaves of zero.
SharedCovariance invert(const SharedSystem& system);

/// One full Gauss-Newton step: near a minimum it goes on where the cost, to rounding, no longer
/// tells better from worse.
CalibrationState gauss_newton_step(const CalibrationProblem& problem, const CalibrationState& state,
                                   const SharedSystem& system, const SharedCovariance& inverse);

}  // namespace cousin
