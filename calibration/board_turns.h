#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "sim/types/board.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"

namespace cousin {

/// What lies on a board, seen from above: warm colour (red less blue, linear, over the brightest)
/// on a grid over the plate, without what is the same after each quarter turn.
class TopView {
 public:
  TopView() = default;
  TopView(const Image<Rgb8>& color, const SeedBoard& board, const Camera& camera,
          const Eigen::Matrix3d& normalized_from_board);
  /// Turned counter-clockwise about the board's normal by quarters.
  TopView turned(int quarters) const;
  void add(const TopView& other);
  /// Of two views, -1..1; 0 where one shows nothing that a quarter turn would change.
  double correlation(const TopView& other) const;

 private:
  std::vector<double> cells_;
};

/// The quarter turns by which a view must be turned to show what `all` shows. Nothing if no turn
/// stands out clearly.
std::optional<int> turn_of_specimens(const TopView& all, const TopView& view);

/// A cost for each quarter turn.
using TurnCosts = std::array<double, 4>;

/// For each view of a sequence and each turn of it, the least total cost of all views' turns.
/// @param costs  of each view's turn
/// @param leaps  between each view and the next, by (turn of the next less turn of this) modulo 4
std::vector<TurnCosts> least_totals(const std::vector<TurnCosts>& costs,
                                    const std::vector<TurnCosts>& leaps);

}  // namespace cousin
