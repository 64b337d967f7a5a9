#include "sim/types/board.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

/// Inner 4 x 4 bits of ids 0..3 of OpenCV's DICT_4X4_50, row by row from the top, 1 = white.
constexpr std::array<std::array<const char*, 4>, 4> kBits = {{
    {"1011", "0101", "0011", "0010"},
    {"0000", "1111", "1001", "1010"},
    {"0011", "0011", "0010", "1101"},
    {"1001", "1001", "0100", "0110"},
}};
constexpr int kBlockSquares = 3;

/// Lower-left square of a marker's corner block.
std::array<int, 2> block_of(const SeedBoard& board, int index) {
  const int far = board.squares - kBlockSquares;
  constexpr std::array<std::array<int, 2>, 4> kSide = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const auto& side = kSide.at(static_cast<std::size_t>(index));
  return {side[0] * far, side[1] * far};
}

double half_grid_m(const SeedBoard& board) { return 0.5 * board.squares * board.square_m; }

Eigen::Vector2d marker_centre_m(const SeedBoard& board, int index) {
  const auto [column, row] = block_of(board, index);
  return Eigen::Vector2d(column + 0.5 * kBlockSquares, row + 0.5 * kBlockSquares) * board.square_m -
         Eigen::Vector2d::Constant(half_grid_m(board));
}

}  // namespace

void validate(const SeedBoard& board) {
  if (board.squares < 4 || board.squares > 1000 || !(board.square_m > 0) || !(board.plate_m > 0) ||
      !std::isfinite(board.plate_m)) {
    throw std::invalid_argument("board: squares must be 4..1000, square_m and plate_m positive");
  }
  if (board.squares * board.square_m > board.plate_m * (1 + 1e-9)) {
    throw std::invalid_argument("board: " + std::to_string(board.squares) + " squares of " +
                                std::to_string(board.square_m) +
                                " m do not fit on plate_m = " + std::to_string(board.plate_m));
  }
  if (board.has_markers &&
      (!(board.marker_m > 0) || board.marker_m > kBlockSquares * board.square_m ||
       board.squares < 2 * kBlockSquares + 1)) {
    throw std::invalid_argument("board: marker_m = " + std::to_string(board.marker_m) +
                                " does not fit in 3 squares, or the blocks overlap");
  }
}

Eigen::Vector3d corner_in_world_m(const SeedBoard& board, int column, int row) {
  return {(column + 1) * board.square_m - half_grid_m(board),
          (row + 1) * board.square_m - half_grid_m(board), 0};
}

bool corner_exists(const SeedBoard& board, int column, int row) {
  const int last = board.squares - 2;
  if (column < 0 || row < 0 || column > last || row > last) return false;
  if (!board.has_markers) return true;
  const bool outer_column = column < kBlockSquares || column > last - kBlockSquares;
  const bool outer_row = row < kBlockSquares || row > last - kBlockSquares;
  return !(outer_column && outer_row);
}

bool marker_module_black(int id, int column, int row) {
  if (id < 0 || id >= static_cast<int>(kBits.size())) {
    throw std::invalid_argument("marker id " + std::to_string(id) + " is not in 0..3");
  }
  if (column <= 0 || row <= 0 || column >= kMarkerModules - 1 || row >= kMarkerModules - 1)
    return true;
  return kBits[static_cast<std::size_t>(id)][static_cast<std::size_t>(row - 1)][column - 1] == '0';
}

std::array<Eigen::Vector3d, 4> marker_corners_in_world_m(const SeedBoard& board, int index) {
  const Eigen::Vector2d c = marker_centre_m(board, index);
  const double h = 0.5 * board.marker_m;
  return {Eigen::Vector3d(c.x() - h, c.y() + h, 0), Eigen::Vector3d(c.x() + h, c.y() + h, 0),
          Eigen::Vector3d(c.x() + h, c.y() - h, 0), Eigen::Vector3d(c.x() - h, c.y() - h, 0)};
}

bool is_black(const SeedBoard& board, double x_m, double y_m) {
  const double half = half_grid_m(board);
  const int column = static_cast<int>(std::floor((x_m + half) / board.square_m));
  const int row = static_cast<int>(std::floor((y_m + half) / board.square_m));
  if (column < 0 || row < 0 || column >= board.squares || row >= board.squares) return false;
  if (board.has_markers) {
    for (int index = 0; index < 4; ++index) {
      const auto [first_column, first_row] = block_of(board, index);
      if (column < first_column || row < first_row || column >= first_column + kBlockSquares ||
          row >= first_row + kBlockSquares) {
        continue;
      }
      const Eigen::Vector2d centre = marker_centre_m(board, index);
      const double module_m = board.marker_m / kMarkerModules;
      const double u = (x_m - centre.x()) / module_m + 0.5 * kMarkerModules;
      const double v = (centre.y() - y_m) / module_m + 0.5 * kMarkerModules;
      if (u < 0 || v < 0 || u >= kMarkerModules || v >= kMarkerModules) return false;
      return marker_module_black(board.marker_ids.at(static_cast<std::size_t>(index)),
                                 static_cast<int>(u), static_cast<int>(v));
    }
  }
  return (column + row) % 2 == 0;
}

}  // namespace cousin
