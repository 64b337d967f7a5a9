#include "scenes/boards/print_grid.h"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/aruco/charuco.hpp>
#include <stdexcept>

#include "scenes/boards/boards_scene.h"
#include "sim/types/board.h"

namespace cousin {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

struct Cell {
  Eigen::Vector2d middle_m;
  double area_m2 = 0;
  bool has_ink = false;
};

std::vector<Cell> cells(const PrintGrid& grid) {
  std::vector<Cell> result;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) {
      const Eigen::Vector2d &a = grid.at_m[grid.vertex(i, j)],
                            &b = grid.at_m[grid.vertex(i + 1, j)],
                            &c = grid.at_m[grid.vertex(i + 1, j + 1)],
                            &d = grid.at_m[grid.vertex(i, j + 1)];
      result.push_back({0.25 * (a + b + c + d), 0.5 * cross(c - a, d - b),
                        grid.has_ink[static_cast<std::size_t>(j * grid.columns + i)] != 0});
    }
  }
  return result;
}

TEST(PrintGrid, CoversThePlateOnceAndFoldsNowhere) {
  for (const std::string& name : board_names()) {
    const CalibrationTarget target = board_preset(name);
    const double margin_m = 0.013;
    const PrintGrid grid = print_grid(target, margin_m, 0.004);
    double area = 0;
    for (const Cell& cell : cells(grid)) {
      EXPECT_GT(cell.area_m2, 0) << name;
      area += cell.area_m2;
    }
    const Eigen::Vector2d size = print_size_m(target) + Eigen::Vector2d::Constant(2 * margin_m);
    EXPECT_NEAR(area, size.prod(), 1e-12) << name;  // rounding
  }
}

TEST(PrintGrid, CharucoIsWhatOpenCvDraws) {
  for (const auto& [columns, rows] : {std::pair{5, 4}, {4, 5}, {6, 7}, {5, 7}}) {
    const CalibrationTarget target{TargetKind::charuco, columns, rows, 0.03, 0.7, "DICT_5X5_100"};
    const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_100);
    const auto board = cv::aruco::CharucoBoard::create(columns, rows, 0.03F, 0.021F, dictionary);
    cv::Mat drawn;
    board->draw({columns * 200, rows * 200}, drawn, 0, 1);
    for (const Cell& cell : cells(print_grid(target, 0.01, 1))) {
      const Eigen::Vector2d at =
          (cell.middle_m.cwiseProduct(Eigen::Vector2d(1, -1)) + 0.5 * print_size_m(target)) / 0.03 *
          200;
      if ((at.array() < 0).any() || at.x() >= drawn.cols || at.y() >= drawn.rows) {
        EXPECT_FALSE(cell.has_ink);
        continue;
      }
      EXPECT_EQ(cell.has_ink,
                drawn.at<unsigned char>(static_cast<int>(at.y()), static_cast<int>(at.x())) == 0)
          << columns << " x " << rows << " at " << at.transpose();
    }
  }
}

TEST(PrintGrid, SeedBoardIsTheSeedScenes) {
  const SeedBoard board;
  for (const Cell& cell : cells(print_grid(board_preset("seeds"), 0.005, 1)))
    EXPECT_EQ(cell.has_ink, is_black(board, cell.middle_m.x(), cell.middle_m.y()));
}

TEST(PrintGrid, DiscsHaveTheirAreaAndMiddle) {
  for (const char* name : {"circles_a4", "acircles_a4"}) {
    const CalibrationTarget target = board_preset(name);
    const std::vector<TargetPoint> points = target_points(target);
    std::vector<double> area(points.size());
    std::vector<Eigen::Vector2d> moment(points.size(), Eigen::Vector2d::Zero());
    for (const Cell& cell : cells(print_grid(target, 0.01, 0.005))) {
      if (!cell.has_ink) continue;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector2d from = cell.middle_m - points[i].at_m;
        if (from.norm() > 0.5 * target.pitch_m) continue;
        area[i] += cell.area_m2;
        moment[i] += cell.area_m2 * from;
      }
    }
    const double radius_m = target.mark_share * target.pitch_m;
    const double whole = std::numbers::pi * radius_m * radius_m;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_NEAR(area[i], whole, 1e-9 * whole) << name;  // rounding
      EXPECT_LT(moment[i].norm(), 1e-9 * whole * radius_m) << name;
    }
  }
}

TEST(PrintGrid, EveryCornerIsAVertexBetweenInkAndPaper) {
  for (const char* name : {"chessboard_a4", "charuco_a4", "aprilgrid_a4", "seeds"}) {
    const CalibrationTarget target = board_preset(name);
    const PrintGrid grid = print_grid(target, 0.01, 0.005);
    for (const TargetPoint& point : target_points(target)) {
      double nearest = 1;
      int i0 = 0, j0 = 0;
      for (int j = 1; j < grid.rows; ++j) {
        for (int i = 1; i < grid.columns; ++i) {
          const double apart = (grid.at_m[grid.vertex(i, j)] - point.at_m).norm();
          if (apart >= nearest) continue;
          nearest = apart;
          i0 = i;
          j0 = j;
        }
      }
      EXPECT_LT(nearest, 1e-14) << name << ", id " << point.id;
      const auto ink = [&](int i, int j) {
        return grid.has_ink[static_cast<std::size_t>(j * grid.columns + i)];
      };
      // Four fields meet in alternating colours: of a tag and the squares that touch it, too.
      EXPECT_EQ(ink(i0, j0), ink(i0 - 1, j0 - 1)) << name << ", id " << point.id;
      EXPECT_EQ(ink(i0 - 1, j0), ink(i0, j0 - 1)) << name << ", id " << point.id;
      EXPECT_NE(ink(i0, j0), ink(i0 - 1, j0)) << name << ", id " << point.id;
    }
  }
}

TEST(PrintGrid, RefusesDictionariesThatAreTooSmallAndGridsThatAreTooFine) {
  CalibrationTarget target = board_preset("charuco_a4");
  target.columns = 14;  // 56 markers of 50
  EXPECT_THROW(print_grid(target, 0.01, 0.005), std::invalid_argument);
  target.dictionary = "DICT_4X4_51";
  EXPECT_THROW(print_grid(target, 0.01, 0.005), std::invalid_argument);
  target = board_preset("aprilgrid_a4");
  target.columns = target.rows = 25;  // 625 tags of 587
  EXPECT_THROW(print_grid(target, 0.01, 0.005), std::invalid_argument);
  EXPECT_THROW(print_grid(board_preset("aprilgrid_a0"), 0.01, 1e-4), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
