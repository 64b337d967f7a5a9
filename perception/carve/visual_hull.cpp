#include "perception/carve/visual_hull.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

/// Number of object pixels in any rectangle by four look-ups [Crow, SIGGRAPH 1984].
class AreaTable {
 public:
  explicit AreaTable(const Image<std::uint8_t>& mask)
      : width_(mask.width()),
        height_(mask.height()),
        sums_(mask.width() + 1, mask.height() + 1, 0) {
    for (int y = 0; y < height_; ++y) {
      std::uint32_t row = 0;
      for (int x = 0; x < width_; ++x) {
        row += mask(x, y) != 0 ? 1 : 0;
        sums_(x + 1, y + 1) = sums_(x + 1, y) + row;
      }
    }
  }
  /// Whether the square about `centre_px` holds object pixels; true if it lies outside the image
  /// altogether, or if it must be `whole` and a part of it does.
  bool may_see(const Eigen::Vector2d& centre_px, double half_px, bool whole) const {
    const auto low = [](double v) { return std::ceil(std::max(-1e8, v - 0.5)); };
    const auto high = [](double v) { return std::floor(std::min(1e8, v + 0.5)); };
    // A square smaller than a pixel is the pixel its centre is in.
    const double x0 = low(centre_px.x() - half_px), x1 = high(centre_px.x() + half_px);
    const double y0 = low(centre_px.y() - half_px), y1 = high(centre_px.y() + half_px);
    if (x1 < 0 || y1 < 0 || x0 > width_ - 1 || y0 > height_ - 1) return true;
    if (whole && (x0 < 0 || y0 < 0 || x1 > width_ - 1 || y1 > height_ - 1)) return true;
    const int left = static_cast<int>(std::max(0.0, x0)),
              right = static_cast<int>(std::min(width_ - 1.0, x1)) + 1;
    const int top = static_cast<int>(std::max(0.0, y0)),
              bottom = static_cast<int>(std::min(height_ - 1.0, y1)) + 1;
    return sums_(right, bottom) - sums_(left, bottom) - sums_(right, top) + sums_(left, top) > 0;
  }

 private:
  int width_, height_;
  Image<std::uint32_t> sums_;
};

using Cell = std::array<std::int32_t, 3>;

/// Half of a square about `centre_px` that bounds the image of a sphere; infinite if it has none.
/// Seen from a pinhole at the angle t off the axis, a sphere reaches to tan(t + a), sin a = radius
/// / distance. A lens keeps the border of the square that bounds it there outside of what is
/// inside.
double reach_px(const Camera& camera, const Eigen::Vector2d& centre_px,
                const Eigen::Vector3d& centre_m, double radius_m) {
  const double across = std::acos(centre_m.z() / centre_m.norm());
  const double sine = radius_m / centre_m.norm();  // below 1: z is above the radius
  const double farthest = std::cos(across + std::asin(sine));
  if (!(farthest > 0)) return std::numeric_limits<double>::infinity();
  const double reach = sine / (std::cos(across) * farthest);
  double half_px = 0;
  for (const int x : {-1, 0, 1}) {
    for (const int y : {-1, 0, 1}) {
      const Eigen::Vector3d ray(centre_m.x() / centre_m.z() + x * reach,
                                centre_m.y() / centre_m.z() + y * reach, 1);
      const auto pixel = project(camera, ray);
      if (!pixel) return std::numeric_limits<double>::infinity();
      half_px = std::max(half_px, (*pixel - centre_px).lpNorm<Eigen::Infinity>());
    }
  }
  return half_px;
}

/// @param last  the cube is a voxel: its own projected side counts, and the part in the image
bool keeps(const std::vector<CarveView>& views, const std::vector<AreaTable>& tables,
           const Eigen::Vector3d& centre_m, double radius_m, bool last, int tolerated) {
  int misses = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const CarveView& view = views[i];
    const Eigen::Vector3d point = view.camera_from_world * centre_m;
    if (point.z() <= radius_m) continue;  // around or behind the camera: this view cannot carve it
    const auto pixel = project(view.camera, point);
    if (!pixel) continue;
    const double half_px =
        last ? std::max(view.camera.fx_px, view.camera.fy_px) * radius_m / (point.z() - radius_m)
             : reach_px(view.camera, *pixel, point, radius_m);
    if (!std::isfinite(half_px)) continue;
    if (!tables[i].may_see(*pixel, half_px, !last) && ++misses > tolerated) return false;
  }
  return true;
}

}  // namespace

void validate(const CarveConfig& config) {
  const Eigen::Vector3d size = config.high_m - config.low_m;
  if (!(config.voxel_m > 0) || !size.allFinite() || !(size.minCoeff() > 0)) {
    throw std::invalid_argument("carving: voxel_m must be positive and high_m above low_m");
  }
  if (size.maxCoeff() / config.voxel_m > 16384) {
    throw std::invalid_argument("carving: voxel_m = " + std::to_string(config.voxel_m) +
                                " gives more than 16384 voxels a side");
  }
  if (config.tolerated_misses < 0)
    throw std::invalid_argument("carving: tolerated_misses is negative");
}

Carving carve_visual_hull(const std::vector<CarveView>& views, const CarveConfig& config) {
  validate(config);
  Carving result;
  result.voxel_m = config.voxel_m;
  if (views.empty()) return result;
  std::vector<AreaTable> tables;
  for (const CarveView& view : views) {
    validate(view.camera);
    if (view.mask.width() != view.camera.width_px || view.mask.height() != view.camera.height_px) {
      throw std::invalid_argument("carving: a mask has another size than its camera");
    }
    tables.emplace_back(view.mask);
  }
  const Eigen::Vector3d size = config.high_m - config.low_m;
  const Eigen::Array3d finest = (size / config.voxel_m).array().ceil();
  int levels = 0;
  while ((1 << levels) < finest.maxCoeff()) ++levels;
  std::vector<Cell> cells = {{0, 0, 0}};
  for (int level = 0; level <= levels; ++level) {
    const double side_m = config.voxel_m * (1 << (levels - level));
    const bool last = level == levels;
    // Inner cubes must not be lost: their bounding sphere. Voxels: half their side.
    const double radius_m = last ? 0.5 * side_m : 0.5 * std::sqrt(3.0) * side_m;
    std::vector<std::uint8_t> kept(cells.size());
    tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t i) {
      const Eigen::Vector3d index(cells[i][0], cells[i][1], cells[i][2]);
      const Eigen::Vector3d low = index * side_m;
      if ((low.array() >= size.array()).any()) return;
      const Eigen::Vector3d centre = config.low_m + low + Eigen::Vector3d::Constant(0.5 * side_m);
      kept[i] = keeps(views, tables, centre, radius_m, last, config.tolerated_misses) ? 1 : 0;
    });
    std::vector<Cell> next;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (!kept[i]) continue;
      if (last) {
        next.push_back(cells[i]);
        continue;
      }
      for (int child = 0; child < 8; ++child) {
        next.push_back({2 * cells[i][0] + (child & 1), 2 * cells[i][1] + (child >> 1 & 1),
                        2 * cells[i][2] + (child >> 2)});
      }
    }
    cells = std::move(next);
  }
  std::sort(cells.begin(), cells.end());
  for (const Cell& cell : cells) {
    result.centres_m.push_back(config.low_m +
                               config.voxel_m * (Eigen::Vector3d(cell[0], cell[1], cell[2]) +
                                                 Eigen::Vector3d::Constant(0.5)));
  }
  result.status = cells.empty() ? CarveStatus::empty : CarveStatus::ok;
  return result;
}

std::vector<CarveView> silhouette_views(const Capture& capture) {
  std::vector<CarveView> views;
  for (const Frame& frame : capture.frames) {
    if (!frame.rig_from_world || frame.sensors.empty() || frame.sensors[0].color.empty()) continue;
    const SensorFrame& sensor = frame.sensors[0];
    CarveView view{sensor.reported, *frame.rig_from_world,
                   Image<std::uint8_t>(sensor.color.width(), sensor.color.height())};
    std::transform(sensor.color.begin(), sensor.color.end(), view.mask.begin(), [](const Rgb8& c) {
      return static_cast<std::uint8_t>(c.r > 127 || c.g > 127 || c.b > 127 ? 255 : 0);
    });
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace cousin
