#pragma once

#include <cmath>

#include "perception/fruit/fruit_fit.h"
#include "sim/types/rng.h"

namespace cousin {

inline const Camera kFruitCamera{LensModel::pinhole, 200, 160, 390, 390, 99.5, 79.5, {}, {}};
inline constexpr double kFruitWall_m = 0.9;

/// A fruit before a wall, drawn pixel by pixel, with the mask of what is seen of it.
struct DrawnFruit {
  FrameDepth depth;
  DetectedBox box;
};

/// Sets the box from its mask, which is of the whole image.
inline void fit_box(DrawnFruit& drawn) {
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int y = 0; y < drawn.box.mask.height(); ++y) {
    for (int x = 0; x < drawn.box.mask.width(); ++x) {
      if (drawn.box.mask(x, y) == 0) continue;
      low = low.cwiseMin(Eigen::Vector2d(x, y));
      high = high.cwiseMax(Eigen::Vector2d(x, y));
    }
  }
  drawn.box.low_px = low.array() - 0.5;
  drawn.box.high_px = high.array() + 0.5;
}

/// Depth where a ray meets a shape, by steps of its distance; NaN where it passes.
inline double met_depth_m(const FruitShape& shape, const Eigen::Vector3d& ray) {
  double t = (shape.centre_m().norm() - 1.6 * shape.radius_m());
  for (int step = 0; step < 200; ++step) {
    const FruitDistance d = distance_to(shape, t * ray, true);
    if (d.distance_m < 1e-6) return t * ray.z();
    t += 0.7 * d.distance_m;
    if (t > shape.centre_m().norm() + 2 * shape.radius_m()) break;
  }
  return kNaN;
}

/// @param sigma_m  of each depth, its own
inline DrawnFruit draw_fruit(const FruitShape& shape, double sigma_m, Rng rng) {
  DrawnFruit drawn;
  const int w = kFruitCamera.width_px, h = kFruitCamera.height_px;
  drawn.depth.depth_m = Image<float>(w, h, static_cast<float>(kFruitWall_m));
  drawn.depth.sigma_m = Image<float>(w, h, 0.0008F);
  drawn.box.mask = Image<std::uint8_t>(w, h);
  drawn.box.image_px = {w, h};
  const Lens lens(kFruitCamera);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const double z_m = met_depth_m(shape, *lens.unproject(Eigen::Vector2d(x, y)));
      if (std::isnan(z_m)) continue;
      drawn.depth.depth_m(x, y) = static_cast<float>(z_m + sigma_m * normal(rng));
      drawn.box.mask(x, y) = 255;
    }
  }
  fit_box(drawn);
  return drawn;
}

/// Something at a depth before the columns from `from` on: it hides the fruit there.
inline void hide_from_column(DrawnFruit& drawn, int from, double depth_m) {
  for (int y = 0; y < drawn.box.mask.height(); ++y) {
    for (int x = from; x < std::min(from + 60, drawn.box.mask.width()); ++x) {
      drawn.depth.depth_m(x, y) = static_cast<float>(depth_m);
      drawn.box.mask(x, y) = 0;
    }
  }
  fit_box(drawn);
}

/// The mean apple at half a metre, its axis up in the image and leaning by so much to the camera.
inline FruitShape apple_at_half_a_metre(double lean_rad) {
  FruitShape shape = mean_shape(FruitPrior{});
  const Eigen::Vector3d axis(0, -std::cos(lean_rad), -std::sin(lean_rad));
  shape.camera_from_fruit =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
  shape.numbers.head<3>() = Eigen::Vector3d(0.005, -0.004, 0.5);
  return shape;
}

/// A shape of the prior: sizes, cone, sides and dents are drawn.
inline FruitShape drawn_apple(const FruitPrior& prior, Rng rng) {
  FruitShape shape = apple_at_half_a_metre(0.9 * uniform(rng, -1, 1));
  const FruitParameters sigmas = prior_sigmas(prior);
  FruitParameters by = FruitParameters::Zero();
  for (int k = kLogRadius; k < kFruitNumbers; ++k) by[k] = sigmas[k] * normal(rng);
  return changed(shape, by);
}

}  // namespace cousin
