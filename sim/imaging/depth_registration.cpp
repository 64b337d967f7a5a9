#include "sim/imaging/depth_registration.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/types/image.h"

namespace cousin {
namespace {

/// A depth pixel in the other image: the rectangle of whole pixels that its square covers.
struct Footprint {
  std::int16_t left = 0, top = 0, right = -1, bottom = -1;
  std::uint16_t depth = 0;
};

/// Directions of all corners between pixels, at depth 1; NaN where the lens has no ray.
std::vector<Eigen::Vector3f> corner_rays(const Camera& camera) {
  const Lens lens(camera);
  const int columns = camera.width_px + 1, rows = camera.height_px + 1;
  std::vector<Eigen::Vector3f> rays(static_cast<std::size_t>(columns) *
                                    static_cast<std::size_t>(rows));
  tbb::parallel_for(0, rows, [&](int y) {
    for (int x = 0; x < columns; ++x) {
      const auto ray = lens.unproject({x - 0.5, y - 0.5});
      Eigen::Vector3f& out = rays[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                                  static_cast<std::size_t>(x)];
      out = ray && ray->z() > 0
                ? Eigen::Vector3f((*ray / ray->z()).cast<float>())
                : Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    }
  });
  return rays;
}

/// Range of whole pixels whose centres lie in [low, high) or just beside, at least one, cut at the
/// image; empty if outside.
bool whole_pixels(double low, double high, int size, std::int16_t& first, std::int16_t& last) {
  // Neighbours of unlike depth come apart; what is behind a slanted surface would show between
  // them. The same image still comes out of the same camera.
  constexpr double kOverlap_px = 0.49;
  if (!(low < high)) std::swap(low, high);
  low -= kOverlap_px;
  high += kOverlap_px;
  if (!(high >= -0.5 && low <= size - 0.5)) return false;
  const double from = std::ceil(low), to = std::ceil(high) - 1;
  const double middle = std::round(0.5 * (low + high));
  first = static_cast<std::int16_t>(std::clamp(from > to ? middle : from, 0.0, size - 1.0));
  last = static_cast<std::int16_t>(std::clamp(from > to ? middle : to, 0.0, size - 1.0));
  return true;
}

}  // namespace

Image<std::uint16_t> register_depth(const Image<std::uint16_t>& depth, double unit_m,
                                    const Camera& depth_camera, const Camera& other,
                                    const Pose& other_from_depth) {
  validate(depth_camera);
  validate(other);
  if (depth.width() != depth_camera.width_px || depth.height() != depth_camera.height_px)
    throw std::invalid_argument("register_depth: the image is not of the camera's size");
  if (other.width_px > 32767 || other.height_px > 32767)
    throw std::invalid_argument("register_depth: the other image is larger than 32767 pixels");
  if (!(unit_m > 0)) {
    throw std::invalid_argument("register_depth: unit_m = " + std::to_string(unit_m) +
                                " must be positive");
  }
  const std::vector<Eigen::Vector3f> rays = corner_rays(depth_camera);
  const Eigen::Matrix3d rotation = other_from_depth.rotation.toRotationMatrix();
  const Lens to_other(other);
  const auto stride = static_cast<std::size_t>(depth.width()) + 1;
  Image<Footprint> footprints(depth.width(), depth.height());
  tbb::parallel_for(0, depth.height(), [&](int y) {
    for (int x = 0; x < depth.width(); ++x) {
      if (depth(x, y) == 0) continue;
      const double z = depth(x, y) * unit_m;
      const std::size_t at = static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x);
      const Eigen::Vector3d a = rays[at].cast<double>() * z;
      const Eigen::Vector3d b = rays[at + stride + 1].cast<double>() * z;
      const Eigen::Vector3d p = rotation * a + other_from_depth.translation_m;
      const Eigen::Vector3d q = rotation * b + other_from_depth.translation_m;
      const double code = std::round(0.5 * (p.z() + q.z()) / unit_m);
      if (!(code >= 1 && code <= 65535)) continue;
      const auto low = to_other.project(p), high = to_other.project(q);
      if (!low || !high) continue;
      Footprint f;
      if (!whole_pixels(low->x(), high->x(), other.width_px, f.left, f.right)) continue;
      if (!whole_pixels(low->y(), high->y(), other.height_px, f.top, f.bottom)) continue;
      f.depth = static_cast<std::uint16_t>(code);
      footprints(x, y) = f;
    }
  });
  // One thread draws: the nearest wins, whatever the order, but two would write one pixel.
  Image<std::uint16_t> result(other.width_px, other.height_px, std::uint16_t{0});
  for (const Footprint& f : footprints) {
    for (int j = f.top; j <= f.bottom; ++j) {
      for (int i = f.left; i <= f.right; ++i) {
        std::uint16_t& out = result(i, j);
        if (out == 0 || f.depth < out) out = f.depth;
      }
    }
  }
  return result;
}

}  // namespace cousin
