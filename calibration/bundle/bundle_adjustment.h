#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"
#include "sim/config/fields.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// A point that one image shows.
struct BundleObservation {
  int image = 0;
  int point = 0;
  Eigen::Vector2d pixel_px;
  double sigma_px = 1;  ///< each coordinate's, up to a factor that all share
};
/// A point whose place is known, such as a corner of a board: it fixes scale and frame.
struct KnownPoint {
  int point = 0;
  Eigen::Vector3d in_world_m;
  double sigma_m = 1e-5;
};
/// Two points whose distance is known: it fixes the scale.
struct KnownDistance {
  int point_a = 0, point_b = 0;
  double length_m = 0;
  double sigma_m = 1e-5;
};

/// Where a bundle adjustment starts. Lengths may be in any unit; the result is in the same.
struct BundleAdjustmentInput {
  std::vector<Camera> lenses;
  std::vector<int> lens_of_image;  ///< all the same: shared; each its own: per image
  std::vector<Pose> camera_from_world;
  std::vector<Eigen::Vector3d> points_in_world_m;
  std::vector<BundleObservation> observations;
  std::vector<KnownPoint> known_points;
  std::vector<KnownDistance> known_distances;
};

struct BundleAdjustmentConfig {
  std::vector<std::string> fixed;  ///< names as in CalibrationConfig; "lens" = every parameter
  RobustLoss loss = RobustLoss::none;
  double loss_px = 1;             ///< where the loss turns, in units of `sigma_px`
  double reject_sigmas = 0;       ///< 0 = no outlier pass; else reject and solve again
  double min_parallax_rad = 0.0;  ///< points whose rays part by less are left out
  double focal_prior_share = 0;   ///< relative deviation of the given focal lengths; 0 = none
  double centre_prior_px = 0;     ///< deviation of the given principal point; 0 = none
  double distortion_prior = 0;    ///< deviation of each given coefficient; 0 = none
  /// Relative deviation of the factor by which each image's focal lengths differ from its lens's (a
  /// camera that focuses anew): one more unknown an image; 0 = none.
  double zoom_share = 0;
  int max_iterations = 100;
  double tolerance = 1e-12;            ///< relative, of the cost between two steps
  double max_focal_share = 0.02;       ///< above this relative deviation fx, fy are not determined
  double max_centre_share = 0.03;      ///< of the image's width, for cx, cy
  double max_deviation_share = 0.003;  ///< RMS over the image of the projection's deviation, of the
                                       ///< image's width, for distortion
};
Fields fields(BundleAdjustmentConfig& config);
void validate(const BundleAdjustmentConfig& config);

/// Of the seven freedoms of a similarity, which the images leave: none with known points that are
/// not on a line, six with a known distance, else all.
enum class BundleGauge { metric, rigid, similarity };
std::string_view to_string(BundleGauge gauge);

struct BundleAdjustmentResult {
  CalibrationStatus status = CalibrationStatus::not_converged;
  std::string reason;                       ///< unless ok: what and why
  std::vector<std::string> not_determined;  ///< "lens0.k1" and the like
  bool folds = false;  ///< a lens folds inside its image, so that it is none: `not_determined`
  BundleGauge gauge = BundleGauge::similarity;
  std::vector<Camera> lenses;
  std::vector<Pose> camera_from_world;
  /// Of each image: its focal lengths over its lens's. These are the mean of its images', where
  /// they are free.
  std::vector<double> zoom;
  /// NaN: no place. Fewer than two images show it, or do after rejection, or its rays are too near
  /// parallel.
  std::vector<Eigen::Vector3d> points_in_world_m;
  std::vector<bool> rejected;           ///< of the observations of points not left out
  std::vector<std::string> parameters;  ///< "lens0.fx_px": free ones
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;  ///< of `parameters`, poses and points marginalised; of any gauge
  /// Of each image's pose: camera-side rotation vector (rad), translation. Where the gauge is free,
  /// that of the least trace (inner constraints): the frame that all images hold together.
  std::vector<Eigen::Matrix<double, 6, 6>> pose_covariance;
  double sigma_px = std::numeric_limits<double>::quiet_NaN();  ///< sqrt(squares / freedoms)
  double rms_px = std::numeric_limits<double>::quiet_NaN();    ///< per coordinate
  double cost_px2 = std::numeric_limits<double>::quiet_NaN();
  int iterations = 0;
  double seconds = 0;
};

/// Least squares of all lenses, poses and points at once, by the cost that calibrations use
/// (observation_cost.h). Solved about the cameras' middle in units of their spread, so that neither
/// the unit nor the origin matters; where the gauge is free the frame stays the start's, by the
/// similarity (or rigid motion) that takes the cameras back to where they began with least squares.
/// Deterministic: one thread. Self-calibration from views that hardly turn about the line of sight
/// or look along parallel lines is `not_determined`, with the parameters [sensors: doming].
/// @throws std::invalid_argument for an invalid config
[[nodiscard]] BundleAdjustmentResult adjust_bundle(const BundleAdjustmentInput& input,
                                                   const BundleAdjustmentConfig& config = {});

/// Largest angle between two rays to a point, over the images that see it.
double parallax_rad(const BundleAdjustmentInput& input, int point);

}  // namespace cousin
