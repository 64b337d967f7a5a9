#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/devices/rolling_chain.h"
#include "calibration/solve/calibration_problem.h"
#include "sim/types/pose.h"

namespace cousin {

/// A rolling shutter's calibration in the units of `problem`, its views in the order of time.
/// Private to calibration.
struct RollingProblem {
  CalibrationProblem problem;
  std::vector<double> gap_s;     ///< from view i to view i + 1; 0: not neighbours
  double reference_delay_s = 0;  ///< a row, of views without neighbours and where it is given
  bool delay_is_free = false;
  Vector6d velocity_sigma = Vector6d::Ones();      ///< of views without neighbours
  Vector6d acceleration_sigma = Vector6d::Ones();  ///< a step
  double noise = 1;                                ///< deviation of a whitened residual
};

struct RollingState {
  Eigen::VectorXd lens;
  std::vector<Pose> poses;           ///< camera_from_target at the middle row
  std::vector<Vector6d> velocities;  ///< omega, w
  double delay_s = 0;
};

/// Normal equations: a view's 12 are a turn of the camera's axes, a shift, then its velocity;
/// shared are the lens's free parameters and, where it is free, the delay.
struct RollingSystem {
  FrameChain chain, chain_of_priors;
  Eigen::MatrixXd mixed;  ///< 12 rows a view
  Eigen::MatrixXd shared;
  Eigen::VectorXd shared_priors;        ///< their part of its diagonal
  Eigen::VectorXd right, shared_right;  ///< gradients
  double cost = 0;     ///< half the sum of squares is not taken; infinite: a point has no pixel
  double squares = 0;  ///< of whitened residuals, before `noise`
  int coordinates = 0;
};

bool has_neighbour(const RollingProblem& problem, std::size_t view);
/// Delay that a view's motion is multiplied with.
double delay_of(const RollingProblem& problem, const RollingState& state, std::size_t view);

/// Predicted less observed, before whitening; NaN where a point has no pixel.
std::vector<Eigen::Vector2d> rolling_residuals(const RollingProblem& problem,
                                               const RollingState& state, std::size_t view);
RollingSystem rolling_system(const RollingProblem& problem, const RollingState& state);

/// Minimises from `state`. @return iterations, or -1 if it did not converge in `most`
int minimise_rolling(const RollingProblem& problem, RollingState& state, int most);

}  // namespace cousin
