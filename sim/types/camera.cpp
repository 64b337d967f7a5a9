#include "sim/types/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct ModelName {
  LensModel model;
  std::string_view name;
  int count;
};
constexpr std::array<ModelName, 6> kModels = {
    {{LensModel::pinhole, "pinhole", 0},
     {LensModel::opencv5, "opencv5", 5},
     {LensModel::opencv8, "opencv8", 8},
     {LensModel::opencv12, "opencv12", 12},
     {LensModel::kannala_brandt4, "kannala_brandt4", 4},
     {LensModel::splined_stereographic, "splined_stereographic", 0}}};

const ModelName& entry(LensModel model) { return kModels.at(static_cast<std::size_t>(model)); }

struct Distorted {
  Eigen::Vector2d point;         ///< on the plane z = 1, before the focal length
  Eigen::Matrix2d d_normalized;  ///< of point, with respect to the undistorted (x, y)
};

/// Numerator and denominator of the radial factor as polynomials in r^2, with derivatives.
struct Radial {
  double numerator, denominator, d_numerator, d_denominator;
};

Radial radial_factor(const std::array<double, 12>& k, double r2) {
  Radial f;
  f.numerator = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  f.denominator = 1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7]));
  f.d_numerator = k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]);
  f.d_denominator = k[5] + r2 * (2 * k[6] + r2 * 3 * k[7]);
  return f;
}

Distorted distort(const Camera& camera, double x, double y) {
  const auto& k = camera.distortion;
  const double r2 = x * x + y * y;
  const Radial f = radial_factor(k, r2);
  const double g = f.numerator / f.denominator;
  const double dg = (f.d_numerator - g * f.d_denominator) / f.denominator;  // d g / d r2
  const double p1 = k[2], p2 = k[3];
  const double sx = k[8] + r2 * k[9], sy = k[10] + r2 * k[11];
  const double dsx = k[8] + 2 * r2 * k[9], dsy = k[10] + 2 * r2 * k[11];  // d(r2 s)/d r2
  Distorted d;
  d.point.x() = x * g + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + r2 * sx;
  d.point.y() = y * g + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + r2 * sy;
  d.d_normalized(0, 0) = g + 2 * x * x * dg + 2 * p1 * y + 6 * p2 * x + 2 * x * dsx;
  d.d_normalized(0, 1) = 2 * x * y * dg + 2 * p1 * x + 2 * p2 * y + 2 * y * dsx;
  d.d_normalized(1, 0) = 2 * x * y * dg + 2 * p1 * x + 2 * p2 * y + 2 * x * dsy;
  d.d_normalized(1, 1) = g + 2 * y * y * dg + 6 * p1 * y + 2 * p2 * x + 2 * y * dsy;
  return d;
}

double kb_radius(const std::array<double, 12>& k, double theta) {
  const double t2 = theta * theta;
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

double kb_slope(const std::array<double, 12>& k, double theta) {
  const double t2 = theta * theta;
  return 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
}

double radial_slope(const std::array<double, 12>& k, double r) {
  const double r2 = r * r;
  const Radial f = radial_factor(k, r2);
  if (f.denominator <= 0) return -1;
  const double g = f.numerator / f.denominator;
  return g + 2 * r2 * (f.d_numerator - g * f.d_denominator) / f.denominator;
}

/// First argument in (0, end] where `slope` stops being positive, or `end` if nowhere.
template <class Slope>
double first_fold(const Slope& slope, double end) {
  constexpr int kSteps = 512;
  double previous = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double x = end * i / kSteps;
    if (slope(x) > 0) {
      previous = x;
      continue;
    }
    double low = previous, high = x;
    for (int j = 0; j < 60; ++j) {
      const double middle = 0.5 * (low + high);
      (slope(middle) > 0 ? low : high) = middle;
    }
    return low;
  }
  return end;
}

/// Undistorted (x, y) of a distorted point; nothing if no root below `limit` is found.
std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& target,
                                         double limit) {
  // Radial start inside the bracket [0, limit], where the radial map increases: bisection, few
  // steps.
  const double wanted = target.norm();
  if (wanted == 0 && camera.distortion[8] == 0 && camera.distortion[10] == 0) {
    return Eigen::Vector2d::Zero();
  }
  const auto radius = [&](double r) {
    const Radial f = radial_factor(camera.distortion, r * r);
    return r * f.numerator / f.denominator;
  };
  double low = 0;
  double high = std::min(limit, std::max(1.0, 2 * wanted));
  while (high < limit && high < 1e6 && radius(high) < wanted) high = std::min(limit, 2 * high);
  if (!std::isfinite(high)) return std::nullopt;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (radius(middle) < wanted ? low : high) = middle;
  }
  Eigen::Vector2d xy = wanted > 0 ? Eigen::Vector2d(target * (0.5 * (low + high) / wanted))
                                  : Eigen::Vector2d::Zero();
  Distorted d = distort(camera, xy.x(), xy.y());
  double error = (d.point - target).norm();
  for (int i = 0; i < 50 && error > 1e-15; ++i) {
    const double determinant = d.d_normalized.determinant();
    if (!(std::abs(determinant) > 1e-12)) break;
    const Eigen::Vector2d step = d.d_normalized.inverse() * (target - d.point);
    bool improved = false;
    for (double scale = 1; scale > 1e-4;
         scale *= 0.5) {  // halve until it gets better, inside the limit
      const Eigen::Vector2d candidate = xy + scale * step;
      if (candidate.norm() > limit) continue;
      const Distorted next = distort(camera, candidate.x(), candidate.y());
      const double next_error = (next.point - target).norm();
      if (next_error < error) {
        xy = candidate;
        d = next;
        error = next_error;
        improved = true;
        break;
      }
    }
    if (!improved) break;
  }
  if (!(error < 1e-9) || xy.norm() > limit) return std::nullopt;
  return xy;
}

std::optional<Eigen::Vector3d> unproject_within(const Camera& camera,
                                                const Eigen::Vector2d& pixel_px, double limit) {
  const Eigen::Vector2d m((pixel_px.x() - camera.cx_px) / camera.fx_px,
                          (pixel_px.y() - camera.cy_px) / camera.fy_px);
  if (!m.allFinite()) return std::nullopt;
  if (camera.model == LensModel::pinhole) return Eigen::Vector3d(m.x(), m.y(), 1).normalized();
  if (camera.model == LensModel::splined_stereographic) {
    const std::optional<Eigen::Vector2d> u = unbent(camera.spline, m);
    if (!u) return std::nullopt;
    return direction_of_stereographic(*u);
  }
  if (camera.model == LensModel::kannala_brandt4) {
    const double radius = m.norm();
    if (radius == 0) return Eigen::Vector3d::UnitZ();
    if (radius > kb_radius(camera.distortion, limit)) return std::nullopt;
    double low = 0, high = limit, theta = std::min(radius, limit);
    for (int i = 0; i < 100; ++i) {  // Newton; a step that leaves the bracket becomes a bisection
      const double error = kb_radius(camera.distortion, theta) - radius;
      if (std::abs(error) < 1e-15) break;
      (error < 0 ? low : high) = theta;
      const double next = theta - error / kb_slope(camera.distortion, theta);
      theta = next > low && next < high ? next : 0.5 * (low + high);
    }
    if (std::abs(kb_radius(camera.distortion, theta) - radius) > 1e-9) return std::nullopt;
    const Eigen::Vector2d direction = m / radius;
    return Eigen::Vector3d(direction.x() * std::sin(theta), direction.y() * std::sin(theta),
                           std::cos(theta));
  }
  const std::optional<Eigen::Vector2d> xy = undistort(camera, m, limit);
  if (!xy) return std::nullopt;
  return Eigen::Vector3d(xy->x(), xy->y(), 1).normalized();
}

/// `limit` gives the camera's monotone_limit, and is only asked where it matters.
template <class Limit>
std::optional<Projection> projection(const Camera& camera, const Eigen::Vector3d& point,
                                     const Limit& limit) {
  if (!point.allFinite()) return std::nullopt;
  Projection result;
  const Eigen::Vector2d f(camera.fx_px, camera.fy_px);
  const Eigen::Vector2d c(camera.cx_px, camera.cy_px);
  if (camera.model == LensModel::kannala_brandt4) {
    const double r = point.head<2>().norm();
    const double norm2 = point.squaredNorm();
    if (norm2 == 0) return std::nullopt;
    const double theta = std::atan2(r, point.z());
    if (theta > limit()) return std::nullopt;
    if (r < 1e-12 * std::sqrt(norm2)) {
      if (point.z() <= 0) return std::nullopt;
      result.pixel_px = c + f.cwiseProduct(point.head<2>() / point.z());
      result.d_point << f.x() / point.z(), 0, 0, 0, f.y() / point.z(), 0;
      return result;
    }
    const double radius = kb_radius(camera.distortion, theta);
    const Eigen::Vector2d u = point.head<2>() / r;
    result.pixel_px = c + f.cwiseProduct(radius * u);
    Eigen::Vector3d d_theta;
    d_theta << point.z() * u / norm2, -r / norm2;
    Eigen::Matrix<double, 2, 3> d_u = Eigen::Matrix<double, 2, 3>::Zero();
    d_u.leftCols<2>() = (Eigen::Matrix2d::Identity() - u * u.transpose()) / r;
    result.d_point =
        f.asDiagonal() *
        (u * (kb_slope(camera.distortion, theta) * d_theta.transpose()) + radius * d_u);
    return result;
  }
  if (camera.model == LensModel::splined_stereographic) {
    const std::optional<StereographicPoint> u = stereographic(point);
    const std::optional<SplinePoint> at = u ? bent(camera.spline, u->u) : std::nullopt;
    if (!at) return std::nullopt;
    result.pixel_px = c + f.cwiseProduct(at->value);
    result.d_point = f.asDiagonal() * (at->d_u * u->d_point);
    return result;
  }
  if (!(point.z() > 0)) return std::nullopt;
  const double x = point.x() / point.z();
  const double y = point.y() / point.z();
  Eigen::Matrix<double, 2, 3> d_normalized;
  d_normalized << 1 / point.z(), 0, -x / point.z(), 0, 1 / point.z(), -y / point.z();
  if (camera.model == LensModel::pinhole) {
    result.pixel_px = c + f.cwiseProduct(Eigen::Vector2d(x, y));
    result.d_point = f.asDiagonal() * d_normalized;
    return result;
  }
  // Cheap test first: the exact fold is only looked up where the slope is not plainly positive.
  const double r = std::hypot(x, y);
  if (radial_slope(camera.distortion, r) <= 0 || (r > 0.5 && r > limit())) {
    return std::nullopt;
  }
  const Distorted d = distort(camera, x, y);
  result.pixel_px = c + f.cwiseProduct(d.point);
  result.d_point = f.asDiagonal() * (d.d_normalized * d_normalized);
  return result;
}

std::optional<Eigen::Vector2d> pixel_of(const std::optional<Projection>& projection) {
  if (!projection) return std::nullopt;
  return projection->pixel_px;
}

}  // namespace

std::string_view to_string(LensModel model) { return entry(model).name; }

LensModel lens_model_from_string(std::string_view text) {
  std::string names;
  for (const ModelName& model : kModels) {
    if (model.name == text) return model.model;
    names += (names.empty() ? "" : ", ") + std::string(model.name);
  }
  throw std::invalid_argument("lens model \"" + std::string(text) + "\" is not one of " + names);
}

int distortion_count(LensModel model) { return entry(model).count; }

double monotone_limit(const Camera& camera) {
  const auto& k = camera.distortion;
  if (camera.model == LensModel::pinhole) return kInfinity;
  if (camera.model == LensModel::splined_stereographic) return kInfinity;
  if (camera.model == LensModel::kannala_brandt4) {
    return first_fold([&](double t) { return kb_slope(k, t); }, std::numbers::pi);
  }
  // Beyond a tangent of 20 (87 degrees off axis) no perspective image reaches.
  constexpr double kFarthest = 20;
  const double fine = first_fold([&](double r) { return radial_slope(k, r); }, 2.0);
  if (fine < 2.0) return fine;
  const double limit = first_fold([&](double r) { return radial_slope(k, r); }, kFarthest);
  return limit < kFarthest ? limit : kInfinity;
}

std::optional<Projection> project_with_jacobian(const Camera& camera,
                                                const Eigen::Vector3d& point) {
  return projection(camera, point, [&] { return monotone_limit(camera); });
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& point) {
  return pixel_of(project_with_jacobian(camera, point));
}

std::optional<Eigen::Vector3d> unproject(const Camera& camera, const Eigen::Vector2d& pixel_px) {
  return unproject_within(camera, pixel_px, monotone_limit(camera));
}

Lens::Lens(const Camera& camera) : camera_(camera), limit_(cousin::monotone_limit(camera)) {}

std::optional<Projection> Lens::project_with_jacobian(const Eigen::Vector3d& point) const {
  return projection(camera_, point, [this] { return limit_; });
}

std::optional<Eigen::Vector2d> Lens::project(const Eigen::Vector3d& point) const {
  return pixel_of(project_with_jacobian(point));
}

std::optional<Eigen::Vector3d> Lens::unproject(const Eigen::Vector2d& pixel_px) const {
  return unproject_within(camera_, pixel_px, limit_);
}

Camera resized(const Camera& camera, int width_px, int height_px) {
  Camera result = camera;
  const double sx = static_cast<double>(width_px) / camera.width_px;
  const double sy = static_cast<double>(height_px) / camera.height_px;
  result.width_px = width_px;
  result.height_px = height_px;
  result.fx_px *= sx;
  result.fy_px *= sy;
  result.cx_px = (camera.cx_px + 0.5) * sx - 0.5;
  result.cy_px = (camera.cy_px + 0.5) * sy - 0.5;
  return result;
}

}  // namespace cousin
