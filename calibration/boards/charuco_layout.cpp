#include "calibration/boards/charuco_layout.h"

#include <stdexcept>
#include <string>

namespace cousin {

std::string_view to_string(CharucoLayout layout) {
  return layout == CharucoLayout::legacy ? "legacy" : "current";
}

CharucoLayout charuco_layout_from_string(std::string_view text) {
  for (const CharucoLayout layout : {CharucoLayout::current, CharucoLayout::legacy}) {
    if (text == to_string(layout)) return layout;
  }
  throw std::invalid_argument("layout \"" + std::string(text) + "\" is not one of current, legacy");
}

bool has_two_layouts(const CalibrationTarget& target) {
  return target.kind == TargetKind::charuco && target.rows % 2 == 0;
}

bool is_first_square_black(const CalibrationTarget& target, CharucoLayout layout) {
  return !has_two_layouts(target) || layout == CharucoLayout::current;
}

}  // namespace cousin
