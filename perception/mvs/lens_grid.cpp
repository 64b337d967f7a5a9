#include "perception/mvs/lens_grid.h"

#include <algorithm>
#include <array>
#include <limits>

#include "sim/types/no_value.h"

namespace cousin {
namespace {

constexpr int kStep = 16;
constexpr int kLeastCells = 2;  ///< a node beyond the edge is extrapolated from three

int cells(int size) { return std::max(kLeastCells, (size - 2) / kStep + 1); }

std::array<float, 4> cubic_weights(float t) {
  return {((-0.5F * t + 1.0F) * t - 0.5F) * t, (1.5F * t - 2.5F) * t * t + 1.0F,
          ((-1.5F * t + 2.0F) * t + 0.5F) * t, (0.5F * t - 0.5F) * t * t};
}

}  // namespace

LensGrid::LensGrid(const PixelRect& rect, const Map& map)
    : rect_(rect),
      columns_(cells(rect.width) + 3),
      rows_(cells(rect.height) + 3),
      step_x_(static_cast<float>(std::max(rect.width - 1, 1)) / static_cast<float>(columns_ - 3)),
      step_y_(static_cast<float>(std::max(rect.height - 1, 1)) / static_cast<float>(rows_ - 3)) {
  const auto at = [&](int column, int row) -> Eigen::Vector2f& {
    return nodes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  };
  nodes_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (int row = 1; row < rows_ - 1; ++row) {
    for (int column = 1; column < columns_ - 1; ++column) {
      const auto value = map({rect.x0 + static_cast<double>(column - 1) * step_x_,
                              rect.y0 + static_cast<double>(row - 1) * step_y_});
      at(column, row) =
          value ? Eigen::Vector2f(value->cast<float>()) : Eigen::Vector2f::Constant(kNone);
    }
  }
  for (int row = 1; row < rows_ - 1; ++row) {
    at(0, row) = 3 * at(1, row) - 3 * at(2, row) + at(3, row);
    at(columns_ - 1, row) =
        3 * at(columns_ - 2, row) - 3 * at(columns_ - 3, row) + at(columns_ - 4, row);
  }
  for (int column = 0; column < columns_; ++column) {
    at(column, 0) = 3 * at(column, 1) - 3 * at(column, 2) + at(column, 3);
    at(column, rows_ - 1) =
        3 * at(column, rows_ - 2) - 3 * at(column, rows_ - 3) + at(column, rows_ - 4);
  }
}

Eigen::Vector2f LensGrid::operator()(float x, float y) const {
  const float px = x - static_cast<float>(rect_.x0), py = y - static_cast<float>(rect_.y0);
  if (!(px >= 0 && py >= 0 && px <= static_cast<float>(rect_.width - 1) &&
        py <= static_cast<float>(rect_.height - 1))) {
    return Eigen::Vector2f::Constant(kNone);
  }
  const float u = px / step_x_, v = py / step_y_;
  const int column = std::min(static_cast<int>(u), columns_ - 4);
  const int row = std::min(static_cast<int>(v), rows_ - 4);
  const std::array<float, 4> wx = cubic_weights(u - static_cast<float>(column));
  const std::array<float, 4> wy = cubic_weights(v - static_cast<float>(row));
  const Eigen::Vector2f* node = nodes_.data() +
                                static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                static_cast<std::size_t>(column);
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  for (std::size_t j = 0; j < 4; ++j, node += columns_) {
    sum += wy[j] * (wx[0] * node[0] + wx[1] * node[1] + wx[2] * node[2] + wx[3] * node[3]);
  }
  return sum;
}

}  // namespace cousin
