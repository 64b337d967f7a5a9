#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// Prints that cameras are calibrated with.
enum class TargetKind {
  chessboard,          ///< black where column + row is even, counted from the upper left square
  charuco,             ///< the same, markers in the white squares: OpenCV 4.6's cv::aruco
  april_grid,          ///< tag36h11 in Kalibr's layout: black border of two bits, squares between
  circles,             ///< black discs on a square lattice
  asymmetric_circles,  ///< black discs, each second row half a step to the right
  seed_board,          ///< sim/types/board.h
};
std::string_view to_string(TargetKind kind);
/// @throws std::invalid_argument naming the text and the names that exist.
TargetKind target_kind_from_string(std::string_view text);

/// A print as it was designed: what one knows who reads the images. Frame: origin at the middle of
/// the print, x to the right and y up when it is read upright, z out of the face.
struct CalibrationTarget {
  TargetKind kind = TargetKind::chessboard;
  int columns = 10;  ///< squares, tags or discs in a row
  int rows = 7;
  /// Side of a square or a tag; distance between the centres of discs. Of asymmetric circles: from
  /// row to row, and half of that from disc to disc in a row.
  double pitch_m = 0.025;
  /// charuco: marker over square; april_grid: space between tags over tag; circles: radius over
  /// pitch; seed_board: marker over square, 0 = no markers; chessboard: not used.
  double mark_share = 0;
  std::string dictionary;  ///< charuco: of cv::aruco, such as DICT_5X5_100; else ""

  bool operator==(const CalibrationTarget&) const = default;
};
/// Sizes and numbers; what a dictionary holds is known to who draws the markers.
/// @throws std::invalid_argument naming the field, its value and the limit.
void validate(const CalibrationTarget& target);

/// Width and height of what is printed, without margins.
Eigen::Vector2d print_size_m(const CalibrationTarget& target);

/// A corner where squares meet, or a disc's centre.
struct TargetPoint {
  int id = 0;
  int column = 0, row = 0;  ///< of the points' own lattice, in the direction that ids run
  Eigen::Vector2d at_m;
};
/// All points, by id. Chessboard, charuco and both kinds of circles: row by row from the upper
/// left, as OpenCV numbers them. April grid: the tags' corners, row by row from the lower left, as
/// Kalibr numbers them. Seed board: as sim/types/board.h, without the corners that do not exist.
std::vector<TargetPoint> target_points(const CalibrationTarget& target);

/// One line: "charuco columns=11 rows=8 pitch_m=0.02 mark_share=0.75 dictionary=DICT_4X4_50". Reads
/// back equal. Datasets name their board so.
std::string to_text(const CalibrationTarget& target);
/// @throws std::invalid_argument naming what is wrong in the text.
CalibrationTarget target_from_text(std::string_view text);

}  // namespace cousin
