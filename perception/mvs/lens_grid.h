#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

namespace cousin {

/// Pixels x0 <= x < x0 + width, y0 <= y < y0 + height.
struct PixelRect {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
  bool contains(int x, int y) const {
    return x >= x0 && y >= y0 && x < x0 + width && y < y0 + height;
  }
};

/// A smooth map of the plane, tabulated every 16 pixels or less and interpolated by cubics
/// (Catmull-Rom): lens maps are costly to evaluate (Newton, safeguards) and smooth (error below
/// 0.002 px for phone lenses and fisheyes). The map is only asked inside the rectangle.
class LensGrid {
 public:
  using Map = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>;
  LensGrid() = default;
  LensGrid(const PixelRect& rect, const Map& map);

  /// NaN outside the rectangle, and where the map has no value at a node around the point.
  Eigen::Vector2f operator()(float x, float y) const;

 private:
  PixelRect rect_;
  int columns_ = 0;  ///< of nodes, with one extrapolated on each side
  int rows_ = 0;
  float step_x_ = 1;  ///< pixels between nodes
  float step_y_ = 1;
  std::vector<Eigen::Vector2f> nodes_;
};

}  // namespace cousin
