#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"

namespace cousin {

/// An arm that carries a calibrated camera past a target that stays where it is.
struct HandEyeInput {
  Camera camera;
  std::vector<Eigen::Vector3d> target_m;  ///< by id
  struct Stop {
    Pose base_from_gripper;  ///< as the arm reports it
    TargetView view;
  };
  std::vector<Stop> stops;  ///< those whose view is not usable are passed over
};

struct HandEyeConfig {
  double corner_px = 0.1;         ///< deviation of a corner's coordinate
  double arm_m = 2e-4;            ///< deviation of each coordinate of the arm's position
  double arm_rad = 3.5e-4;        ///< and of its rotation about each axis
  double least_turn_rad = 0.05;   ///< RMS turn about a second axis, below which motions are refused
  double max_deviation_m = 2e-3;  ///< of the camera's place on the gripper
  double max_deviation_rad = 5e-3;
  int max_iterations = 50;
};
Fields fields(HandEyeConfig& config);
void validate(const HandEyeConfig& config);

struct HandEyeResult {
  CalibrationStatus status = CalibrationStatus::not_converged;
  std::string reason;                       ///< unless ok
  std::vector<std::string> not_determined;  ///< "rotation", "translation", along which axis
  Pose gripper_from_camera;
  Pose base_from_target;
  /// Of gripper_from_camera: rotation vector (rad) and translation (m) of an error in the gripper's
  /// frame; for the deviations of the config, enlarged where the corners fit worse.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double rms_px = std::numeric_limits<double>::quiet_NaN();     ///< per coordinate
  double arm_rms_m = std::numeric_limits<double>::quiet_NaN();  ///< what the arm was corrected by
  int stops = 0;
};

/// Hand-eye calibration: cv::calibrateHandEye [Park & Martin, TRA 1994] as the start, then least
/// squares on pixels and the arm's poses together, each stop's true pose of the arm being solved
/// for. Motions that leave the answer open are refused: fewer than three stops, no rotation, or all
/// rotations about one axis (the translation along it is free) [Tsai & Lenz, TRA 1989].
[[nodiscard]] HandEyeResult calibrate_hand_eye(const HandEyeInput& input,
                                               const HandEyeConfig& config = {});

}  // namespace cousin
