#pragma once

#include <string>
#include <vector>

namespace cousin {

/// The inner bits of one square marker as it stands upright, row by row from the top: true = white.
struct MarkerCode {
  int bits = 0;  ///< a side
  std::vector<bool> is_white;

  bool at(int column, int row) const {  ///< row from the top
    return is_white[static_cast<std::size_t>(row * bits + column)];
  }
};

/// The first `count` codes of a dictionary of cv::aruco, by id; AprilTag families too, upright as
/// cv::aruco sees them.
/// @param dictionary  "DICT_5X5_100" and the like. @throws std::invalid_argument naming those that
/// exist, or how many codes there are.
std::vector<MarkerCode> marker_codes(const std::string& dictionary, int count);

/// The same of tag36h11 as Kalibr prints it: turned by half a turn from cv::aruco's.
std::vector<MarkerCode> kalibr_codes(int count);

}  // namespace cousin
