#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// A colour that a configuration lists, and a colour that has been calculated with.
inline Eigen::Vector3d color_vector(const std::vector<double>& v) {
  return {v.at(0), v.at(1), v.at(2)};
}
inline Rgbf to_rgb(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace cousin
