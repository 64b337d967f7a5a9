#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/calibration_problem.h"

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
  double squares = 0;  ///< sum of whitened squares under the loss' weights
  double cost = 0;     ///< sum of rho
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

}  // namespace cousin
