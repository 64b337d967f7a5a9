#include "scenes/boards/print_grid.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>

#include "scenes/boards/marker_codes.h"
#include "sim/types/board.h"

namespace cousin {
namespace {

constexpr double kPi = std::numbers::pi;
/// Cells along a disc's square and the part of them that the disc fills: its outline has four times
/// the latter as corners.
constexpr int kDiscCells = 24, kDiscCore = 16;
constexpr int kKalibrBorder = 2;  ///< bits of black about a tag's code

using InkAt = std::function<bool(const Eigen::Vector2d& at_m)>;

/// Places of all straight edges along x and along y, unsorted; colour between them.
struct Cuts {
  std::vector<double> x_m, y_m;
  InkAt has_ink;
};

bool is_in(const Eigen::Vector2d& p, const Eigen::Vector2d& size) {
  return p.x() >= 0 && p.y() >= 0 && p.x() < size.x() && p.y() < size.y();
}

/// Edges of the squares of a lattice, from `first_m` on.
void cut_evenly(std::vector<double>& cuts, double first_m, double step_m, int count) {
  for (int i = 0; i <= count; ++i) cuts.push_back(first_m + step_m * i);
}

/// Square and marker bits of a marker about the middle of `square`; p in the square, y down, 0..1.
bool marker_ink(const MarkerCode& code, double share, const Eigen::Vector2d& p) {
  const int side = code.bits + 2;
  const double column = (p.x() - 0.5) / share * side + 0.5 * side;
  const double row = (p.y() - 0.5) / share * side + 0.5 * side;
  if (column < 0 || row < 0 || column >= side || row >= side) return false;
  const int i = static_cast<int>(column) - 1, j = static_cast<int>(row) - 1;
  if (i < 0 || j < 0 || i >= code.bits || j >= code.bits) return true;
  return !code.at(i, j);
}

Cuts squares(const CalibrationTarget& target) {
  const Eigen::Vector2d size = print_size_m(target);
  const double pitch = target.pitch_m;
  const bool has_markers = target.kind == TargetKind::charuco;
  const int columns = target.columns, rows = target.rows;
  std::vector<MarkerCode> codes;
  if (has_markers) codes = marker_codes(target.dictionary, columns * rows / 2);
  Cuts cuts;
  cut_evenly(cuts.x_m, -0.5 * size.x(), pitch, columns);
  cut_evenly(cuts.y_m, -0.5 * size.y(), pitch, rows);
  if (has_markers) {
    const int side = codes.front().bits + 2;
    const double first = 0.5 * (1 - target.mark_share) * pitch;
    const double bit = target.mark_share * pitch / side;
    for (int i = 0; i < columns; ++i)
      cut_evenly(cuts.x_m, -0.5 * size.x() + i * pitch + first, bit, side);
    for (int i = 0; i < rows; ++i)
      cut_evenly(cuts.y_m, -0.5 * size.y() + i * pitch + first, bit, side);
  }
  const double share = target.mark_share;
  cuts.has_ink = [=](const Eigen::Vector2d& at_m) {
    const Eigen::Vector2d p(at_m.x() + 0.5 * size.x(), 0.5 * size.y() - at_m.y());  // y down
    if (!is_in(p, size)) return false;
    const int column = std::min(static_cast<int>(p.x() / pitch), columns - 1);
    const int row = std::min(static_cast<int>(p.y() / pitch), rows - 1);
    if ((column + row) % 2 == 0) return true;
    if (codes.empty()) return false;
    // Markers are numbered along the white squares, row by row from the top.
    const auto id = static_cast<std::size_t>((row * columns + column) / 2);
    return marker_ink(codes[id], share, p / pitch - Eigen::Vector2d(column, row));
  };
  return cuts;
}

Cuts tags(const CalibrationTarget& target) {
  const Eigen::Vector2d size = print_size_m(target);
  const double tag = target.pitch_m, gap = target.mark_share * tag, step = tag + gap;
  const int columns = target.columns, rows = target.rows;
  const std::vector<MarkerCode> codes = kalibr_codes(columns * rows);
  const int side = codes.front().bits + 2 * kKalibrBorder;
  Cuts cuts;
  for (int i = 0; i < columns; ++i)
    cut_evenly(cuts.x_m, -0.5 * size.x() + gap + i * step, tag / side, side);
  for (int i = 0; i < rows; ++i)
    cut_evenly(cuts.y_m, -0.5 * size.y() + gap + i * step, tag / side, side);
  cuts.has_ink = [=](const Eigen::Vector2d& at_m) {
    const Eigen::Vector2d p = at_m + 0.5 * size;  // y up: tags are numbered from the lower left
    if (!is_in(p, size)) return false;
    const int column = static_cast<int>(p.x() / step), row = static_cast<int>(p.y() / step);
    const Eigen::Vector2d q = p - step * Eigen::Vector2d(column, row);
    const bool in_gap_x = q.x() < gap, in_gap_y = q.y() < gap;
    if (in_gap_x || in_gap_y) return in_gap_x && in_gap_y;  // a square between four tags
    const int i = static_cast<int>((q.x() - gap) / tag * side) - kKalibrBorder;
    const int j = static_cast<int>((q.y() - gap) / tag * side) - kKalibrBorder;
    const MarkerCode& code = codes[static_cast<std::size_t>(row * columns + column)];
    if (i < 0 || j < 0 || i >= code.bits || j >= code.bits) return true;
    return !code.at(i, code.bits - 1 - j);
  };
  return cuts;
}

Cuts seed_print(const CalibrationTarget& target) {
  SeedBoard board;
  board.squares = target.columns;
  board.square_m = target.pitch_m;
  board.plate_m = print_size_m(target).x();
  board.has_markers = target.mark_share > 0;
  board.marker_m = target.mark_share * target.pitch_m;
  validate(board);
  Cuts cuts;
  cut_evenly(cuts.x_m, -0.5 * board.plate_m, board.square_m, board.squares);
  if (board.has_markers) {
    for (const int index : {0, 1}) {
      const double first = marker_corners_in_world_m(board, index)[0].x();
      cut_evenly(cuts.x_m, first, board.marker_m / kMarkerModules, kMarkerModules);
    }
  }
  cuts.y_m = cuts.x_m;
  cuts.has_ink = [board](const Eigen::Vector2d& at_m) {
    return is_black(board, at_m.x(), at_m.y());
  };
  return cuts;
}

/// Sorted, without repetition, out to the plate's edges and no two farther apart than detail_m.
std::vector<double> refined(std::vector<double> cuts, double edge_m, double detail_m) {
  cuts.push_back(-edge_m);
  cuts.push_back(edge_m);
  std::sort(cuts.begin(), cuts.end());
  std::vector<double> result = {cuts.front()};
  for (const double cut : cuts) {
    const double before = result.back(), apart = cut - before;
    if (apart < 1e-9) continue;
    const int parts = std::max(1, static_cast<int>(std::ceil(apart / detail_m - 1e-9)));
    for (int i = 1; i < parts; ++i) result.push_back(before + apart * i / parts);
    result.push_back(cut);
  }
  return result;
}

void check_size(std::size_t columns, std::size_t rows) {
  constexpr std::size_t kMost = 4'000'000;
  if (columns * rows <= kMost) return;
  throw std::invalid_argument("board: its print would take " + std::to_string(columns * rows) +
                              " cells; the limit is " + std::to_string(kMost));
}

PrintGrid straight_grid(const CalibrationTarget& target, double margin_m, double detail_m) {
  const Cuts cuts = target.kind == TargetKind::april_grid   ? tags(target)
                    : target.kind == TargetKind::seed_board ? seed_print(target)
                                                            : squares(target);
  const Eigen::Vector2d edge = 0.5 * print_size_m(target) + Eigen::Vector2d::Constant(margin_m);
  const std::vector<double> x = refined(cuts.x_m, edge.x(), detail_m);
  const std::vector<double> y = refined(cuts.y_m, edge.y(), detail_m);
  check_size(x.size(), y.size());
  PrintGrid grid;
  grid.columns = static_cast<int>(x.size()) - 1;
  grid.rows = static_cast<int>(y.size()) - 1;
  for (const double v : y) {
    for (const double u : x) grid.at_m.emplace_back(u, v);
  }
  for (std::size_t j = 0; j + 1 < y.size(); ++j) {
    for (std::size_t i = 0; i + 1 < x.size(); ++i)
      grid.has_ink.push_back(cuts.has_ink({0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1])}));
  }
  return grid;
}

/// A point of the square [-1, 1]^2 moved so that the square of half side `core` becomes the disc of
/// radius `radius` and the outer square stays: rings of squares become rings [the directions of
/// Shirley & Chiu 1997].
Eigen::Vector2d bent(const Eigen::Vector2d& p, double core, double radius) {
  const double ring = p.cwiseAbs().maxCoeff();
  if (ring == 0) return p;
  const bool by_x = std::abs(p.x()) >= std::abs(p.y());
  const double turn = by_x ? kPi / 4 * p.y() / p.x() : kPi / 2 - kPi / 4 * p.x() / p.y();
  const double sign = (by_x ? p.x() : p.y()) < 0 ? -1 : 1;
  const Eigen::Vector2d direction = sign * Eigen::Vector2d(std::cos(turn), std::sin(turn));
  if (ring <= core) return ring / core * radius * direction;
  const double t = (ring - core) / (1 - core);
  return (1 - t) * radius * direction + t * p / ring;
}

/// Unit cells, some with a disc in their middle, and a margin.
PrintGrid disc_grid(const CalibrationTarget& target, double margin_m, double detail_m) {
  const bool staggered = target.kind == TargetKind::asymmetric_circles;
  const int columns = target.columns * (staggered ? 2 : 1), rows = target.rows;
  const double pitch = target.pitch_m;
  const Eigen::Vector2d half = 0.5 * print_size_m(target);
  const int cells = std::max(
      kDiscCells, kDiscCells * static_cast<int>(std::ceil(pitch / kDiscCells / detail_m - 1e-9)));
  check_size(static_cast<std::size_t>(columns * cells), static_cast<std::size_t>(rows * cells));
  const auto cuts = [&](int count, double half_m) {
    std::vector<double> list;
    cut_evenly(list, -half_m, pitch / cells, count * cells);
    return refined(list, half_m + margin_m, detail_m);
  };
  const std::vector<double> x = cuts(columns, half.x()), y = cuts(rows, half.y());
  check_size(x.size(), y.size());
  // Where the unit cells begin among the vertices: the margin's come first.
  const auto first = [&](const std::vector<double>& list, double half_m) {
    return static_cast<int>(std::lower_bound(list.begin(), list.end(), -half_m - 1e-9) -
                            list.begin());
  };
  const int first_x = first(x, half.x()), first_y = first(y, half.y());
  const auto has_disc = [&](int column, int row) {  // row from the lowest
    return !staggered || column % 2 == (rows - 1 - row) % 2;
  };
  const double core = static_cast<double>(kDiscCore) / kDiscCells;
  const double sides = 4.0 * core * cells;  // of the polygon, whose area is the disc's
  const double radius =
      2 * target.mark_share * std::sqrt(2 * kPi / sides / std::sin(2 * kPi / sides));
  PrintGrid grid;
  grid.columns = static_cast<int>(x.size()) - 1;
  grid.rows = static_cast<int>(y.size()) - 1;
  for (const double v : y) {
    for (const double u : x) grid.at_m.emplace_back(u, v);
  }
  grid.has_ink.assign(static_cast<std::size_t>(grid.columns * grid.rows), 0);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (!has_disc(column, row)) continue;
      const Eigen::Vector2d middle = pitch * Eigen::Vector2d(column + 0.5, row + 0.5) - half;
      for (int j = 1; j < cells; ++j) {
        for (int i = 1; i < cells; ++i) {
          const Eigen::Vector2d p(2.0 * i / cells - 1, 2.0 * j / cells - 1);
          grid.at_m[grid.vertex(first_x + column * cells + i, first_y + row * cells + j)] =
              middle + 0.5 * pitch * bent(p, core, radius);
        }
      }
      const int edge = (cells - static_cast<int>(std::lround(core * cells))) / 2;
      for (int j = edge; j < cells - edge; ++j) {
        for (int i = edge; i < cells - edge; ++i) {
          grid.has_ink[static_cast<std::size_t>((first_y + row * cells + j) * grid.columns +
                                                first_x + column * cells + i)] = 1;
        }
      }
    }
  }
  return grid;
}

}  // namespace

PrintGrid print_grid(const CalibrationTarget& target, double margin_m, double detail_m) {
  validate(target);
  const bool has_discs =
      target.kind == TargetKind::circles || target.kind == TargetKind::asymmetric_circles;
  return has_discs ? disc_grid(target, margin_m, detail_m)
                   : straight_grid(target, margin_m, detail_m);
}

}  // namespace cousin
