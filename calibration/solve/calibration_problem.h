#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"
#include "calibration/solve/lens_value.h"
#include "calibration/solve/observation_cost.h"

namespace cousin {

struct ProblemPoint {
  int id = 0;
  Eigen::Vector2d pixel_px;
  Eigen::Matrix2d white = Eigen::Matrix2d::Identity();  ///< times a residual, before the loss
  bool rejected = false;
};

struct ProblemView {
  int input_view = 0;
  int camera = 0;
  int frame = 0;  ///< index into `frames`
  bool half_turn_unknown = false;
  std::vector<ProblemPoint> points;
};

struct ProblemLens {
  LensShape shape;
  Camera like;  ///< model, size and what was given
  bool given = false;
  std::vector<bool> free;       ///< for each parameter
  Eigen::VectorXd prior_mean;   ///< for each parameter
  Eigen::VectorXd prior_sigma;  ///< infinity: none
};

/// A calibration in units in which the target's points lie about the origin with a root mean square
/// distance of 1, so that neither the unit of length nor the target's origin matters.
struct CalibrationProblem {
  CalibrationConfig config;
  std::vector<Eigen::Vector3d> target;
  std::vector<Eigen::Vector2d> board;  ///< target's points from -1 to 1, for the deformation
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double unit_m = 1;
  std::vector<ProblemLens> lenses;
  std::vector<int> lens_of_camera;
  std::vector<ProblemView> views;  ///< by frame, then as they came
  std::vector<int> frames;         ///< their numbers, ascending
};

/// What is solved for.
struct CalibrationState {
  std::vector<Eigen::VectorXd> lenses;
  std::vector<Vector6d> cameras;  ///< camera_from_rig; the first is zero
  std::vector<Vector6d> frames;   ///< rig_from_target
  Eigen::Vector2d deformation = Eigen::Vector2d::Zero();
};

/// @param complaint  set where the input cannot be used at all
CalibrationProblem make_problem(const CalibrationInput& input, const CalibrationConfig& config,
                                std::string& complaint);

/// A target's point with the board's deformation, and the derivative of its z by kx and ky.
Eigen::Vector3d deformed(const CalibrationProblem& problem, int id,
                         const Eigen::Vector2d& deformation);
Eigen::Vector2d d_deformation(const CalibrationProblem& problem, int id);

/// Residuals of a view at a state; NaN where a point has no pixel.
std::vector<Eigen::Vector2d> residuals_of(const CalibrationProblem& problem,
                                          const CalibrationState& state, const ProblemView& view);

/// `deviation` of whitened residuals as the result's sigma_px and, if they are weighed, factor.
void describe_noise(const CalibrationProblem& problem, double deviation, CalibrationResult& result);

/// Points that count, in all views.
int observation_count(const CalibrationProblem& problem);
/// Free parameters of lenses, cameras and deformation; `with_frames`: and of all frames' poses.
int free_parameter_count(const CalibrationProblem& problem, bool with_frames);

}  // namespace cousin
