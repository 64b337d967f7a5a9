#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/rng.h"

namespace cousin {

/// A lens of each model with digits that no short decimal has, off the image's middle; all
/// one-to-one inside 640 x 480.
inline std::vector<Camera> odd_lenses() {
  Camera camera{LensModel::pinhole, 640, 480, 500 + 1 / 3.0, 501 + 1 / 7.0, 311 + 1 / 3.0,
                247 - 1 / 7.0,      {},  {}};
  std::vector<Camera> all = {camera};
  camera.model = LensModel::opencv5;
  camera.distortion = {-0.05 / 3, 0.01 / 7, 1e-4 / 3, -1e-4 / 7};
  all.push_back(camera);  // without k3
  camera.distortion[4] = 1e-3 / 3;
  all.push_back(camera);
  camera.model = LensModel::opencv8;
  camera.distortion = {0.35 / 3,  0.12 / 7, -0.002 / 3, 0.001 / 7,
                       0.02 / 11, 0.2 / 3,  0.05 / 7,   0.01 / 13};
  all.push_back(camera);
  camera.model = LensModel::opencv12;
  camera.distortion = {0.30 / 3, 0.10 / 7, 0.001 / 3, 0.002 / 7,  0.02 / 3,  0.45 / 7,
                       0.15 / 3, 0.02 / 7, 0.004 / 3, -0.003 / 7, 0.005 / 3, 0.002 / 7};
  all.push_back(camera);
  camera.model = LensModel::kannala_brandt4;
  camera.distortion = {0.05 / 3, -0.02 / 7, 0.006 / 3, -0.001 / 7};
  all.push_back(camera);
  camera.model = LensModel::splined_stereographic;
  camera.distortion = {};
  camera.spline = {.order = 3,
                   .columns = 10,
                   .rows = 9,
                   .fov_x_rad = 100 * std::numbers::pi / 180,
                   .delta_u = {}};
  for (int i = 0; i < 180; ++i) camera.spline.delta_u.push_back(0.01 * std::sin(0.7 * i) / 3);
  all.push_back(camera);
  return all;
}

inline const Camera& odd_lens(const std::vector<Camera>& lenses, LensModel model) {
  for (const Camera& lens : lenses) {
    if (lens.model == model) return lens;
  }
  throw std::invalid_argument("no such lens");
}

/// Points in front of the camera that the image shows, 0.1 to 10 m away.
inline std::vector<Eigen::Vector3d> points_in_view(const Camera& camera, int count) {
  Rng rng(5);
  std::vector<Eigen::Vector3d> points;
  const Lens lens(camera);
  while (points.size() < static_cast<std::size_t>(count)) {
    const auto ray = lens.unproject(
        {uniform(rng, 0, camera.width_px - 1.0), uniform(rng, 0, camera.height_px - 1.0)});
    if (ray) points.push_back(uniform(rng, 0.1, 10) * *ray);
  }
  return points;
}

/// Largest distance between the pixels of 1e4 points in two cameras; infinity where one has none.
inline double largest_difference_px(const Camera& a, const Camera& b) {
  double largest = 0;
  const Lens first(a), second(b);
  for (const Eigen::Vector3d& point : points_in_view(a, 10000)) {
    const auto p = first.project(point), q = second.project(point);
    if (!p || !q) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, (*p - *q).norm());
  }
  return largest;
}

}  // namespace cousin
