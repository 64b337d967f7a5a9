#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/types/camera.h"

namespace cousin {

/// Private to sim/types: `unproject` for many pixels of a camera whose monotone_limit is known.
std::optional<Eigen::Vector3d> unproject_within(const Camera& camera,
                                                const Eigen::Vector2d& pixel_px, double limit);

}  // namespace cousin
