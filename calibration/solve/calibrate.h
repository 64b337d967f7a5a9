#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/boards/target_view.h"
#include "sim/config/fields.h"
#include "sim/types/calibration_target.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// `opencv`: cv::calibrateCameraExtended and cv::fisheye::calibrate, or cv::stereoCalibrate of the
/// points that both of two cameras see. `ceres`: our own cost, all lens models, several cameras.
/// `mrcal`: through its C API, several cameras of one lens model.
enum class CalibrationSolver { opencv, ceres, mrcal };
std::string_view to_string(CalibrationSolver solver);
/// @throws std::invalid_argument naming the text and the names that exist.
CalibrationSolver calibration_solver_from_string(std::string_view text);

enum class RobustLoss { none, huber, cauchy };

/// A camera of the rig before it is calibrated. Its model, image size and, for a splined lens, the
/// surface's order, columns, rows and field of view count always.
struct CalibrationCamera {
  Camera start;  ///< fx_px = 0: the start is found from the views; else it is taken from here
  int shares_lens_with = -1;  ///< index of an earlier camera with the same lens; -1 = its own
};

/// What a calibration starts from. Lengths may be in any unit: the result is in the same.
struct CalibrationInput {
  std::vector<Eigen::Vector3d> target_m;  ///< by id, in the target's frame; flat to a tenth
  std::vector<CalibrationCamera> cameras;
  std::vector<TargetView> views;  ///< those that are not usable are passed over
};
/// One camera for each of `cameras`; points of the target where they were designed.
CalibrationInput calibration_input(const CalibrationTarget& target, std::vector<TargetView> views,
                                   const std::vector<Camera>& cameras);

/// A parameter is named "fx_px", "fy_px", "cx_px", "cy_px", "k1".."k6", "p1", "p2", "s1".."s4", or
/// for a splined lens "u0_x", "u0_y", ... in `fixed`; with "camera1." before it in results.
struct CalibrationConfig {
  CalibrationSolver solver = CalibrationSolver::ceres;
  std::vector<std::string> fixed;    ///< stay at their start: given, or 0 for distortion
  bool board_deformation = false;    ///< z += kx (1 - x^2) + ky (1 - y^2), x and y from -1 to 1
  bool weigh_by_covariance = false;  ///< residuals over their predicted deviation (ceres)
  RobustLoss loss = RobustLoss::none;
  double loss_px = 1;            ///< where the loss turns
  double reject_sigmas = 0;      ///< 0 = no outlier pass; else reject and solve again
  double focal_prior_share = 0;  ///< relative deviation of the given focal lengths; 0 = none
  double centre_prior_px = 0;    ///< deviation of the given principal point; 0 = none
  double distortion_prior = 0;   ///< deviation of each given coefficient; 0 = none
  double spline_prior = 10;      ///< deviation of each control point about 0, for those unseen
  double deformation_prior_share = 0;  ///< deviation of kx, ky over the target's size; 0 = none
  int max_iterations = 200;
  double tolerance = 1e-16;            ///< relative, of the cost between two steps
  double max_focal_share = 0.02;       ///< above this relative deviation fx, fy are not determined
  double max_centre_share = 0.03;      ///< of the image's width, for cx, cy
  double max_deviation_share = 0.003;  ///< RMS over the image of the projection's deviation, of the
                                       ///< image's width
};
Fields fields(CalibrationConfig& config);
void validate(const CalibrationConfig& config);

/// `not_determined`: the views do not fix some parameters, which are named; the numbers are only
/// there to look at. `bad_input`: too few points, ids that do not exist, an option the solver
/// lacks.
enum class CalibrationStatus { ok, not_determined, not_converged, bad_input, not_built };
std::string_view to_string(CalibrationStatus status);

/// Of one observation that was used or rejected.
struct CalibrationResidual {
  int view = 0;  ///< index into the input's views
  int id = 0;
  Eigen::Vector2d residual_px;  ///< predicted minus observed
  bool rejected = false;
};

struct CalibrationFrame {
  int frame = 0;
  Pose rig_from_target;
};

/// RMS is per coordinate everywhere: sqrt(sum of squares / number of coordinates), rejected
/// observations left out.
struct CalibrationResult {
  CalibrationStatus status = CalibrationStatus::not_converged;
  std::string reason;                       ///< unless ok: what and why
  std::vector<std::string> not_determined;  ///< parameters
  std::vector<Camera> cameras;
  std::vector<Pose> camera_from_rig;     ///< the first is the identity: the rig is camera 0
  std::vector<CalibrationFrame> frames;  ///< ascending
  Eigen::Vector2d deformation_m = Eigen::Vector2d::Zero();  ///< kx, ky
  std::vector<CalibrationResidual> residuals;
  /// Names of what was solved for but the frames' poses: lenses, then poses of cameras 1..
  /// (rotation vector rad, translation) as "camera1.r_x", "camera1.t_x", then "kx_m", "ky_m".
  std::vector<std::string> parameters;
  Eigen::VectorXd values;      ///< of `parameters`; rotations of a camera as its rotation vector
  Eigen::MatrixXd covariance;  ///< of `parameters`, poses marginalised; residual variance included
  /// How all frames move together when `parameters` move: the mean over frames of the twist
  /// (rotation rad, translation) about the rig's origin is `mean_frame_gain` times their change,
  /// plus a part of its own with `mean_frame_covariance`. For calibration_uncertainty.h.
  Eigen::MatrixXd mean_frame_gain;
  Eigen::Matrix<double, 6, 6> mean_frame_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Of a point's coordinate: sqrt(squares / (2 N - p)). Where residuals are weighed, that is
  /// `noise_factor`, what predicted deviations are to be multiplied with (near 1 if they are
  /// honest), and sigma_px is it times the RMS of the predicted ones.
  double sigma_px = std::numeric_limits<double>::quiet_NaN();
  double noise_factor = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not weighed
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  double cost_px2 = std::numeric_limits<double>::quiet_NaN();  ///< sum of squares (robust, weighed)
  double solver_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< as the solver defines it
  std::string solver_rms_name;                                      ///< which definition that is
  /// OpenCV only: its own deviations of `parameters` (NaN where it gives none). OpenCV 4.6 divides
  /// by points instead of coordinates less parameters [opencv#19803]: `corrected` is multiplied by
  /// sqrt((N - p) / (2 N - p)).
  Eigen::VectorXd solver_deviations, corrected_deviations;
  int observations = 0;  ///< points that count
  int rejected = 0;
  /// Of those that count: more than ten robust deviations of all residuals off, and 0.1 px: wrong
  /// detections that pull at the result, since no outlier pass or robust loss was asked for.
  int outliers = 0;
  int iterations = 0;
  double seconds = 0;  ///< wall, all of it
};

/// Calibrates the cameras from views of a target. Same answer for any unit of length and place of
/// the target's origin. The start is Zhang's closed form or, for wide lenses, a search over focal
/// lengths; then the poses, the core, all. Deterministic.
/// @throws std::invalid_argument for an invalid config
[[nodiscard]] CalibrationResult calibrate(const CalibrationInput& input,
                                          const CalibrationConfig& config = {});

/// Ceres, or OpenCV where the program is built without.
CalibrationSolver default_calibration_solver();

/// Index of a name in `result.parameters`, or -1.
int parameter_index(const CalibrationResult& result, std::string_view name);
/// Deviation of a parameter: the root of its variance; NaN for a name that was not solved for.
double deviation(const CalibrationResult& result, std::string_view name);

}  // namespace cousin
