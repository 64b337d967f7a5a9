#include "benchmarks/tools/print_board/board_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <utility>

#include "scenes/boards/print_grid.h"

namespace cousin {
namespace {

constexpr double kMargin_mm = 5;  ///< that printers do not reach
/// Below the print: ruler, its numbers and two lines of text.
constexpr double kFoot_mm = 14.5;
constexpr double kQuiet_mm = 5;        ///< white about the print: detectors need it
constexpr double kPlateBorder_mm = 5;  ///< of the seed board: white about its squares
constexpr double kCutMark_mm = 4;

/// Cells of one colour as few boxes as rows and equal rows give.
std::vector<PrintPage::Box> boxes_of(const PrintGrid& grid, double middle_x_mm,
                                     double middle_y_mm) {
  const auto at = [&](int column, int row) { return 1e3 * grid.at_m[grid.vertex(column, row)]; };
  const auto ink = [&](int column, int row) {
    return grid.has_ink[static_cast<std::size_t>(row * grid.columns + column)] != 0;
  };
  std::vector<PrintPage::Box> boxes;
  std::vector<bool> done(grid.has_ink.size(), false);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const auto cell = [&](int c, int r) {
        return static_cast<std::size_t>(r * grid.columns + c);
      };
      if (!ink(column, row) || done[cell(column, row)]) continue;
      int end = column;
      while (end < grid.columns && ink(end, row) && !done[cell(end, row)]) ++end;
      int top = row + 1;
      const auto is_full = [&](int r) {
        for (int c = column; c < end; ++c) {
          if (!ink(c, r) || done[cell(c, r)]) return false;
        }
        return true;
      };
      while (top < grid.rows && is_full(top)) ++top;
      for (int r = row; r < top; ++r) {
        for (int c = column; c < end; ++c) done[cell(c, r)] = true;
      }
      const Eigen::Vector2d low = at(column, row), high = at(end, top);
      boxes.push_back(
          {middle_x_mm + low.x(), middle_y_mm - high.y(), high.x() - low.x(), high.y() - low.y()});
    }
  }
  return boxes;
}

bool has_discs(const CalibrationTarget& target) {
  return target.kind == TargetKind::circles || target.kind == TargetKind::asymmetric_circles;
}

void add_print(const CalibrationTarget& target, double middle_x_mm, double middle_y_mm,
               PrintPage& page) {
  if (!has_discs(target)) {
    constexpr double kWhole_m = 10;  // no cell is parted for its size
    page.boxes = boxes_of(print_grid(target, 0, kWhole_m), middle_x_mm, middle_y_mm);
    return;
  }
  for (const TargetPoint& point : target_points(target))
    page.discs.push_back({middle_x_mm + 1e3 * point.at_m.x(), middle_y_mm - 1e3 * point.at_m.y(),
                          1e3 * target.mark_share * target.pitch_m});
}

/// A line a millimetre, a number a centimetre.
void add_ruler(double left_mm, double top_mm, int length_mm, PrintPage& page) {
  constexpr double kLine_mm = 0.12;
  page.boxes.push_back({left_mm - 0.5 * kLine_mm, top_mm, length_mm + kLine_mm, kLine_mm});
  for (int i = 0; i <= length_mm; ++i) {
    const double high_mm = i % 10 == 0 ? 3.5 : i % 5 == 0 ? 2.5 : 1.5;
    page.boxes.push_back({left_mm + i - 0.5 * kLine_mm, top_mm, kLine_mm, high_mm});
    if (i % 10 == 0) page.texts.push_back({left_mm + i - 1.2, top_mm + 6, 2.4, std::to_string(i)});
  }
}

/// Where the plate is cut, outside of it.
void add_cut_marks(double left_mm, double top_mm, const Eigen::Vector2d& size_mm, PrintPage& page) {
  constexpr double kLine_mm = 0.1, kApart_mm = 1;
  for (const double x : {left_mm, left_mm + size_mm.x()}) {
    const double beside = x == left_mm ? -kApart_mm - kCutMark_mm : kApart_mm;
    for (const double y : {top_mm, top_mm + size_mm.y()}) {
      const double above = y == top_mm ? -kApart_mm - kCutMark_mm : kApart_mm;
      page.boxes.push_back({x - 0.5 * kLine_mm, y + above, kLine_mm, kCutMark_mm});
      page.boxes.push_back({x + beside, y - 0.5 * kLine_mm, kCutMark_mm, kLine_mm});
    }
  }
}

/// Width and height of the sheet, upright or lying; nothing if the print does not fit on it.
std::optional<Eigen::Vector2d> sheet_for(const Paper& paper, const Eigen::Vector2d& size_mm) {
  const Eigen::Vector2d needed = size_mm + Eigen::Vector2d(2 * (kMargin_mm + kQuiet_mm),
                                                           2 * kMargin_mm + kQuiet_mm + kFoot_mm);
  for (const Eigen::Vector2d& sheet : {Eigen::Vector2d(paper.width_mm, paper.height_mm),
                                       Eigen::Vector2d(paper.height_mm, paper.width_mm)}) {
    if ((needed.array() <= sheet.array()).all()) return sheet;
  }
  return std::nullopt;
}

const Paper* smallest_for(const Eigen::Vector2d& size_mm) {
  for (const Paper& paper : papers()) {
    if (sheet_for(paper, size_mm)) return &paper;
  }
  return nullptr;
}

std::string size_text(double width_mm, double height_mm) {
  char text[64];
  std::snprintf(text, sizeof text, "%.1f x %.1f mm", width_mm, height_mm);
  return text;
}

/// The paper asked for, or the smallest that is large enough.
const Paper& chosen_paper(const std::string& asked, const Eigen::Vector2d& size_mm) {
  const Paper* const smallest = smallest_for(size_mm);
  const Paper* const paper = asked.empty() ? smallest : &paper_of(asked);
  if (paper && sheet_for(*paper, size_mm)) return *paper;
  const std::string what = "the board is " + size_text(size_mm.x(), size_mm.y()) +
                           ", with its margin and ruler " +
                           size_text(size_mm.x() + 2 * (kMargin_mm + kQuiet_mm),
                                     size_mm.y() + 2 * kMargin_mm + kQuiet_mm + kFoot_mm);
  if (!paper) throw std::invalid_argument(what + ": no paper is that large, the largest is a0");
  throw std::invalid_argument(
      "--paper " + std::string(paper->name) + " is " +
      size_text(paper->width_mm, paper->height_mm) + "; " + what +
      (smallest ? "; it fits on " + std::string(smallest->name) : "; it fits on none"));
}

}  // namespace

const std::vector<Paper>& papers() {
  static const std::vector<Paper> kPapers = {
      {"a5", 148, 210},        {"a4", 210, 297}, {"letter", 215.9, 279.4},
      {"legal", 215.9, 355.6}, {"a3", 297, 420}, {"tabloid", 279.4, 431.8},
      {"a2", 420, 594},        {"a1", 594, 841}, {"a0", 841, 1189}};
  return kPapers;
}

const Paper& paper_of(std::string_view name) {
  std::string names;
  for (const Paper& paper : papers()) {
    if (paper.name == name) return paper;
    names += (names.empty() ? "" : ", ") + std::string(paper.name);
  }
  throw std::invalid_argument("--paper \"" + std::string(name) + "\" is not one of " + names);
}

BoardPage board_page(const CalibrationTarget& target, const std::string& name,
                     const std::string& paper) {
  validate(target);
  const Eigen::Vector2d size_mm = 1e3 * print_size_m(target);
  const Paper& own = chosen_paper(paper, size_mm);
  const Eigen::Vector2d sheet = *sheet_for(own, size_mm);
  BoardPage board;
  board.name = name;
  board.paper = std::string(own.name);
  board.page.width_mm = sheet.x();
  board.page.height_mm = sheet.y();
  board.left_mm = 0.5 * (sheet.x() - size_mm.x());
  const double free_mm = sheet.y() - 2 * kMargin_mm - kFoot_mm - size_mm.y();
  board.top_mm = kMargin_mm + std::max(kQuiet_mm, 0.5 * free_mm);
  add_print(target, board.left_mm + 0.5 * size_mm.x(), board.top_mm + 0.5 * size_mm.y(),
            board.page);
  if (target.kind == TargetKind::seed_board) {
    const Eigen::Vector2d plate_mm = size_mm.array() + 2 * kPlateBorder_mm;
    add_cut_marks(board.left_mm - kPlateBorder_mm, board.top_mm - kPlateBorder_mm, plate_mm,
                  board.page);
  }
  board.ruler_mm = sheet.x() - 2 * kMargin_mm >= 200 ? 150 : 100;
  const double foot_mm = sheet.y() - kMargin_mm - kFoot_mm + 1;
  add_ruler(kMargin_mm + 3, foot_mm, static_cast<int>(board.ruler_mm), board.page);
  board.page.texts.push_back(
      {kMargin_mm + 3, foot_mm + 9.5, 2.6,
       name + ": " + to_text(target) + "; print " + size_text(size_mm.x(), size_mm.y())});
  board.page.texts.push_back({kMargin_mm + 3, foot_mm + 13, 2.6,
                              "Print at 100 %, not \"fit to page\". The ruler must then be " +
                                  std::to_string(static_cast<int>(board.ruler_mm)) +
                                  ".0 mm long."});
  return board;
}

}  // namespace cousin
