#include <string>

#include "calibration/solve/calibrate.h"
#include "calibration/solve/option_fields.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

TextField solver_field(CalibrationSolver& solver) {
  return {[&solver] { return std::string(to_string(solver)); },
          [&solver](const std::string& text) { solver = calibration_solver_from_string(text); }};
}

}  // namespace

Fields fields(CalibrationConfig& config) {
  return {
      {"solver", solver_field(config.solver), "opencv, ceres or mrcal"},
      {"fixed", names_field(config.fixed), "parameters that stay at their start: k3,p1"},
      {"board_deformation", &config.board_deformation, "solve for the board's bend, kx and ky"},
      {"weigh_by_covariance", &config.weigh_by_covariance,
       "residuals over the deviation that detection predicts (ceres)"},
      {"loss", loss_field(config.loss), "none, huber or cauchy (ceres)"},
      {"loss_px", &config.loss_px, "where the loss turns", 1e-6, 1e6},
      {"reject_sigmas", &config.reject_sigmas, "outliers beyond are rejected; 0 = none", 0, 1e6},
      {"focal_prior_share", &config.focal_prior_share,
       "relative deviation of given focal lengths; 0 = none (ceres)", 0, 10},
      {"centre_prior_px", &config.centre_prior_px,
       "deviation of a given principal point; 0 = none (ceres)", 0, 1e6},
      {"distortion_prior", &config.distortion_prior,
       "deviation of each coefficient about its start; 0 = none (ceres)", 0, 1e6},
      {"spline_prior", &config.spline_prior, "deviation of a spline's control points about 0", 1e-6,
       1e6},
      {"deformation_prior_share", &config.deformation_prior_share,
       "deviation of kx, ky over the target's size; 0 = none (ceres)", 0, 10},
      {"max_iterations", &config.max_iterations, "of the last stage", 1, 100000},
      {"tolerance", &config.tolerance, "relative, of the cost between two steps", 0, 1},
      {"max_focal_share", &config.max_focal_share,
       "relative deviation above which fx, fy are not determined", 1e-9, 1e9},
      {"max_centre_share", &config.max_centre_share,
       "deviation over the width above which cx, cy are not determined", 1e-9, 1e9},
      {"max_deviation_share", &config.max_deviation_share,
       "RMS deviation of projection over the width above which a lens is not determined", 1e-9,
       1e9},
  };
}

void validate(const CalibrationConfig& config) {
  CalibrationConfig copy = config;
  check_limits(fields(copy));
}

}  // namespace cousin
