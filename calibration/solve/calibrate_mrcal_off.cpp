#include "calibration/solve/calibration_solvers.h"

namespace cousin {

SolverRun solve_with_mrcal(CalibrationProblem&, CalibrationState&) {
  SolverRun run;
  run.status = CalibrationStatus::not_built;
  run.reason = "not built in: mrcal (WITH_MRCAL=OFF)";
  return run;
}

}  // namespace cousin
