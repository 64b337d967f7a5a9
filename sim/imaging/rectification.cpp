#include "sim/imaging/rectification.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "sim/imaging/color.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

[[noreturn]] void reject(const std::string& what) {
  throw std::invalid_argument("rectification: " + what);
}

Image<Eigen::Vector2f> make_map(const Camera& rectified, const Camera& camera,
                                const Eigen::Matrix3d& rectified_from_lens) {
  const Eigen::Matrix3d lens_from_rectified = rectified_from_lens.transpose();
  const Lens lens(camera);
  Image<Eigen::Vector2f> map(rectified.width_px, rectified.height_px);
  tbb::parallel_for(0, rectified.height_px, [&](int y) {
    for (int x = 0; x < rectified.width_px; ++x) {
      const Eigen::Vector3d ray((x - rectified.cx_px) / rectified.fx_px,
                                (y - rectified.cy_px) / rectified.fy_px, 1);
      const auto pixel = lens.project(lens_from_rectified * ray);
      map(x, y) = pixel ? Eigen::Vector2f(pixel->cast<float>()) : Eigen::Vector2f(kNone, kNone);
    }
  });
  return map;
}

constexpr double kLeastBaseline_m = 1e-6;

}  // namespace

Rectification rectify(const Camera& left, const Camera& right, const Pose& right_from_left,
                      const RectificationConfig& config) {
  validate(left);
  validate(right);
  if (config.width_px < 0 || config.height_px < 0 || !(config.focal_px >= 0))
    reject("width_px, height_px and focal_px must not be negative");
  const Pose left_from_right = inverse(right_from_left);
  const Eigen::Vector3d& baseline_m = left_from_right.translation_m;
  Rectification r;
  r.baseline_m = baseline_m.norm();
  // What two poses of one place leave of it by rounding has a direction too.
  if (!(r.baseline_m >= kLeastBaseline_m)) {
    std::ostringstream text;
    text << "the cameras coincide: they are " << r.baseline_m << " m apart; the limit is "
         << kLeastBaseline_m;
    reject(text.str());
  }
  const Eigen::Vector3d x = baseline_m / r.baseline_m;
  if (!(x.x() > std::sqrt(0.5))) {
    reject("the right camera lies along (" + std::to_string(x.x()) + ", " + std::to_string(x.y()) +
           ", " + std::to_string(x.z()) + ") of the left one, more than 45 degrees off its right");
  }
  const Eigen::Vector3d forward =
      Eigen::Vector3d::UnitZ() + left_from_right.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = forward.cross(x).normalized();
  r.rectified_from_left.row(0) = x;
  r.rectified_from_left.row(1) = y;
  r.rectified_from_left.row(2) = x.cross(y);
  r.rectified_from_right = r.rectified_from_left * left_from_right.rotation.toRotationMatrix();

  r.camera.width_px = config.width_px > 0 ? config.width_px : left.width_px;
  r.camera.height_px = config.height_px > 0 ? config.height_px : left.height_px;
  r.camera.fx_px = r.camera.fy_px =
      config.focal_px > 0 ? config.focal_px
                          : left.fx_px * static_cast<double>(r.camera.width_px) / left.width_px;
  r.camera.cx_px = 0.5 * (r.camera.width_px - 1);
  r.camera.cy_px = 0.5 * (r.camera.height_px - 1);
  validate(r.camera);
  r.left_px = make_map(r.camera, left, r.rectified_from_left);
  r.right_px = make_map(r.camera, right, r.rectified_from_right);
  return r;
}

Remapped remap(const Image<float>& image, const Image<Eigen::Vector2f>& map_px) {
  Remapped out{Image<float>(map_px.width(), map_px.height(), 0.0F),
               Image<std::uint8_t>(map_px.width(), map_px.height(), std::uint8_t{0})};
  const auto last_x = static_cast<float>(image.width() - 1);
  const auto last_y = static_cast<float>(image.height() - 1);
  tbb::parallel_for(tbb::blocked_range<int>(0, map_px.height(), 16), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < map_px.width(); ++x) {
        const Eigen::Vector2f& p = map_px(x, y);
        if (!(p.x() >= 0 && p.y() >= 0 && p.x() <= last_x && p.y() <= last_y)) continue;
        const int i = static_cast<int>(p.x()), j = static_cast<int>(p.y());
        const int right = std::min(i + 1, image.width() - 1);
        const int below = std::min(j + 1, image.height() - 1);
        const float u = p.x() - static_cast<float>(i), v = p.y() - static_cast<float>(j);
        out.image(x, y) = (image(i, j) * (1 - u) + image(right, j) * u) * (1 - v) +
                          (image(i, below) * (1 - u) + image(right, below) * u) * v;
        out.valid(x, y) = 255;
      }
    }
  });
  return out;
}

PassiveDepth passive_depth(const Image<Rgb8>& left, const Image<Rgb8>& right,
                           const Rectification& rectification, const StereoMatchConfig& config) {
  const Remapped a = remap(luma(left), rectification.left_px);
  const Remapped b = remap(luma(right), rectification.right_px);
  PassiveDepth out{Image<float>(a.image.width(), a.image.height(), kNone),
                   match_stereo(a.image, b.image, config)};
  const auto focal_baseline =
      static_cast<float>(rectification.camera.fx_px * rectification.baseline_m);
  tbb::parallel_for(0, out.depth_m.height(), [&](int y) {
    for (int x = 0; x < out.depth_m.width(); ++x) {
      const float d = out.matches.disparity_px(x, y);
      if (!(d > 0) || a.valid(x, y) == 0) continue;
      const int other = static_cast<int>(std::lround(static_cast<float>(x) - d));
      if (other < 0 || b.valid(other, y) == 0) continue;
      out.depth_m(x, y) = focal_baseline / d;
    }
  });
  return out;
}

}  // namespace cousin
