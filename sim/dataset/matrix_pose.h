#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

#include "sim/types/pose.h"

namespace cousin {

/// Private to sim/dataset: poses that other programs write as matrices of few digits.

/// The rotation nearest to a matrix. @throws std::invalid_argument with value and limit if an entry
/// of R R^T - 1 is above 1e-3, or the matrix mirrors.
Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& matrix);

/// @throws std::invalid_argument as nearest_rotation, and for a last row other than 0 0 0 1 or a
/// place beyond 1e9.
Pose pose_of_matrix(const Eigen::Matrix4d& a_from_b);

/// Of a text of 4 rows of 4 numbers; nothing where numbers are not finite, as programs write where
/// they have lost the camera. @throws std::runtime_error naming `name`, the line and the limit.
std::optional<Pose> pose_of_text(std::string_view text, const std::string& name);

}  // namespace cousin
