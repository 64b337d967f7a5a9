#pragma once

#include <Eigen/Core>

#include "sim/dataset/json_interop.h"

namespace cousin {

/// A covariance of n numbers, row-major in an array. @throws std::runtime_error where it is not
/// symmetric or not positive semi-definite, up to rounding and whatever the units
Eigen::MatrixXd covariance_from(const JsonNode& node, Eigen::Index n);

}  // namespace cousin
