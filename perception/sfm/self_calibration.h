#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/bundle/bundle_adjustment.h"
#include "perception/sfm/sfm_model.h"
#include "sim/config/fields.h"

namespace cousin {

/// What about the views or the scene keeps a lens from being found without a board.
/// `flat_scene`: the points lie in a plane; `parallel_views`: the optical axes hardly differ;
/// `forward_motion`: the camera moves along its own axis; `little_parallax`: rays to the points
/// hardly part; `no_roll`: no image is turned about its line of sight, so that the principal point
/// and the views' tilts trade against each other.
enum class CalibrationWeakness {
  flat_scene,
  parallel_views,
  forward_motion,
  little_parallax,
  no_roll
};
std::string_view to_string(CalibrationWeakness weakness);

/// Measures of views and points, of any gauge.
struct ViewGeometry {
  double flatness = 0;      ///< smallest over middle root mean square spread of the points
  double axes_rad = 0;      ///< RMS angle of the optical axes from their mean
  double forward = 0;       ///< share of the cameras' spread that is along the mean axis
  double parallax_rad = 0;  ///< median over points of the largest angle between two rays
  double roll_rad = 0;      ///< RMS turn about the line of sight, against the images' common up
};
ViewGeometry view_geometry(const BundleAdjustmentInput& input);

struct SelfCalibrationConfig {
  BundleAdjustmentConfig adjust = {
      .loss = RobustLoss::cauchy, .loss_px = 0.5, .max_iterations = 300, .tolerance = 1e-10};
  /// Below (forward: above) these a weakness is named beside parameters that are not determined.
  double min_flatness = 0.05;
  double min_axes_rad = 0.15;
  double max_forward = 0.9;
  double min_parallax_rad = 0.05;
  double min_roll_rad = 0.15;
};
Fields fields(SelfCalibrationConfig& config);
void validate(const SelfCalibrationConfig& config);

struct SelfCalibration {
  /// `not_determined`: `lens` is only there to look at.
  CalibrationStatus status = CalibrationStatus::not_converged;
  std::string reason;                           ///< unless ok: what and why, with the weaknesses
  std::vector<std::string> not_determined;      ///< parameters: "fx_px"
  std::vector<CalibrationWeakness> weaknesses;  ///< those that hold, determined or not
  ViewGeometry geometry;
  Camera lens;
  std::vector<std::string> parameters;  ///< free ones
  Eigen::VectorXd values;               ///< of `parameters`
  Eigen::VectorXd deviations;           ///< of these; NaN where the covariance is not there
  Eigen::MatrixXd covariance;           ///< of these, poses and points marginalised
  /// Of a sighting, a coordinate, with residuals counted down as the loss does: below the noise
  /// where there is a loss.
  double sigma_px = 0;
  int observations = 0;  ///< that count
};

/// The lens of a model's images, one for all, from its tracks alone: nothing in the scene is known.
/// The gauge stays free (bundle_adjustment.h): a lens does not depend on it.
/// @param start  the lens model and where to start; none: the model's own lens
SelfCalibration self_calibrate(const SfmModel& model, const std::optional<Camera>& start,
                               const SelfCalibrationConfig& config = {});
SelfCalibration self_calibrate(const BundleAdjustmentInput& input,
                               const SelfCalibrationConfig& config = {});

/// Deviation of a parameter; NaN for a name that was not solved for.
double deviation(const SelfCalibration& result, std::string_view name);

}  // namespace cousin
