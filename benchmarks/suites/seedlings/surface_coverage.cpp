#include "benchmarks/suites/seedlings/surface_coverage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kBehind_m = 0.002;

/// The farthest depth about a pixel: infinite where there is no surface.
double farthest_m(const Image<float>& depth_m, int x, int y) {
  double farthest = 0;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (!depth_m.contains(u, v)) continue;
      const float depth = depth_m(u, v);
      farthest = std::isnan(depth) ? std::numeric_limits<double>::infinity()
                                   : std::max(farthest, static_cast<double>(depth));
      if (std::isinf(farthest)) return farthest;
    }
  }
  return farthest;
}

bool sees(const DepthSight& view, const Lens& lens, const Eigen::Vector3d& point_in_world_m) {
  const Eigen::Vector3d in_camera_m =
      view.camera_from_world.rotation * point_in_world_m + view.camera_from_world.translation_m;
  if (!(in_camera_m.z() > 0)) return false;
  const auto pixel = lens.project(in_camera_m);
  if (!pixel) return false;
  if (!(pixel->x() > -0.5 && pixel->x() < view.camera.width_px - 0.5 && pixel->y() > -0.5 &&
        pixel->y() < view.camera.height_px - 0.5))
    return false;
  const int x = static_cast<int>(std::lround(pixel->x()));
  const int y = static_cast<int>(std::lround(pixel->y()));
  if (view.shown && (*view.shown)(x, y) == 0) return false;
  const double surface_m = farthest_m(*view.depth_m, x, y);
  return !(in_camera_m.z() > surface_m + kBehind_m);
}

template <class Pixel>
void check_size(const char* what, const Image<Pixel>& image, const Camera& camera) {
  if (image.width() == camera.width_px && image.height() == camera.height_px) return;
  throw std::invalid_argument(
      "coverage: a " + std::string(what) + " of " + std::to_string(image.width()) + " x " +
      std::to_string(image.height()) + " for a camera of " + std::to_string(camera.width_px) +
      " x " + std::to_string(camera.height_px));
}

}  // namespace

Image<std::uint16_t> views_that_see(const Image<Eigen::Vector3f>& position_m,
                                    std::span<const DepthSight> views) {
  std::vector<Lens> lenses;
  for (const DepthSight& view : views) {
    check_size("depth image", *view.depth_m, view.camera);
    if (view.shown) check_size("mask", *view.shown, view.camera);
    lenses.emplace_back(view.camera);
  }
  Image<std::uint16_t> seen(position_m.width(), position_m.height());
  tbb::parallel_for(0, position_m.height(), [&](int y) {
    for (int x = 0; x < position_m.width(); ++x) {
      const Eigen::Vector3d point_m = position_m(x, y).cast<double>();
      if (!point_m.allFinite()) continue;
      for (std::size_t i = 0; i < views.size(); ++i)
        seen(x, y) = static_cast<std::uint16_t>(seen(x, y) + sees(views[i], lenses[i], point_m));
    }
  });
  return seen;
}

void CoverageShare::add(const Image<std::uint16_t>& seen, const Image<std::uint8_t>& mask) {
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!mask.empty() && mask.data()[i] == 0) continue;
    const std::size_t count = seen.data()[i];
    if (count >= by_count_.size()) by_count_.resize(count + 1);
    ++by_count_[count];
    ++points_;
  }
}

double CoverageShare::seen_by(int views) const {
  if (points_ == 0) return std::nan("");
  std::int64_t enough = 0;
  for (std::size_t i = static_cast<std::size_t>(std::max(0, views)); i < by_count_.size(); ++i)
    enough += by_count_[i];
  return static_cast<double>(enough) / static_cast<double>(points_);
}

}  // namespace cousin
