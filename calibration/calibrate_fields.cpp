#include <algorithm>
#include <array>
#include <stdexcept>

#include "calibration/bundle_adjustment.h"
#include "calibration/calibrate.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<std::string_view, 3> kLosses = {"none", "huber", "cauchy"};

TextField loss_field(RobustLoss& loss) {
  return {
      [&loss] { return std::string(kLosses.at(static_cast<std::size_t>(loss))); },
      [&loss](const std::string& text) {
        const auto at = std::find(kLosses.begin(), kLosses.end(), text);
        if (at == kLosses.end())
          throw std::invalid_argument("loss \"" + text + "\" is not one of none, huber, cauchy");
        loss = static_cast<RobustLoss>(at - kLosses.begin());
      }};
}

/// Names parted by commas.
TextField names_field(std::vector<std::string>& names) {
  return {[&names] {
            std::string text;
            for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
            return text;
          },
          [&names](const std::string& text) {
            names.clear();
            for (std::size_t from = 0; from < text.size();) {
              const std::size_t to = std::min(text.find(',', from), text.size());
              if (to > from) names.push_back(text.substr(from, to - from));
              from = to + 1;
            }
          }};
}

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

Fields fields(BundleAdjustmentConfig& c) {
  return {
      {"fixed", names_field(c.fixed), "lens parameters that stay at their start; lens = all"},
      {"loss", loss_field(c.loss), "none, huber or cauchy"},
      {"loss_px", &c.loss_px, "where the loss turns, in sigmas", 1e-9, 1e9},
      {"reject_sigmas", &c.reject_sigmas, "0 = no outlier pass", 0, 1000},
      {"min_parallax_rad", &c.min_parallax_rad, "points seen under less are left out", 0, 3},
      {"focal_prior_share", &c.focal_prior_share, "of the given focal lengths; 0 = none", 0, 10},
      {"centre_prior_px", &c.centre_prior_px, "of the given principal point; 0 = none", 0, 1e6},
      {"distortion_prior", &c.distortion_prior, "of each given coefficient; 0 = none", 0, 1e6},
      {"zoom_share", &c.zoom_share, "by which images' focal lengths differ; 0 = none do", 0, 1},
      {"max_iterations", &c.max_iterations, "of the solver", 1, 100000},
      {"tolerance", &c.tolerance, "relative, of the cost between two steps", 0, 1},
      {"max_focal_share", &c.max_focal_share, "deviation above which f is not determined", 0, 1},
      {"max_centre_share", &c.max_centre_share, "the same of cx, cy, of the width", 0, 1},
      {"max_deviation_share", &c.max_deviation_share, "the same of the projection, of the width", 0,
       1},
  };
}

void validate(const BundleAdjustmentConfig& config) {
  BundleAdjustmentConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy));
}

}  // namespace cousin
