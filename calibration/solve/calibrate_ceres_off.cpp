#include "calibration/solve/calibration_solvers.h"

namespace cousin {

CalibrationSolver default_calibration_solver() { return CalibrationSolver::opencv; }

SolverRun solve_with_ceres(CalibrationProblem&, CalibrationState&) {
  SolverRun run;
  run.status = CalibrationStatus::not_built;
  run.reason = "not built in: Ceres (WITH_CERES=OFF)";
  return run;
}

}  // namespace cousin
