#pragma once

#include <map>
#include <string>

#include "calibration/solve/calibration_problem.h"

namespace cousin {

/// What a solver says beside the state it leaves.
struct SolverRun {
  CalibrationStatus status = CalibrationStatus::ok;
  std::string reason;
  std::vector<std::string> not_determined;
  int iterations = 0;
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< as the solver defines it
  std::string rms_name;
  std::map<std::string, double> deviations;  ///< the solver's own, by parameter
};

/// Each finds its start, unless `state` holds one, and solves. Views that no pose is found for are
/// dropped from the problem.
SolverRun solve_with_ceres(CalibrationProblem& problem, CalibrationState& state);
SolverRun solve_with_opencv(CalibrationProblem& problem, CalibrationState& state);
/// With `reject_sigmas` > 0 by mrcal's own outlier pass, at 4 sigmas.
SolverRun solve_with_mrcal(CalibrationProblem& problem, CalibrationState& state);

/// Lenses whose coefficients, all freed at once, may end in a high minimum.
inline bool is_rational(LensModel model) {
  return model == LensModel::opencv8 || model == LensModel::opencv12;
}

}  // namespace cousin
