#include "calibration/board_turns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/imaging/color.h"

namespace cousin {
namespace {

constexpr int kCells = 48;
constexpr int kSamples = 3;  // of a cell, along each axis

std::size_t cell(int column, int row) { return static_cast<std::size_t>(row * kCells + column); }

}  // namespace

TopView::TopView(const Image<Rgb8>& color, const SeedBoard& board, const Camera& camera,
                 const Eigen::Matrix3d& normalized_from_board)
    : cells_(std::size_t{kCells} * kCells, 0.0) {
  const double step_m = board.squares * board.square_m / (kCells * kSamples);
  const double half = 0.5 * kCells * kSamples - 0.5;
  std::vector<double> warm(cells_.size(), 0.0);
  for (int y = 0; y < kCells * kSamples; ++y) {
    for (int x = 0; x < kCells * kSamples; ++x) {
      const auto seen =
          project(camera, normalized_from_board *
                              Eigen::Vector3d((x - half) * step_m, (y - half) * step_m, 1));
      if (!seen) continue;
      const int column = static_cast<int>(std::lround(seen->x()));
      const int row = static_cast<int>(std::lround(seen->y()));
      if (!color.contains(column, row)) continue;
      const Rgb8 c = color(column, row);
      warm[cell(x / kSamples, y / kSamples)] += linear_from_srgb8(c.r) - linear_from_srgb8(c.b);
    }
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const int u = kCells - 1 - x, v = kCells - 1 - y;
      const double mean =
          0.25 * (warm[cell(x, y)] + warm[cell(v, x)] + warm[cell(u, v)] + warm[cell(y, u)]);
      cells_[cell(x, y)] = warm[cell(x, y)] - mean;
    }
  }
}

TopView TopView::turned(int quarters) const {
  TopView result = *this;
  for (int k = 0; k < (quarters % 4 + 4) % 4; ++k) {
    const std::vector<double> before = result.cells_;
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) {
        result.cells_[cell(kCells - 1 - y, x)] = before[cell(x, y)];
      }
    }
  }
  return result;
}

void TopView::add(const TopView& other) {
  if (cells_.empty()) cells_.assign(other.cells_.size(), 0.0);
  for (std::size_t i = 0; i < cells_.size(); ++i) cells_[i] += other.cells_[i];
}

double TopView::correlation(const TopView& other) const {
  if (cells_.size() != other.cells_.size()) return 0;
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    aa += cells_[i] * cells_[i];
    bb += other.cells_[i] * other.cells_[i];
    ab += cells_[i] * other.cells_[i];
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

std::optional<int> turn_of_specimens(const TopView& all, const TopView& view) {
  constexpr double kLeast = 0.4, kLead = 0.4;
  std::array<double, 4> scores{};
  for (int k = 0; k < 4; ++k) {
    scores[static_cast<std::size_t>(k)] = all.correlation(view.turned(k));
  }
  const auto best = std::max_element(scores.begin(), scores.end());
  const int turn = static_cast<int>(best - scores.begin());
  const double score = *best;
  *best = -1;
  const double next = *std::max_element(scores.begin(), scores.end());
  if (score < kLeast || score - next < kLead) return std::nullopt;
  return turn;
}

std::vector<TurnCosts> least_totals(const std::vector<TurnCosts>& costs,
                                    const std::vector<TurnCosts>& leaps) {
  // Least cost of everything before (or after) a view, given its turn.
  const auto passed_on = [](const TurnCosts& from, const TurnCosts& leap, bool forward) {
    TurnCosts to;
    to.fill(std::numeric_limits<double>::infinity());
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        const std::size_t turn = forward ? (b + 4 - a) % 4 : (a + 4 - b) % 4;
        to[b] = std::min(to[b], from[a] + leap[turn]);
      }
    }
    return to;
  };
  const auto sum = [](TurnCosts a, const TurnCosts& b) {
    for (std::size_t k = 0; k < 4; ++k) a[k] += b[k];
    return a;
  };
  const std::size_t n = costs.size();
  std::vector<TurnCosts> before(n, TurnCosts{}), after(n, TurnCosts{}), totals(n);
  for (std::size_t v = 1; v < n; ++v) {
    before[v] = passed_on(sum(before[v - 1], costs[v - 1]), leaps[v - 1], true);
  }
  for (std::size_t v = n - 1; v-- > 0;) {
    after[v] = passed_on(sum(after[v + 1], costs[v + 1]), leaps[v], false);
  }
  for (std::size_t v = 0; v < n; ++v) totals[v] = sum(sum(before[v], costs[v]), after[v]);
  return totals;
}

}  // namespace cousin
