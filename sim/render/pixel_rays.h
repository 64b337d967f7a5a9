#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "sim/render/ray_table.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Directions through any point of a pixel, from the exact ones at the corners of all pixels.
/// Private to sim/render.
class PixelRays {
 public:
  /// @param instants  poses a row, spread evenly over its exposure.
  PixelRays(const TrueView& view, const Eigen::Vector3d& centre_m, int instants = 1)
      : width_(view.camera.width_px),
        instants_(instants),
        rows_(static_cast<std::size_t>(view.camera.height_px) *
              static_cast<std::size_t>(instants)) {
    const auto exact =
        lens_directions(view.camera, -0.5, -0.5, width_ + 1, view.camera.height_px + 1, 1e-4);
    corners_.resize(exact.size());
    std::transform(exact.begin(), exact.end(), corners_.begin(),
                   [](const Eigen::Vector3d& d) -> Eigen::Vector3f { return d.cast<float>(); });
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const int y = static_cast<int>(i) / instants, k = static_cast<int>(i) % instants;
      const Pose camera_from_world =
          instants == 1 ? pose_at_row(view, y) : pose_in_exposure(view, y, (k + 0.5) / instants);
      rows_[i].world_from_camera =
          camera_from_world.rotation.conjugate().toRotationMatrix().cast<float>();
      rows_[i].origin_m = (centre_in_world_m(camera_from_world) - centre_m).cast<float>();
    }
  }

  const Eigen::Vector3f& origin_m(int y) const { return row(y, 0).origin_m; }

  struct Row {
    Eigen::Matrix3f world_from_camera;
    Eigen::Vector3f origin_m;
  };
  const Row& row(int y, int instant) const {
    return rows_[static_cast<std::size_t>(y * instants_ + instant)];
  }

  /// Unit direction in the camera through a point of a pixel, `p` in [0, 1)^2; zero where the lens
  /// gives no ray for one of its corners.
  Eigen::Vector3f in_camera(int x, int y, const Eigen::Vector2f& p) const {
    const std::size_t stride = static_cast<std::size_t>(width_) + 1;
    const Eigen::Vector3f* a =
        corners_.data() + static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x);
    const Eigen::Vector3f* b = a + stride;
    if (a[0].isZero(0) || a[1].isZero(0) || b[0].isZero(0) || b[1].isZero(0))
      return Eigen::Vector3f::Zero();
    const Eigen::Vector3f top = a[0] + p.x() * (a[1] - a[0]);
    const Eigen::Vector3f bottom = b[0] + p.x() * (b[1] - b[0]);
    return (top + p.y() * (bottom - top)).normalized();
  }

  /// Corner directions of a pixel in the world; false where the lens gives no ray for one of them.
  struct Corners {
    Eigen::Vector3f d[4];
    bool valid = true;
    Eigen::Vector3f at(const Eigen::Vector2f& p) const {  ///< p in [0, 1)^2
      const Eigen::Vector3f top = d[0] + p.x() * (d[1] - d[0]);
      const Eigen::Vector3f bottom = d[2] + p.x() * (d[3] - d[2]);
      return (top + p.y() * (bottom - top)).normalized();
    }
  };
  Corners corners(int x, int y) const {
    Corners c;
    const std::size_t stride = static_cast<std::size_t>(width_) + 1;
    const std::size_t first = static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x);
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3f& d = corners_[first + (k & 1U) + (k >> 1U) * stride];
      c.valid = c.valid && !d.isZero(0);
      c.d[k] = row(y, 0).world_from_camera * d;
    }
    return c;
  }

 private:
  int width_;
  int instants_;
  std::vector<Eigen::Vector3f> corners_;
  std::vector<Row> rows_;
};

}  // namespace cousin
