#include "sim/types/calibration_target.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "sim/types/board.h"

namespace cousin {
namespace {

struct KindName {
  TargetKind kind;
  std::string_view name;
};
constexpr std::array<KindName, 6> kKinds = {{
    {TargetKind::chessboard, "chessboard"},
    {TargetKind::charuco, "charuco"},
    {TargetKind::april_grid, "april_grid"},
    {TargetKind::circles, "circles"},
    {TargetKind::asymmetric_circles, "asymmetric_circles"},
    {TargetKind::seed_board, "seed_board"},
}};
constexpr int kMost = 100;  ///< squares, tags or discs in a row or column

[[noreturn]] void fail(const std::string& field, const std::string& value, const char* limit) {
  throw std::invalid_argument("target: " + field + " = " + value + " must be " + limit);
}

template <class T>
std::string shortest(T value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

template <class T>
T number(std::string_view key, std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    fail(std::string(key), std::string(text), "a number");
  return value;
}

/// Rows of points from the upper left, a step apart, about the middle.
std::vector<TargetPoint> lattice(int columns, int rows, double step_m) {
  std::vector<TargetPoint> points;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      points.push_back(
          {row * columns + column, column, row,
           step_m * Eigen::Vector2d(column - 0.5 * (columns - 1), 0.5 * (rows - 1) - row)});
    }
  }
  return points;
}

std::vector<TargetPoint> asymmetric_points(const CalibrationTarget& target) {
  std::vector<TargetPoint> points;
  for (int row = 0; row < target.rows; ++row) {
    for (int column = 0; column < target.columns; ++column) {
      const double x = 2 * column + row % 2 - (target.columns - 0.5);
      points.push_back({row * target.columns + column, column, row,
                        target.pitch_m * Eigen::Vector2d(x, 0.5 * (target.rows - 1) - row)});
    }
  }
  return points;
}

std::vector<TargetPoint> april_points(const CalibrationTarget& target) {
  const double step = 1 + target.mark_share;
  const Eigen::Vector2d origin =
      -0.5 * Eigen::Vector2d((target.columns - 1) * step + 1, (target.rows - 1) * step + 1);
  std::vector<TargetPoint> points;
  for (int row = 0; row < 2 * target.rows; ++row) {
    for (int column = 0; column < 2 * target.columns; ++column) {
      const Eigen::Vector2d at(column / 2 * step + column % 2, row / 2 * step + row % 2);
      points.push_back(
          {row * 2 * target.columns + column, column, row, target.pitch_m * (origin + at)});
    }
  }
  return points;
}

std::vector<TargetPoint> seed_points(const CalibrationTarget& target) {
  SeedBoard board;
  board.squares = target.columns;
  board.square_m = target.pitch_m;
  board.plate_m = target.columns * target.pitch_m;
  board.has_markers = target.mark_share > 0;
  board.marker_m = target.mark_share * target.pitch_m;
  std::vector<TargetPoint> points;
  for (int row = 0; row < board.squares - 1; ++row) {
    for (int column = 0; column < board.squares - 1; ++column) {
      if (!corner_exists(board, column, row)) continue;
      points.push_back({row * (board.squares - 1) + column, column, row,
                        corner_in_world_m(board, column, row).head<2>()});
    }
  }
  return points;
}

}  // namespace

std::string_view to_string(TargetKind kind) {
  for (const KindName& k : kKinds) {
    if (k.kind == kind) return k.name;
  }
  return "?";
}

TargetKind target_kind_from_string(std::string_view text) {
  std::string names;
  for (const KindName& k : kKinds) {
    if (k.name == text) return k.kind;
    names += (names.empty() ? "" : ", ") + std::string(k.name);
  }
  throw std::invalid_argument("target: kind \"" + std::string(text) + "\" is not one of " + names);
}

void validate(const CalibrationTarget& target) {
  const bool has_corners = target.kind == TargetKind::chessboard ||
                           target.kind == TargetKind::charuco ||
                           target.kind == TargetKind::seed_board;
  const int least = target.kind == TargetKind::seed_board ? 4 : has_corners ? 3 : 1;
  if (target.columns < least || target.columns > kMost)
    fail("columns", std::to_string(target.columns), least > 3 ? "4..100" : "1..100 (3 of squares)");
  if (target.rows < least || target.rows > kMost)
    fail("rows", std::to_string(target.rows), least > 3 ? "4..100" : "1..100 (3 of squares)");
  if (!(target.pitch_m >= 1e-4 && target.pitch_m <= 10))
    fail("pitch_m", shortest(target.pitch_m), "in [1e-4, 10]");
  if (target.dictionary.empty() == (target.kind == TargetKind::charuco)) {
    fail("dictionary", "\"" + target.dictionary + "\"",
         "a name of cv::aruco's on a charuco board and empty on others");
  }
  const double share = target.mark_share;
  switch (target.kind) {
    case TargetKind::chessboard:
      if (share != 0) fail("mark_share", shortest(share), "0 on a chessboard");
      break;
    case TargetKind::charuco:
      if (!(share >= 0.1 && share <= 0.95)) fail("mark_share", shortest(share), "in [0.1, 0.95]");
      break;
    case TargetKind::april_grid:
      if (!(share >= 0.05 && share <= 1)) fail("mark_share", shortest(share), "in [0.05, 1]");
      break;
    case TargetKind::circles:
    case TargetKind::asymmetric_circles:
      if (!(share >= 0.05 && share <= 0.45)) fail("mark_share", shortest(share), "in [0.05, 0.45]");
      break;
    case TargetKind::seed_board:
      if (target.columns != target.rows)
        fail("rows", std::to_string(target.rows), "as many as columns on a seed board");
      if (!(share == 0 || (share >= 0.3 && share <= 3)))
        fail("mark_share", shortest(share), "0 or in [0.3, 3]");
      if (share > 0 && target.columns < 7)
        fail("columns", std::to_string(target.columns), "at least 7 with markers");
      break;
  }
}

Eigen::Vector2d print_size_m(const CalibrationTarget& target) {
  const double p = target.pitch_m, share = target.mark_share;
  switch (target.kind) {
    case TargetKind::chessboard:
    case TargetKind::charuco:
    case TargetKind::seed_board:
    case TargetKind::circles:
      break;
    case TargetKind::april_grid:  // squares stand beyond the outer tags' corners, too
      return p * Eigen::Vector2d(target.columns * (1 + share) + share,
                                 target.rows * (1 + share) + share);
    case TargetKind::asymmetric_circles:
      return p * Eigen::Vector2d(2 * target.columns, target.rows);
  }
  return p * Eigen::Vector2d(target.columns, target.rows);
}

std::vector<TargetPoint> target_points(const CalibrationTarget& target) {
  switch (target.kind) {
    case TargetKind::chessboard:
    case TargetKind::charuco:
      return lattice(target.columns - 1, target.rows - 1, target.pitch_m);
    case TargetKind::circles:
      return lattice(target.columns, target.rows, target.pitch_m);
    case TargetKind::asymmetric_circles:
      return asymmetric_points(target);
    case TargetKind::april_grid:
      return april_points(target);
    case TargetKind::seed_board:
      return seed_points(target);
  }
  return {};
}

std::string to_text(const CalibrationTarget& target) {
  std::string text =
      std::string(to_string(target.kind)) + " columns=" + std::to_string(target.columns) +
      " rows=" + std::to_string(target.rows) + " pitch_m=" + shortest(target.pitch_m);
  if (target.mark_share != 0) text += " mark_share=" + shortest(target.mark_share);
  if (!target.dictionary.empty()) text += " dictionary=" + target.dictionary;
  return text;
}

CalibrationTarget target_from_text(std::string_view text) {
  constexpr std::size_t kMostBytes = 200;
  if (text.size() > kMostBytes) fail("text", std::to_string(text.size()) + " bytes", "at most 200");
  CalibrationTarget target;
  const auto word = [&text] {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view first = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return first;
  };
  target.kind = target_kind_from_string(word());
  while (!text.empty()) {
    const std::string_view pair = word();
    const std::size_t equals = pair.find('=');
    const std::string_view key = pair.substr(0, equals);
    const std::string_view value =
        equals == pair.npos ? std::string_view() : pair.substr(equals + 1);
    if (key == "columns") {
      target.columns = number<int>(key, value);
    } else if (key == "rows") {
      target.rows = number<int>(key, value);
    } else if (key == "pitch_m") {
      target.pitch_m = number<double>(key, value);
    } else if (key == "mark_share") {
      target.mark_share = number<double>(key, value);
    } else if (key == "dictionary") {
      target.dictionary = value;
    } else {
      fail("key \"" + std::string(key) + "\"", std::string(value),
           "one of columns, rows, pitch_m, mark_share, dictionary");
    }
  }
  validate(target);
  return target;
}

}  // namespace cousin
