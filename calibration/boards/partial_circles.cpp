#include "calibration/boards/partial_circles.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <set>

namespace cousin {
namespace {

using Cell = std::array<int, 2>;
using Cells = std::map<Cell, int>;  ///< a lattice's places and the disc that is there

constexpr std::size_t kMostDiscs = 5000;
constexpr int kLeastDiscs = 8;
constexpr std::array<Cell, 4> kSteps = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Steps of the lattice at one disc, in pixels.
using Basis = std::array<Eigen::Vector2d, 2>;

/// The two shortest steps to other discs that are not along one line: of any lattice they are a
/// basis. Turned like x to the right and y down.
std::optional<Basis> basis_at(const std::vector<Eigen::Vector2d>& discs, std::size_t from) {
  std::vector<Eigen::Vector2d> steps;
  for (std::size_t i = 0; i < discs.size(); ++i) {
    if (i != from) steps.emplace_back(discs[i] - discs[from]);
  }
  constexpr std::size_t kNear = 8;
  const auto some = steps.begin() + static_cast<std::ptrdiff_t>(std::min(kNear, steps.size()));
  std::partial_sort(steps.begin(), some, steps.end(),
                    [](const auto& a, const auto& b) { return a.squaredNorm() < b.squaredNorm(); });
  constexpr double kLeastSine = 0.4;
  for (auto b = steps.begin(); b != some; ++b) {
    const double turn = cross(steps.front(), *b);
    if (std::abs(turn) < kLeastSine * steps.front().norm() * b->norm()) continue;
    return Basis{steps.front(), turn > 0 ? *b : Eigen::Vector2d(-*b)};
  }
  return std::nullopt;
}

/// The lattice that grows from one disc, each disc handing its steps on to those it finds.
Cells grow(const std::vector<Eigen::Vector2d>& discs, std::size_t seed) {
  constexpr double kNear = 0.3;  ///< of a step
  Cells cells;
  const auto first = basis_at(discs, seed);
  if (!first) return cells;
  std::map<Cell, Basis> bases;
  std::vector<bool> used(discs.size(), false);
  std::deque<Cell> open = {{0, 0}};
  cells[{0, 0}] = static_cast<int>(seed);
  bases[{0, 0}] = *first;
  used[seed] = true;
  while (!open.empty()) {
    const Cell at = open.front();
    open.pop_front();
    const Eigen::Vector2d here = discs[static_cast<std::size_t>(cells[at])];
    const Basis basis = bases[at];
    for (const Cell& s : kSteps) {
      const Cell next = {at[0] + s[0], at[1] + s[1]};
      if (cells.count(next) > 0) continue;
      const Eigen::Vector2d step = s[0] * basis[0] + s[1] * basis[1];
      std::size_t nearest = discs.size();
      double least = kNear * step.norm();
      for (std::size_t i = 0; i < discs.size(); ++i) {
        const double off = (discs[i] - here - step).norm();
        if (!used[i] && off < least) least = off, nearest = i;
      }
      if (nearest == discs.size()) continue;
      used[nearest] = true;
      cells[next] = static_cast<int>(nearest);
      Basis handed = basis;
      const std::size_t axis = s[0] != 0 ? 0 : 1;
      handed[axis] = (s[axis] > 0 ? 1.0 : -1.0) * (discs[nearest] - here);
      bases[next] = handed;
      open.push_back(next);
    }
  }
  return cells;
}

Cells largest_lattice(const std::vector<Eigen::Vector2d>& discs) {
  constexpr std::size_t kSeeds = 7;
  Cells best;
  for (std::size_t k = 0; k < std::min(kSeeds, discs.size()); ++k) {
    Cells grown = grow(discs, k * discs.size() / std::min(kSeeds, discs.size()));
    if (grown.size() > best.size()) best = std::move(grown);
  }
  return best;
}

/// Median of nine bytes about a place inside the picture.
int median_tone(const Image<std::uint8_t>& tone, const Eigen::Vector2d& at) {
  std::array<int, 9> around{};
  const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
  for (int i = 0; i < 9; ++i)
    around[static_cast<std::size_t>(i)] = tone(x + i % 3 - 1, y + i / 3 - 1);
  std::nth_element(around.begin(), around.begin() + 4, around.end());
  return around[4];
}

bool inside(const Image<std::uint8_t>& tone, const Eigen::Vector2d& at) {
  return at.minCoeff() > 2 && at.x() < tone.width() - 3 && at.y() < tone.height() - 3;
}

/// Places beside the lattice that show paper, which is as bright as half way between two discs. It
/// is looked at half a radius before the place, where a disc would still be black: paper may end
/// there. @param radius  of a disc, in steps of the lattice
std::set<Cell> bare_places(const Image<std::uint8_t>& tone,
                           const std::vector<Eigen::Vector2d>& discs, const Cells& cells,
                           double radius) {
  constexpr double kBright = 0.75;  ///< of the way from a disc to paper
  std::set<Cell> bare;
  for (const auto& [cell, disc] : cells) {
    const Eigen::Vector2d here = discs[static_cast<std::size_t>(disc)];
    for (const Cell& s : kSteps) {
      const Cell beyond = {cell[0] + s[0], cell[1] + s[1]};
      const auto inner = cells.find({cell[0] - s[0], cell[1] - s[1]});
      if (cells.count(beyond) > 0 || inner == cells.end()) continue;
      const Eigen::Vector2d back = discs[static_cast<std::size_t>(inner->second)] - here;
      const Eigen::Vector2d at = here - (1 - 0.5 * radius) * back, paper = here + 0.5 * back;
      if (!inside(tone, at) || !inside(tone, paper) || !inside(tone, here)) continue;
      const int black = median_tone(tone, here), white = median_tone(tone, paper);
      if (white > black && median_tone(tone, at) > black + kBright * (white - black))
        bare.insert(beyond);
    }
  }
  return bare;
}

/// A target point's place in its own lattice: of staggered rows the diagonal steps.
Cell lattice_cell(const TargetGrid& grid, const TargetPoint& p) {
  if (grid.target().kind != TargetKind::asymmetric_circles) return {p.column, p.row};
  const int x = 2 * p.column + p.row % 2;
  return {(x + p.row) / 2, (p.row - x) / 2};  // x and row are both even or both odd
}

struct Placement {
  std::array<int, 4> turn{};  ///< rows of a matrix of determinant 1
  Cell shift{};
  Cell operator()(const Cell& c) const {
    return {turn[0] * c[0] + turn[1] * c[1] + shift[0], turn[2] * c[0] + turn[3] * c[1] + shift[1]};
  }
};

/// Every way in which the part fits on the grid.
std::vector<Placement> placements(const Cells& cells, const std::set<Cell>& bare,
                                  const std::map<Cell, int>& places) {
  std::vector<Placement> all;
  for (int code = 0; code < 81; ++code) {
    Placement p;
    p.turn = {code % 3 - 1, code / 3 % 3 - 1, code / 9 % 3 - 1, code / 27 - 1};
    if (p.turn[0] * p.turn[3] - p.turn[1] * p.turn[2] != 1) continue;
    p.shift = {0, 0};
    const Cell first = p(cells.begin()->first);
    for (const auto& [place, index] : places) {
      p.shift = {place[0] - first[0], place[1] - first[1]};
      const bool fits = std::all_of(cells.begin(), cells.end(),
                                    [&](const auto& c) { return places.count(p(c.first)) > 0; }) &&
                        std::none_of(bare.begin(), bare.end(),
                                     [&](const Cell& c) { return places.count(p(c)) > 0; });
      if (fits) all.push_back(p);
    }
  }
  return all;
}

FoundPixels found_by(const Placement& placement, const Cells& cells,
                     const std::vector<Eigen::Vector2d>& discs, const std::map<Cell, int>& places) {
  FoundPixels found(places.size());
  for (const auto& [cell, disc] : cells)
    found[static_cast<std::size_t>(places.at(placement(cell)))] =
        discs[static_cast<std::size_t>(disc)];
  return found;
}

/// How far y grows in the picture, as rows do.
double downward(const TargetGrid& grid, const FoundPixels& found) {
  double rows = 0, y = 0, count = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i]) rows += grid.points()[i].row, y += found[i]->y(), ++count;
  }
  double sum = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i]) sum += (grid.points()[i].row - rows / count) * (found[i]->y() - y / count);
  }
  return sum;
}

}  // namespace

bool is_half_turn_symmetric(const TargetGrid& grid) {
  const auto& points = grid.points();
  return std::all_of(points.begin(), points.end(), [&](const TargetPoint& p) {
    return std::any_of(points.begin(), points.end(), [&](const TargetPoint& q) {
      return (p.at_m + q.at_m).norm() < 1e-6 * grid.target().pitch_m;
    });
  });
}

PartialCircles place_partial_circles(const Image<std::uint8_t>& tone,
                                     const std::vector<Eigen::Vector2d>& discs_px,
                                     const TargetGrid& grid) {
  PartialCircles result;
  std::vector<Eigen::Vector2d> discs = discs_px;
  if (discs.size() > kMostDiscs) discs.resize(kMostDiscs);
  const Cells cells = largest_lattice(discs);
  result.discs = static_cast<int>(cells.size());
  const std::string seen = std::to_string(cells.size()) + " discs in a lattice are seen";
  if (result.discs < kLeastDiscs) {
    result.reason = seen + "; the least is " + std::to_string(kLeastDiscs);
    return result;
  }
  std::map<Cell, int> places;
  for (std::size_t i = 0; i < grid.points().size(); ++i)
    places[lattice_cell(grid, grid.points()[i])] = static_cast<int>(i);
  const bool staggered = grid.target().kind == TargetKind::asymmetric_circles;
  const double radius = grid.target().mark_share / (staggered ? std::sqrt(2.0) : 1.0);
  const std::vector<Placement> all =
      placements(cells, bare_places(tone, discs, cells, radius), places);
  const bool symmetric = is_half_turn_symmetric(grid);
  const std::string of_grid =
      " a grid of " + std::to_string(grid.columns()) + " x " + std::to_string(grid.rows());
  if (all.empty()) {
    result.status = TargetStatus::wrong_target;
    result.reason = seen + ", which are no part of" + of_grid;
    return result;
  }
  if (all.size() > (symmetric ? 2U : 1U)) {
    result.status = TargetStatus::too_few_points;
    result.reason = seen + ", which fit on" + of_grid + " in " + std::to_string(all.size()) +
                    " ways: too little of its outline is seen";
    return result;
  }
  result.found = found_by(all.front(), cells, discs, places);
  result.status = symmetric ? TargetStatus::half_turn_unknown : TargetStatus::ok;
  if (symmetric) result.reason = "this grid of discs looks the same after half a turn";
  if (all.size() == 2) {
    FoundPixels other = found_by(all.back(), cells, discs, places);
    if (downward(grid, other) > downward(grid, result.found)) result.found = std::move(other);
  }
  return result;
}

}  // namespace cousin
