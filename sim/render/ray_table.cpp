#include "sim/render/ray_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace cousin {
namespace {

using Direction = Eigen::Vector3d;

Direction exact(const Lens& lens, double x, double y) {
  return lens.unproject({x, y}).value_or(Direction::Zero());
}

/// Nodes evenly spread from the first to the last point of one axis.
struct Axis {
  double first = 0;
  double step = 1;
  int nodes = 1;
};

Axis make_axis(double first, int points, double wanted_step) {
  const int cells = std::max(1, static_cast<int>(std::ceil((points - 1) / wanted_step)));
  return {first, std::max(1, points - 1) / static_cast<double>(cells), cells + 1};
}

/// Nodes about a point and their Lagrange weights of degree 5.
constexpr int kTaps = 6;
struct Stencil {
  int first = 0;
  std::array<double, kTaps> weight{};
};

Stencil make_stencil(const Axis& axis, double x) {
  const double position = (x - axis.first) / axis.step;
  Stencil s;
  s.first =
      std::clamp(static_cast<int>(std::floor(position)) - (kTaps / 2 - 1), 0, axis.nodes - kTaps);
  const double t = position - s.first;  // nodes at 0, 1, ..., 5
  const double t0 = t, t1 = t - 1, t2 = t - 2, t3 = t - 3, t4 = t - 4, t5 = t - 5;
  const double low = t0 * t1 * t2, high = t3 * t4 * t5;
  s.weight = {t1 * t2 * high / -120, t0 * t2 * high / 24, t0 * t1 * high / -12,
              low * t4 * t5 / 12,    low * t3 * t5 / -24, low * t3 * t4 / 120};
  return s;
}

struct NodeGrid {
  Axis x, y;
  std::vector<Direction> nodes;

  const Direction& at(int i, int j) const {
    return nodes[static_cast<std::size_t>(j) * static_cast<std::size_t>(x.nodes) +
                 static_cast<std::size_t>(i)];
  }
};

NodeGrid make_grid(const Lens& lens, double first_x, double first_y, int width, int height,
                   double step) {
  NodeGrid grid{make_axis(first_x, width, step), make_axis(first_y, height, step), {}};
  grid.nodes.resize(static_cast<std::size_t>(grid.x.nodes) *
                    static_cast<std::size_t>(grid.y.nodes));
  tbb::parallel_for(0, grid.y.nodes, [&](int j) {
    for (int i = 0; i < grid.x.nodes; ++i) {
      grid.nodes[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.x.nodes) +
                 static_cast<std::size_t>(i)] =
          exact(lens, grid.x.first + i * grid.x.step, grid.y.first + j * grid.y.step);
    }
  });
  return grid;
}

/// One row of interpolated directions; columns whose stencil lacks a node are zero and `complete`
/// is false.
class RowInterpolator {
 public:
  RowInterpolator(const NodeGrid& grid, double y)
      : grid_(grid), column_(static_cast<std::size_t>(grid.x.nodes)) {
    const Stencil s = make_stencil(grid.y, y);
    for (int i = 0; i < grid.x.nodes; ++i) {
      Direction sum = Direction::Zero();
      bool complete = true;
      for (int k = 0; k < kTaps; ++k) {
        const Direction& node = grid.at(i, s.first + k);
        complete = complete && !node.isZero(0);
        sum += s.weight[static_cast<std::size_t>(k)] * node;
      }
      column_[static_cast<std::size_t>(i)] = complete ? sum : Direction::Zero();
    }
  }
  Direction operator()(double x) const {
    const Stencil s = make_stencil(grid_.x, x);
    const Direction* d = column_.data() + s.first;
    Direction sum = Direction::Zero();
    for (int k = 0; k < kTaps; ++k) {
      if (d[k].isZero(0)) return Direction::Zero();
      sum += s.weight[static_cast<std::size_t>(k)] * d[k];
    }
    return sum.normalized();
  }

 private:
  const NodeGrid& grid_;
  std::vector<Direction> column_;
};

/// Largest angle between interpolated and exact directions at cell centres, every eighth cell and
/// the rim.
double largest_error(const Lens& lens, const NodeGrid& grid) {
  double largest = 0;
  const int cells_x = grid.x.nodes - 1, cells_y = grid.y.nodes - 1;
  const auto next = [](int i, int cells) {
    return i == cells - 1 ? cells : std::min(i + 8, cells - 1);
  };
  for (int j = 0; j < cells_y; j = next(j, cells_y)) {
    const double y = grid.y.first + (j + 0.5) * grid.y.step;
    const RowInterpolator row(grid, y);
    for (int i = 0; i < cells_x; i = next(i, cells_x)) {
      const double x = grid.x.first + (i + 0.5) * grid.x.step;
      const Direction a = row(x), b = exact(lens, x, y);
      if (!a.isZero(0) && !b.isZero(0)) largest = std::max(largest, (a - b).norm());
    }
  }
  return largest;
}

}  // namespace

std::vector<Direction> lens_directions(const Camera& camera, double first_x, double first_y,
                                       int width, int height, double tolerance_px) {
  std::vector<Direction> directions(static_cast<std::size_t>(width) *
                                    static_cast<std::size_t>(height));
  const double tolerance_rad = tolerance_px / std::max(camera.fx_px, camera.fy_px);
  const Lens lens(camera);
  NodeGrid grid;
  double step = 32;
  bool interpolates = false;
  for (; step > 1 && !interpolates; step *= 0.5) {
    if ((width - 1) / step < kTaps || (height - 1) / step < kTaps) continue;
    grid = make_grid(lens, first_x, first_y, width, height, step);
    interpolates = largest_error(lens, grid) < tolerance_rad;
  }
  tbb::parallel_for(0, height, [&](int j) {
    const double y = first_y + j;
    Direction* out =
        directions.data() + static_cast<std::size_t>(j) * static_cast<std::size_t>(width);
    if (!interpolates) {
      for (int i = 0; i < width; ++i) out[i] = exact(lens, first_x + i, y);
      return;
    }
    const RowInterpolator row(grid, y);
    for (int i = 0; i < width; ++i) {
      out[i] = row(first_x + i);
      if (out[i].isZero(0)) out[i] = exact(lens, first_x + i, y);
    }
  });
  return directions;
}

}  // namespace cousin
