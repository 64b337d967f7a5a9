#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/devices/rolling_system.h"
#include "calibration/solve/calibration_covariance.h"

namespace cousin {

inline constexpr const char* kLineDelay = "camera0.line_delay_s";

/// What the normal equations say at a solution. Private to calibration.
struct RollingCovariance {
  bool ok = false;
  SharedCovariance shared;
  double freedoms = 0;
  Eigen::MatrixXd mean_frame_gain;
  Eigen::Matrix<double, 6, 6> mean_frame_covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Free lens parameters, then the delay.
std::vector<std::string> rolling_names(const RollingProblem& all);

/// Solves, estimates the noise of the corners with the freedoms that the priors leave, rejects
/// outliers where the config asks for it, and again. `iterations` grows; `squares` is the sum of
/// those of whitened residuals. @return what went wrong, or ""
std::string solve_rolling(RollingProblem& all, RollingState& state, RollingCovariance& covariance,
                          int& iterations, double& squares);

}  // namespace cousin
