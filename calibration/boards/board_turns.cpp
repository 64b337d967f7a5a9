#include "calibration/boards/board_turns.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/imaging/color.h"
#include "sim/types/pose.h"

namespace cousin {
namespace {

constexpr int kCells = 48;
constexpr int kSamples = 3;  // of a cell, along each axis

using TurnCosts = std::array<double, 4>;  ///< one for each quarter turn

std::size_t cell(int column, int row) { return static_cast<std::size_t>(row * kCells + column); }

/// What lies on a board, seen from above: warm colour (red less blue, linear) on a grid over the
/// checkerboard, without what is the same after each quarter turn.
class TopView {
 public:
  TopView() = default;
  TopView(const PlacedBoard& view, const SeedBoard& board);
  /// Turned counter-clockwise about the board's normal by quarters.
  TopView turned(int quarters) const;
  void add(const TopView& other);
  /// Of two views, -1..1; 0 where one shows nothing that a quarter turn would change.
  double correlation(const TopView& other) const;

 private:
  std::vector<double> cells_;
};

TopView::TopView(const PlacedBoard& view, const SeedBoard& board)
    : cells_(std::size_t{kCells} * kCells, 0.0) {
  const double step_m = board.squares * board.square_m / (kCells * kSamples);
  const double half = 0.5 * kCells * kSamples - 0.5;
  std::vector<double> warm(cells_.size(), 0.0);
  for (int y = 0; y < kCells * kSamples; ++y) {
    for (int x = 0; x < kCells * kSamples; ++x) {
      const auto seen =
          project(view.camera, view.normalized_from_board *
                                   Eigen::Vector3d((x - half) * step_m, (y - half) * step_m, 1));
      if (!seen) continue;
      const int column = static_cast<int>(std::lround(seen->x()));
      const int row = static_cast<int>(std::lround(seen->y()));
      if (!view.color->contains(column, row)) continue;
      const Rgb8 c = (*view.color)(column, row);
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

/// The quarter turns by which a view must be turned to show what `all` shows. Nothing if no turn
/// stands out clearly.
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

/// For each view of a sequence and each turn of it, the least total cost of all views' turns.
/// @param costs  of each view's turn
/// @param leaps  between each view and the next, by (turn of the next less turn of this) modulo 4
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

/// Rotation camera from board nearest to a homography.
Eigen::Quaterniond rotation_of(const Eigen::Matrix3d& h) {
  Eigen::Matrix3d m = h / std::sqrt(h.col(0).norm() * h.col(1).norm());
  m.col(2) = m.col(0).cross(m.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose()));
}

/// Indices of the views, the steepest first.
std::vector<std::size_t> steepest_first(const std::vector<PlacedBoard>& views) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Matrix3d& h = views[i].normalized_from_board;
    const Eigen::Vector3d normal = rotation_of(h) * Eigen::Vector3d::UnitZ();
    order.emplace_back(-std::abs(h.col(2).normalized().dot(normal)), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> result;
  for (const auto& [steepness, i] : order) result.push_back(i);
  return result;
}

/// For each view and quarter turn, how little it shows what the others show: kWeight (1 -
/// correlation). Specimens in plain sight outweigh a leap.
std::vector<TurnCosts> costs_of_specimens(const std::vector<PlacedBoard>& views,
                                          const SeedBoard& board,
                                          const std::vector<std::size_t>& order) {
  constexpr double kWeight = 2;
  TopView all;
  std::vector<TopView> tops(views.size());
  for (const std::size_t i : order) {
    tops[i] = TopView(views[i], board);
    const std::optional<int> turn =
        i == order.front() ? std::optional<int>(0) : turn_of_specimens(all, tops[i]);
    if (turn) all.add(tops[i].turned(*turn));
  }
  std::vector<TurnCosts> costs(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (int k = 0; k < 4; ++k) {
      // Axes turn against what they measure.
      costs[i][static_cast<std::size_t>(k)] =
          kWeight * (1 - all.correlation(tops[i].turned(4 - k)));
    }
  }
  return costs;
}

/// Between a view and the next, by the difference of their turns: (angle / largest turn)^2, at most
/// 1.
TurnCosts costs_of_leap(const PlacedBoard& here, const PlacedBoard& next, double max_turn_rad) {
  const Eigen::Quaterniond from = rotation_of(here.normalized_from_board);
  const Eigen::Quaterniond to = rotation_of(next.normalized_from_board);
  TurnCosts costs{};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Quaterniond about_z(Eigen::AngleAxisd(0.5 * M_PI * k, Eigen::Vector3d::UnitZ()));
    const double ratio = angle_rad(to * about_z * from.conjugate()) / max_turn_rad;
    costs[static_cast<std::size_t>(k)] = std::min(1.0, ratio * ratio);
  }
  return costs;
}

}  // namespace

std::vector<std::optional<int>> quarter_turns(const std::vector<PlacedBoard>& views,
                                              const SeedBoard& board, double max_turn_rad) {
  constexpr double kClear = 0.1;
  if (views.empty()) return {};
  const std::vector<std::size_t> order = steepest_first(views);
  std::vector<TurnCosts> costs = costs_of_specimens(views, board, order);
  costs[order.front()] = {0, 1e6, 1e6, 1e6};  // it defines the frame
  std::vector<TurnCosts> leaps;
  for (std::size_t v = 0; v + 1 < views.size(); ++v) {
    leaps.push_back(costs_of_leap(views[v], views[v + 1], max_turn_rad));
  }
  std::vector<std::optional<int>> turns;
  for (const TurnCosts& total : least_totals(costs, leaps)) {
    TurnCosts sorted = total;
    std::sort(sorted.begin(), sorted.end());
    const auto best = std::min_element(total.begin(), total.end()) - total.begin();
    const bool clear = sorted[1] - sorted[0] >= kClear;
    turns.push_back(clear ? std::optional<int>(static_cast<int>(best)) : std::nullopt);
  }
  return turns;
}

}  // namespace cousin
