#include "perception/fruit/fruit_clv.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "sim/config/limits.h"
#include "sim/geometry/measure.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// Uniform by area: u in [0, 1], theta = 2 pi u1, phi = acos(1 - 2 u2) [eq. 17 to 20].
Vector3d any_direction(Rng& rng) {
  const double z = uniform(rng, -1, 1), about = uniform(rng, 0, 2 * std::numbers::pi);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(about), r * std::sin(about), z};
}

/// The deformed sphere of radius 1 [eq. 21 to 28], z from calyx to stalk.
std::vector<Vector3d> deformed_sphere(const ClvConfig& c, Rng rng) {
  struct Deformation {
    Vector3d direction;
    double strength, frequency;
  };
  std::vector<Deformation> deformations;
  Rng waves = rng.fork("waves");
  for (int i = 1; i <= c.waves; ++i)
    deformations.push_back({any_direction(waves), c.wave_strength / i, static_cast<double>(i)});
  std::vector<Vector3d> points;
  Rng own = rng.fork("points");
  for (int k = 0; k < c.points; ++k) {
    const Vector3d d = any_direction(own);
    double radius = 1 + c.noise * normal(own);
    for (const Deformation& one : deformations)
      radius += one.strength *
                std::sin(one.frequency * std::acos(std::clamp(d.dot(one.direction), -1.0, 1.0)));
    const double angle = std::acos(std::clamp(d.z(), -1.0, 1.0));
    const auto bell = [&](double a) { return std::exp(-a * a / (c.dent_rad * c.dent_rad)); };
    radius *=
        (1 - c.stalk_dent * bell(angle)) * (1 - c.calyx_dent * bell(std::numbers::pi - angle));
    points.emplace_back(radius * d);
  }
  return points;
}

/// Least over largest eigenvalue of the points' covariance [eq. 31 to 33].
double sphericity(const std::vector<Vector3d>& points) {
  const auto n = static_cast<double>(points.size());
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
  return axes.eigenvalues()[0] / axes.eigenvalues()[2];
}

std::optional<double> middle_depth_m(const FrameDepth& depth, const DetectedBox& box) {
  const Eigen::Vector2d middle = (0.5 * (box.low_px + box.high_px)).array().floor();
  std::vector<double> found;
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      const Eigen::Vector2d at = middle + Eigen::Vector2d(dx, dy);
      if (!(at.minCoeff() >= 0) || at.x() >= depth.depth_m.width() ||
          at.y() >= depth.depth_m.height())
        continue;
      const auto z_m =
          static_cast<double>(depth.depth_m(static_cast<int>(at.x()), static_cast<int>(at.y())));
      if (z_m > 0) found.push_back(z_m);
    }
  }
  if (found.empty()) return std::nullopt;
  const auto half = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
  std::nth_element(found.begin(), half, found.end());
  return *half;
}

}  // namespace

Fields fields(ClvConfig& c) {
  return {{"points", &c.points, "of the deformed sphere", 50, 1000000},
          {"waves", &c.waves, "directions of deformation", 0, 100},
          {"wave_strength", &c.wave_strength, "of the slowest, over the radius", 0, 0.5},
          {"noise", &c.noise, "sigma of the random radius, over it", 0, 0.5},
          {"stalk_dent", &c.stalk_dent, "depth over the radius", 0, 0.9},
          {"calyx_dent", &c.calyx_dent, "depth over the radius", 0, 0.9},
          {"dent_rad", &c.dent_rad, "where both are e times shallower", 0.05, 2},
          {"correction", &c.correction, "share of the hull lost per lack of sphericity", -10, 10},
          {"density_kg_m3", &c.density_kg_m3, "mass over volume", 100, 3000}};
}

void validate(const ClvConfig& config) {
  ClvConfig copy = config;
  check_limits(fields(copy), "clv");
}

FruitFit fit_clv(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                 const ClvConfig& config, Rng rng) {
  FruitFit fit;
  fit.status = FitStatus::too_few_points;
  if (depth.depth_m.empty()) {
    fit.reason = "the frame has no depth";
    return fit;
  }
  const std::optional<double> front_m = middle_depth_m(depth, box);
  if (!front_m) {
    fit.reason = "no depth in the middle of its box";
    return fit;
  }
  // Half of the mean side over the focal length. The rim stands one radius behind the front, so
  // radius = share (front + radius) [eq. 10 to 16].
  const double share = 0.25 * (box.high_px - box.low_px).sum() / camera.fx_px;
  constexpr double kMostShare = 0.5;  // a sphere that fills 53 degrees of the view
  if (!(share > 0) || share > kMostShare) {
    fit.reason =
        "its box is no fruit's: half of it spans " + std::to_string(share) + " of the distance";
    return fit;
  }
  const double radius_m = share * *front_m / (1 - share);
  std::vector<Vector3d> points = deformed_sphere(config, rng);
  const double ratio = sphericity(points);
  for (Vector3d& p : points) p *= radius_m;
  const double hull_m3 = mass_properties(convex_hull(points)).volume_m3;
  fit.status = FitStatus::ok;
  const Eigen::Vector2d middle = 0.5 * (box.low_px + box.high_px);
  fit.shape.numbers.head<3>() =
      (*front_m + radius_m) * Vector3d((middle.x() - camera.cx_px) / camera.fx_px,
                                       (middle.y() - camera.cy_px) / camera.fy_px, 1);
  fit.shape.numbers[kLogRadius] = std::log(radius_m);
  fit.volume_m3.value = hull_m3 * (1 - config.correction * (1 - ratio));
  fit.diameter_m.value = fit.length_m.value = 2 * radius_m;
  fit.mass_kg.value = config.density_kg_m3 * fit.volume_m3.value;
  return fit;
}

}  // namespace cousin
