#include "benchmarks/score/specimens.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Column of each row in a square assignment of least cost: shortest augmenting paths with
/// potentials, one row at a time. Index 0 of the work arrays stands for "none".
std::vector<int> assign(const std::vector<std::vector<double>>& cost) {
  const std::size_t n = cost.size();
  std::vector<double> row_potential(n + 1), column_potential(n + 1);
  std::vector<std::size_t> row_of(n + 1), previous(n + 1);
  for (std::size_t row = 1; row <= n; ++row) {
    row_of[0] = row;
    std::size_t column = 0;
    std::vector<double> slack(n + 1, kInfinity);
    std::vector<bool> visited(n + 1, false);
    do {
      visited[column] = true;
      const std::size_t active = row_of[column];
      double step = kInfinity;
      std::size_t next = 0;
      for (std::size_t j = 1; j <= n; ++j) {
        if (visited[j]) continue;
        const double reduced =
            cost[active - 1][j - 1] - row_potential[active] - column_potential[j];
        if (reduced < slack[j]) {
          slack[j] = reduced;
          previous[j] = column;
        }
        if (slack[j] < step) {
          step = slack[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j <= n; ++j) {
        if (visited[j]) {
          row_potential[row_of[j]] += step;
          column_potential[j] -= step;
        } else {
          slack[j] -= step;
        }
      }
      column = next;
    } while (row_of[column] != 0);
    // Flip the pairs along the path found.
    while (column != 0) {
      row_of[column] = row_of[previous[column]];
      column = previous[column];
    }
  }
  std::vector<int> column_of(n);
  for (std::size_t j = 1; j <= n; ++j) column_of[row_of[j] - 1] = static_cast<int>(j - 1);
  return column_of;
}

}  // namespace

SpecimenMatching match_specimens(std::span<const Eigen::Vector3d> measured_in_world_m,
                                 std::span<const Eigen::Vector3d> truth_in_world_m, double gate_m) {
  if (!(gate_m > 0)) {
    throw std::invalid_argument("match_specimens: gate " + std::to_string(gate_m) +
                                " m must be positive");
  }
  // Padded to a square. A forbidden pair costs more than all allowed pairs together, so the number
  // of pairs counts first. Costs are in units of the gate.
  const std::size_t n = std::max(measured_in_world_m.size(), truth_in_world_m.size());
  const double forbidden = 2.0 * static_cast<double>(n) + 1;
  std::vector<std::vector<double>> cost(n, std::vector<double>(n, forbidden));
  for (std::size_t i = 0; i < measured_in_world_m.size(); ++i) {
    for (std::size_t j = 0; j < truth_in_world_m.size(); ++j) {
      const double distance = (measured_in_world_m[i] - truth_in_world_m[j]).norm() / gate_m;
      if (distance <= 1) cost[i][j] = distance;  // false for NaN
    }
  }
  const std::vector<int> column_of = assign(cost);

  SpecimenMatching result;
  std::vector<bool> found(truth_in_world_m.size(), false);
  for (std::size_t i = 0; i < measured_in_world_m.size(); ++i) {
    const auto j = static_cast<std::size_t>(column_of[i]);
    if (cost[i][j] <= 1) {
      found[j] = true;
      result.matches.push_back({static_cast<int>(i), static_cast<int>(j), cost[i][j] * gate_m});
    } else {
      result.spurious.push_back(static_cast<int>(i));
    }
  }
  for (std::size_t j = 0; j < found.size(); ++j) {
    if (!found[j]) result.missed.push_back(static_cast<int>(j));
  }
  return result;
}

}  // namespace cousin
