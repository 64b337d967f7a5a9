#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/bundle/bundle_problem.h"

namespace cousin {

/// Whether points leave a turn about them open: fewer than three, or across the line that fits them
/// best they spread by at most this share of what they do along it (root mean squares).
bool are_on_a_line(const Eigen::Matrix3Xd& points, double most_share);

/// Moves poses and points of a problem whose gauge is free back to where the cameras were: by the
/// similarity, or the rigid motion where a distance is known, of their centres in least squares
/// [Umeyama, TPAMI 1991]. Of centres on a line the cameras' own turns say what these leave open.
/// @param before  poses as in BundleProblem
void hold_frame(const std::vector<Vector6d>& before, BundleProblem& problem);

}  // namespace cousin
