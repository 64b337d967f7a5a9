#include "perception/fruit/fruit_comparators.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/geometry/measure.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

FruitFit failed(const std::string& reason) {
  FruitFit fit;
  fit.status = FitStatus::degenerate;
  fit.reason = reason;
  return fit;
}

FruitFit sized(const Vector3d& centre_m, double diameter_m, double length_m, double volume_m3,
               const FruitPrior& prior) {
  FruitFit fit;
  fit.status = FitStatus::ok;
  fit.shape.numbers.head<3>() = centre_m;
  fit.shape.numbers[kLogRadius] = std::log(diameter_m / 2);
  fit.shape.numbers[kLogStretch] = std::log(length_m / diameter_m);
  fit.diameter_m.value = diameter_m;
  fit.length_m.value = length_m;
  fit.volume_m3.value = volume_m3;
  fit.mass_kg.value = prior.density_kg_m3 * volume_m3;
  return fit;
}

/// Points about their mean, over their spread: numbers near one.
struct Scaled {
  Vector3d mean_m = Vector3d::Zero();
  double scale_m = 1;
  std::vector<Vector3d> points;
};
Scaled scaled(const FruitSurface& surface) {
  Scaled s;
  const auto n = static_cast<double>(surface.points.size());
  for (const SeenPoint& p : surface.points) s.mean_m += p.point_m / n;
  double square = 0;
  for (const SeenPoint& p : surface.points) square += (p.point_m - s.mean_m).squaredNorm() / n;
  s.scale_m = std::max(1e-9, std::sqrt(square));
  for (const SeenPoint& p : surface.points)
    s.points.emplace_back((p.point_m - s.mean_m) / s.scale_m);
  return s;
}

/// Least squares of the points' distances from a sphere, from a first centre and radius.
Eigen::Vector4d nearest_ball(const std::vector<Vector3d>& points, Eigen::Vector4d ball) {
  constexpr int kSteps = 15;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix4d normal = 1e-9 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const Vector3d& p : points) {
      const Vector3d from = p - ball.head<3>();
      const double norm = std::max(1e-9, from.norm());
      Eigen::Vector4d slope;
      slope << from / norm, 1;
      normal += slope * slope.transpose();
      right += (norm - ball[3]) * slope;
    }
    ball += normal.ldlt().solve(right);
  }
  return ball;
}

/// Circle by three places of a plane; radius NaN where they lie in a line.
struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = kNaN;
};
Circle circle_through(const std::vector<Eigen::Vector2d>& places) {
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd terms(n, 3);
  Eigen::VectorXd squares(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d& p = places[static_cast<std::size_t>(i)];
    terms.row(i) << 2 * p.x(), 2 * p.y(), 1;
    squares[i] = p.squaredNorm();
  }
  const Eigen::Matrix3d normal = terms.transpose() * terms;
  if (std::abs(normal.determinant()) < 1e-18 * std::pow(normal.trace(), 3)) return {};
  const Vector3d found = normal.ldlt().solve(terms.transpose() * squares);
  Circle circle;
  circle.centre = found.head<2>();
  circle.radius = std::sqrt(found.z() + circle.centre.squaredNorm());
  return circle;
}

/// The circle of three places that most others are near to, refined on those.
Circle agreed_circle(const std::vector<Eigen::Vector2d>& places, double near) {
  std::vector<Eigen::Vector2d> best;
  const std::size_t n = places.size();
  const std::size_t step = std::max<std::size_t>(1, n / 12);
  for (std::size_t a = 0; a < n; a += step) {
    for (std::size_t b = a + step; b < n; b += step) {
      for (std::size_t c = b + step; c < n; c += step) {
        const Circle circle = circle_through({places[a], places[b], places[c]});
        if (!std::isfinite(circle.radius)) continue;
        std::vector<Eigen::Vector2d> agree;
        for (const Eigen::Vector2d& p : places) {
          if (std::abs((p - circle.centre).norm() - circle.radius) < near * circle.radius)
            agree.push_back(p);
        }
        if (agree.size() > best.size()) best = std::move(agree);
      }
    }
  }
  return best.size() < 3 ? Circle{} : circle_through(best);
}

}  // namespace

FruitFit fit_sphere(const FruitSurface& surface, const FruitPrior& prior) {
  if (!surface.why_none.empty()) return failed(surface.why_none);
  const Scaled s = scaled(surface);
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const Vector3d& p : s.points) {
    const Eigen::Vector4d term(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
    normal += term * term.transpose();
    right += p.squaredNorm() * term;
  }
  const Eigen::Vector4d found = normal.ldlt().solve(right);
  const Eigen::Vector4d ball = nearest_ball(
      s.points,
      {found[0], found[1], found[2], std::sqrt(found[3] + found.head<3>().squaredNorm())});
  const double radius_m = s.scale_m * ball[3];
  if (!(radius_m > 0) || radius_m > 1) return failed("its depths are of no sphere");
  return sized(s.mean_m + s.scale_m * ball.head<3>(), 2 * radius_m, 2 * radius_m,
               4 * std::numbers::pi / 3 * std::pow(radius_m, 3), prior);
}

FruitFit fit_ellipsoid(const FruitSurface& surface, const FruitPrior& prior) {
  if (!surface.why_none.empty()) return failed(surface.why_none);
  const Scaled s = scaled(surface);
  using Vector9d = Eigen::Matrix<double, 9, 1>;
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  Vector9d right = Vector9d::Zero();
  for (const Vector3d& p : s.points) {
    Vector9d term;
    term << p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), 2 * p.x() * p.y(), 2 * p.x() * p.z(),
        2 * p.y() * p.z(), 2 * p.x(), 2 * p.y(), 2 * p.z();
    normal += term * term.transpose();
    right += term;
  }
  const Vector9d q = normal.ldlt().solve(right);
  Eigen::Matrix3d form;
  form << q[0], q[3], q[4], q[3], q[1], q[5], q[4], q[5], q[2];
  const Vector3d centre = -form.fullPivLu().solve(q.tail<3>());
  const double level = 1 + centre.dot(form * centre);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(form / level);
  if (!(axes.eigenvalues().minCoeff() > 0)) return failed("its depths are of no ellipsoid");
  const Vector3d half_m = s.scale_m * axes.eigenvalues().cwiseSqrt().cwiseInverse();  // falling
  if (half_m.maxCoeff() > 1) return failed("its depths are of no ellipsoid");
  return sized(s.mean_m + s.scale_m * centre, half_m[0] + half_m[1], 2 * half_m[2],
               4 * std::numbers::pi / 3 * half_m.prod(), prior);
}

FruitFit fit_hull(const FruitSurface& surface, const FruitPrior& prior) {
  if (!surface.why_none.empty()) return failed(surface.why_none);
  Vector3d way = Vector3d::Zero();
  for (const SeenPoint& p : surface.points) way += p.point_m.normalized();
  way.normalize();
  // The farthest 5 % may belong to a surface behind the fruit.
  std::vector<double> along_m;
  for (const SeenPoint& p : surface.points) along_m.push_back(p.point_m.dot(way));
  const auto most = along_m.begin() + static_cast<std::ptrdiff_t>(0.95 * along_m.size());
  std::nth_element(along_m.begin(), most, along_m.end());
  const double farthest_m = *most;
  std::vector<Vector3d> points_m;
  Vector3d low = Vector3d::Constant(1e9), high = -low;
  for (const SeenPoint& p : surface.points) {
    if (p.point_m.dot(way) > farthest_m) continue;
    points_m.push_back(p.point_m);
    points_m.emplace_back(p.point_m + 2 * (farthest_m - p.point_m.dot(way)) * way);
    low = low.cwiseMin(p.point_m), high = high.cwiseMax(p.point_m);
  }
  const Mesh hull = convex_hull(points_m);
  if (hull.triangles.empty()) return failed("its depths are flat");
  const Vector3d extent_m = high - low;
  return sized(0.5 * (low + high), std::max(extent_m.x(), extent_m.y()),
               std::min(extent_m.x(), extent_m.y()), mass_properties(hull).volume_m3, prior);
}

FruitFit fit_allometry(const FruitSurface& surface, const FruitPrior& prior) {
  if (!surface.why_none.empty()) return failed(surface.why_none);
  std::vector<Eigen::Vector2d> places;
  for (const OutlinePlace& place : surface.outline) {
    if (place.beyond != Beyond::nearer)
      places.emplace_back(place.ray.x() / place.ray.z(), place.ray.y() / place.ray.z());
  }
  if (places.size() < 6) return failed("too little of its outline is its own");
  constexpr double kNear = 0.07;  // over the radius: half of what an apple is flatter
  const Circle circle = agreed_circle(places, kNear);
  if (!std::isfinite(circle.radius)) return failed("its outline is of no circle");
  // Its rim stands about a radius behind its front, of which the median depth is a third away.
  const double radius_m = circle.radius * surface.depth_m / (1 - 0.65 * circle.radius);
  if (!(radius_m > 0) || radius_m > 1) return failed("its outline is of no circle");
  const FruitNumbers mean = numbers_of(mean_shape(prior));
  const double ratio = 2 * radius_m / mean.diameter_m.value;
  const Vector3d centre_m =
      (surface.depth_m + 0.65 * radius_m) * Vector3d(circle.centre.x(), circle.centre.y(), 1);
  return sized(centre_m, 2 * radius_m, mean.length_m.value * ratio,
               mean.volume_m3.value * std::pow(ratio, 3), prior);
}

FruitFit fit_box(const DetectedBox& box, const Camera& camera, const Vector3d& surface_m,
                 const std::string& why_none, BoxBody body, const FruitPrior& prior) {
  if (!why_none.empty()) return failed(why_none);
  const Eigen::Vector2d size_px = box.high_px - box.low_px;
  const double width_m = size_px.x() / camera.fx_px * surface_m.z(),
               height_m = size_px.y() / camera.fy_px * surface_m.z();
  if (!(width_m > 0) || !(height_m > 0) || !std::isfinite(width_m * height_m))
    return failed("its box has no size");
  // Seen from before, its sides are half a width farther than its front.
  const double grown = 1 + 0.5 * width_m / surface_m.z();
  const double diameter_m = grown * width_m, length_m = grown * height_m;
  const double cylinder_m3 = std::numbers::pi / 4 * diameter_m * diameter_m * length_m;
  const double share = body == BoxBody::cone ? (1 + kConeTip + kConeTip * kConeTip) / 3 : 2.0 / 3;
  FruitFit fit = sized(surface_m + 0.5 * diameter_m * surface_m.normalized(), diameter_m, length_m,
                       share * cylinder_m3, prior);
  fit.shape.camera_from_fruit =
      Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), -Vector3d::UnitY()).toRotationMatrix();
  return fit;
}

}  // namespace cousin
