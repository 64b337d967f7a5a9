#pragma once

#include <string_view>

#include "sim/types/calibration_target.h"

namespace cousin {

/// Which squares of a charuco board are black; its markers stand in the others. With an odd number
/// of rows both are the same.
enum class CharucoLayout {
  current,  ///< the upper left one: OpenCV 4.6 and later
  legacy    ///< the lower left one: OpenCV up to 4.5, and CharucoBoard::setLegacyPattern
};
std::string_view to_string(CharucoLayout layout);
/// @throws std::invalid_argument naming the text and both names.
CharucoLayout charuco_layout_from_string(std::string_view text);

/// A charuco board with an even number of rows.
bool has_two_layouts(const CalibrationTarget& target);
/// Of a board of squares: the colour of its upper left one.
bool is_first_square_black(const CalibrationTarget& target, CharucoLayout layout);

}  // namespace cousin
