#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/solve/calibration_problem.h"

namespace cousin {

/// The lens as given, or, without distortion, with the focal length of several tried (Zhang's
/// closed form [TPAMI 2000] with the principal point in the middle, and a ladder from wide to
/// narrow) under which the poses of up to five views fit best.
Eigen::VectorXd seed_lens(const CalibrationProblem& problem, int lens);

/// camera_from_target of each view through the given lenses; nothing where none is found.
std::vector<std::optional<Pose>> seed_view_poses(const CalibrationProblem& problem,
                                                 const std::vector<Eigen::VectorXd>& lenses);

/// A problem of one lens alone: its views, at most `most` of them, evenly chosen, each a frame of
/// its own camera.
CalibrationProblem single_lens_problem(const CalibrationProblem& problem, int lens, int most);

/// Frames and cameras from the views' poses: cameras join in the order of shared frames, each by
/// the pose between cameras that agrees best with those from all shared frames. Views without a
/// pose are dropped from the problem, then frames without views; views that may be turned by half
/// are renumbered to agree.
/// @return the cameras that share no frame with the others
std::vector<int> assemble_rig(CalibrationProblem& problem,
                              const std::vector<std::optional<Pose>>& poses,
                              CalibrationState& state);

}  // namespace cousin
