#include "sim/types/board.h"

#include <gtest/gtest.h>

namespace cousin {
namespace {

TEST(SeedBoard, FourSquaresMeetInAlternatingColoursAtEveryCornerThatExists) {
  const SeedBoard board;
  validate(board);
  int count = 0;
  for (int row = 0; row < board.squares - 1; ++row) {
    for (int column = 0; column < board.squares - 1; ++column) {
      const Eigen::Vector3d c = corner_in_world_m(board, column, row);
      constexpr double kStep = 1e-4;
      const bool a = is_black(board, c.x() - kStep, c.y() - kStep);
      const bool b = is_black(board, c.x() + kStep, c.y() - kStep);
      const bool d = is_black(board, c.x() - kStep, c.y() + kStep);
      const bool e = is_black(board, c.x() + kStep, c.y() + kStep);
      EXPECT_EQ(corner_exists(board, column, row), a == e && b == d && a != b)
          << column << ", " << row;
      count += corner_exists(board, column, row) ? 1 : 0;
    }
  }
  EXPECT_EQ(count, 14 * 14 - 4 * 9);
}

TEST(SeedBoard, MarkersAreBorderedInTheirBlocks) {
  const SeedBoard board;
  for (int index = 0; index < 4; ++index) {
    const auto corners = marker_corners_in_world_m(board, index);
    const Eigen::Vector3d centre = (corners[0] + corners[2]) / 2;
    for (const Eigen::Vector3d& corner : corners) {
      const Eigen::Vector3d inside = corner + 0.02 * (centre - corner);
      const Eigen::Vector3d outside = corner - 0.02 * (centre - corner);
      EXPECT_TRUE(is_black(board, inside.x(), inside.y()));
      EXPECT_FALSE(is_black(board, outside.x(), outside.y()));
    }
    EXPECT_GT(corners[0].y(), corners[3].y());  // top-left is above bottom-left, left of top-right
    EXPECT_LT(corners[0].x(), corners[1].x());
  }
}

TEST(SeedBoard, PlainBoardHasAllCornersAndTheMarkersOfTheOtherDiffer) {
  SeedBoard plain;
  plain.has_markers = false;
  EXPECT_TRUE(corner_exists(plain, 0, 0));
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < a; ++b) {
      int different = 0;
      for (int i = 1; i < 5; ++i) {
        for (int j = 1; j < 5; ++j)
          different += marker_module_black(a, i, j) != marker_module_black(b, i, j);
      }
      EXPECT_GE(different, 4);  // the dictionary's distance
    }
  }
}

TEST(SeedBoard, RefusesSquaresThatDoNotFit) {
  SeedBoard board;
  board.squares = 17;
  EXPECT_THROW(validate(board), std::invalid_argument);
  board = {};
  board.marker_m = 0.019;
  EXPECT_THROW(validate(board), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
