#pragma once

#include <Eigen/Core>

#include "sim/types/image.h"

namespace cousin {

/// Writes a whole number, at least 0, in white digits on black about a pixel; what lies outside the
/// image is cut. @param dot_px  side of a digit's dots, of which it has 3 by 5
void write_number(Image<Rgb8>& image, int number, const Eigen::Vector2d& at_px, int dot_px);

}  // namespace cousin
