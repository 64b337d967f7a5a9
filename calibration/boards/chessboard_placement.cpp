#include "calibration/boards/chessboard_placement.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cousin {
namespace {

struct Extent {
  std::array<int, 2> low{1 << 20, 1 << 20}, high{-(1 << 20), -(1 << 20)};
  int columns() const { return high[0] - low[0] + 1; }
  int rows() const { return high[1] - low[1] + 1; }
};

/// Quarter turns counter-clockwise.
std::array<int, 2> turned(int turn, const LatticeCorner& c) {
  switch (turn) {
    case 1:
      return {-c.row, c.column};
    case 2:
      return {-c.column, -c.row};
    case 3:
      return {c.row, -c.column};
    default:
      return {c.column, c.row};
  }
}

Extent extent(const std::vector<LatticeCorner>& lattice, int turn) {
  Extent e;
  for (const LatticeCorner& c : lattice) {
    const auto p = turned(turn, c);
    for (std::size_t k = 0; k < 2; ++k) {
      e.low[k] = std::min(e.low[k], p[k]);
      e.high[k] = std::max(e.high[k], p[k]);
    }
  }
  return e;
}

struct Turned {
  FoundPixels found;
  bool inverted = false;
  double up_px = 0;  ///< how far above the last row the first one is seen
};

Turned turned_lattice(const TargetGrid& grid, const std::vector<LatticeCorner>& lattice, int turn) {
  const Extent e = extent(lattice, turn);
  Turned t;
  t.found.resize(grid.points().size());
  int alike = 0;
  for (const LatticeCorner& c : lattice) {
    const auto p = turned(turn, c);
    const int column = p[0] - e.low[0], row = e.high[1] - p[1];  // rows run down
    t.found[static_cast<std::size_t>(grid.at(column, row))] = c.pixel_px;
    // The square to the right and above is black where column + row is odd.
    const bool dark = c.dark_ahead != (turn % 2 == 1);
    alike += dark == ((column + row) % 2 == 1) ? 1 : -1;
    t.up_px += (row - 0.5 * (grid.rows() - 1)) * (c.pixel_px.y() + 1e-3 * c.pixel_px.x());
  }
  t.inverted = alike < 0;
  return t;
}

/// Whether the lattice ends at the image's border.
bool is_cut(const std::vector<LatticeCorner>& lattice, int width_px, int height_px) {
  double step = 0;
  for (const LatticeCorner& a : lattice) {
    for (const LatticeCorner& b : lattice) {
      if (std::abs(a.column - b.column) + std::abs(a.row - b.row) == 1)
        step = std::max(step, (a.pixel_px - b.pixel_px).norm());
    }
  }
  return std::any_of(lattice.begin(), lattice.end(), [&](const LatticeCorner& c) {
    return c.pixel_px.x() < 1.2 * step || c.pixel_px.y() < 1.2 * step ||
           c.pixel_px.x() > width_px - 1.2 * step || c.pixel_px.y() > height_px - 1.2 * step;
  });
}

/// Without the outermost lines that few corners make: saddles beside the board joined them.
std::vector<LatticeCorner> trimmed(std::vector<LatticeCorner> lattice) {
  constexpr double kFew = 0.35;
  while (lattice.size() > 4) {
    const Extent e = extent(lattice, 0);
    const auto sparse = [&](bool is_row, int line) {
      const auto on_line = [&](const LatticeCorner& c) {
        return (is_row ? c.row : c.column) == line;
      };
      const auto count = std::count_if(lattice.begin(), lattice.end(), on_line);
      const int length = is_row ? e.columns() : e.rows();
      if (static_cast<double>(count) > kFew * length) return false;
      std::erase_if(lattice, on_line);
      return true;
    };
    if (!sparse(false, e.low[0]) && !sparse(false, e.high[0]) && !sparse(true, e.low[1]) &&
        !sparse(true, e.high[1]))
      break;
  }
  return lattice;
}

std::vector<Turned> fitting_turns(const TargetGrid& grid,
                                  const std::vector<LatticeCorner>& lattice) {
  std::vector<Turned> fits;
  for (int turn = 0; turn < 4; ++turn) {
    const Extent e = extent(lattice, turn);
    if (e.columns() == grid.columns() && e.rows() == grid.rows())
      fits.push_back(turned_lattice(grid, lattice, turn));
  }
  return fits;
}

std::string by(int columns, int rows) {
  return std::to_string(columns) + " x " + std::to_string(rows);
}

}  // namespace

ChessboardPlacement place_chessboard(const TargetGrid& grid,
                                     const std::vector<LatticeCorner>& given, int width_px,
                                     int height_px) {
  ChessboardPlacement placement;
  std::vector<LatticeCorner> lattice = given;
  if (lattice.empty()) {
    placement.reason = "no checkerboard is seen";
    return placement;
  }
  std::vector<Turned> fits = fitting_turns(grid, lattice);
  if (fits.empty()) {
    lattice = trimmed(lattice);
    fits = fitting_turns(grid, lattice);
  }
  if (fits.empty()) {
    const Extent e = extent(lattice, 0);
    const int least = std::min(e.columns(), e.rows()), most = std::max(e.columns(), e.rows());
    const int board_least = std::min(grid.columns(), grid.rows());
    const int board_most = std::max(grid.columns(), grid.rows());
    const bool is_larger = least > board_least || most > board_most;
    const bool is_full = static_cast<int>(lattice.size()) >= 0.9 * e.columns() * e.rows();
    const bool is_other =
        is_larger || (is_full && lattice.size() >= 9 && !is_cut(lattice, width_px, height_px));
    placement.status = is_other ? TargetStatus::wrong_target : TargetStatus::too_few_points;
    placement.reason = by(most, least) + " inner corners are seen; the board has " +
                       by(board_most, board_least) +
                       (is_other ? "" : ", and a part does not say which it is");
    return placement;
  }
  // Colours as designed come first.
  const bool any_as_designed =
      std::any_of(fits.begin(), fits.end(), [](const Turned& t) { return !t.inverted; });
  std::erase_if(fits, [&](const Turned& t) { return t.inverted == any_as_designed; });
  const auto best = std::max_element(
      fits.begin(), fits.end(), [](const Turned& a, const Turned& b) { return a.up_px < b.up_px; });
  placement.status = fits.size() > 1 ? TargetStatus::half_turn_unknown : TargetStatus::ok;
  placement.inverted = best->inverted;
  placement.found = best->found;
  if (fits.size() > 1) {
    placement.reason = by(grid.columns(), grid.rows()) + " inner corners look the same after " +
                       (fits.size() > 2 ? "a quarter turn" : "half a turn");
  }
  if (best->inverted) placement.status = TargetStatus::half_turn_unknown;
  return placement;
}

}  // namespace cousin
