#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"

namespace cousin {

/// Which rigid motion of the camera's coordinates does not count as an error of projection; a
/// calibration's frame is only known as well as its boards.
/// `mean_frames`: a point stays where it is in the frames of the boards, on average over the frames
/// [mrcal 2.2, "Projection uncertainty"]. It needs the poses' part of the solution, and says how
/// the uncertainty changes with distance: least where the boards were. `best_fit`: the motion that
/// brings the two projections nearest over the image, rotation for points at infinity. It needs the
/// lens' covariance only, and is what `projection_difference` measures, so it is the one to hold
/// against a true error map.
enum class ProjectionGauge { mean_frames, best_fit };

struct UncertaintyConfig {
  ProjectionGauge gauge = ProjectionGauge::best_fit;
  double distance_m = std::numeric_limits<double>::infinity();  ///< of the points; infinity allowed
  int columns = 16, rows = 12;                                  ///< of pixels over the image
};

/// Deviation of the projection at pixels spread evenly over the image, border included.
struct UncertaintyMap {
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> pixel_px;        ///< row by row
  std::vector<Eigen::Matrix2d> covariance_px2;  ///< NaN where the lens has no direction
};
/// First-order propagation of the result's covariance. @throws std::invalid_argument for a camera
/// that does not exist or a result without covariance
UncertaintyMap projection_uncertainty(const CalibrationResult& result, int camera,
                                      const UncertaintyConfig& config = {});

/// The same at pixels of one's own; for `best_fit` the fit is over the map's pixels.
std::vector<Eigen::Matrix2d> projection_uncertainty_at(
    const CalibrationResult& result, int camera, const std::vector<Eigen::Vector2d>& pixels_px,
    const UncertaintyConfig& config = {});

/// Deviation along the worst direction.
double worst_deviation_px(const Eigen::Matrix2d& covariance_px2);
/// Root mean square of worst deviations over the map; NaN pixels left out.
double rms_deviation_px(const UncertaintyMap& map);

/// Two lenses of one camera compared: b's pixel less a's of the points that a sees at its pixels,
/// after the motion of the camera that brings them nearest, over pixels where both have a value.
struct ProjectionDifference {
  Pose b_from_a;  ///< the implied motion; a rotation for points at infinity
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> pixel_px;                     ///< of a
  std::vector<Eigen::Vector2d> difference_px;                ///< NaN where a or b has none
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< of the length
  double max_px = std::numeric_limits<double>::quiet_NaN();
};
/// @param radius_px  only pixels within it of the image's middle decide the motion; 0 = all
/// @throws std::invalid_argument if the images differ in size
ProjectionDifference projection_difference(const Camera& a, const Camera& b,
                                           const UncertaintyConfig& config = {},
                                           double radius_px = 0);

/// Pixels of the map's grid that the calibration speaks for: within the hull of the camera's
/// observations grown by a twentieth of the image's width, and with a worst deviation below a
/// limit. Share of the image, and one flag for each of the map's pixels.
struct ValidRegion {
  std::vector<bool> valid;
  double share = 0;
};
ValidRegion valid_region(const CalibrationResult& result, const CalibrationInput& input, int camera,
                         const UncertaintyMap& map, double limit_px);

/// Cross-validation: the views in two halves (every second frame), each calibrated alone, and the
/// difference of the two lenses; beside it what their covariances predict for it. A difference well
/// above its prediction means that the model errs, not the corners.
struct CrossValidation {
  CalibrationStatus status = CalibrationStatus::not_converged;  ///< the worse half's
  std::string reason;                                           ///< and its
  ProjectionDifference difference;
  double predicted_rms_px = std::numeric_limits<double>::quiet_NaN();
};
CrossValidation cross_validate(const CalibrationInput& input, const CalibrationConfig& config,
                               int camera = 0);

}  // namespace cousin
