#pragma once

#include <nlohmann/json.hpp>

#include "benchmarks/report/report.h"

namespace cousin {

/// @throws std::invalid_argument naming the shape and what does not fit or cannot be drawn.
void validate(const ReportShape& shape);

/// A cloud of at most `limit` points: every k-th; of Gaussians those that hide most, by opacity
/// times area. The caption says so. Meshes stay whole.
ReportShape thinned(const ReportShape& shape, int limit);

/// What view3d.js draws. Base64 of little-endian codes: `positions` 16-bit shares of the box of
/// `size` metres; `colors` bytes; `triangles` 32-bit; of Gaussians `scales` 16-bit shares of the
/// range `log_scale` of their natural logarithms, `rotations` four signed bytes over 127 (w x y z),
/// `opacities` bytes over 255.
nlohmann::ordered_json shape_json(const ReportShape& shape);

}  // namespace cousin
