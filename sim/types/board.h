#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace cousin {

/// The seed board: a square plate with a checkerboard of `squares` x `squares` centred on it. World
/// frame = board frame: origin at the plate's centre, z up out of the printed face, which is z = 0;
/// x to the right and y up when the print is read upright. Square (column, row) counts from the
/// lower left (-x, -y) corner and is black where column + row is even. With markers, each corner
/// block of 3 x 3 squares is white and holds a marker of 4 x 4 bits with a black border one bit
/// wide (OpenCV's DICT_4X4_50), centred in its block.
struct SeedBoard {
  double plate_m = 0.100;
  int squares = 15;
  double square_m = 0.006;
  bool has_markers = true;
  double marker_m = 0.016;  ///< side of the black border
  /// Marker ids of the lower-left, lower-right, upper-right and upper-left blocks.
  std::array<int, 4> marker_ids = {0, 1, 2, 3};
};
/// @throws std::invalid_argument if squares do not fit on the plate or markers in their blocks.
void validate(const SeedBoard& board);

/// Inner corner (column, row), each in [0, squares - 2]: where four squares meet.
/// Its index is row * (squares - 1) + column. In metres, z = 0.
Eigen::Vector3d corner_in_world_m(const SeedBoard& board, int column, int row);
/// False for corners inside or on the edge of a marker's block: there four squares do not meet.
bool corner_exists(const SeedBoard& board, int column, int row);

/// Side in bits of a marker including its border.
inline constexpr int kMarkerModules = 6;
/// Whether module (column from the left, row from the top) of a marker read upright is black.
/// @throws std::invalid_argument for an id other than 0..3.
bool marker_module_black(int id, int column, int row);
/// Corners of marker `index` (into marker_ids) in OpenCV's order: top-left, top-right,
/// bottom-right, bottom-left of the upright marker; z = 0.
std::array<Eigen::Vector3d, 4> marker_corners_in_world_m(const SeedBoard& board, int index);

/// Print reflectance class at a point of the face: true = black ink. Outside the checkerboard:
/// white.
bool is_black(const SeedBoard& board, double x_m, double y_m);

}  // namespace cousin
