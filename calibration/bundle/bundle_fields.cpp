#include "calibration/bundle/bundle_adjustment.h"
#include "calibration/solve/option_fields.h"
#include "sim/config/limits.h"

namespace cousin {

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
