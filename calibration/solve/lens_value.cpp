#include "calibration/solve/lens_value.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace cousin {
namespace {

constexpr int kCore = 4;

/// A point behind the distortion, before the focal lengths. The functions below also write its
/// derivatives by the coefficients to `d`, unless that is null.
struct Bent {
  Eigen::Vector2d point;
  Eigen::Matrix<double, 2, 3> d_point;
};

/// OpenCV's models: radial polynomial or ratio, tangential, thin prism.
bool bend_perspective(int coefficients, const double* parameters, const Eigen::Vector3d& p,
                      Bent& bent, double* d) {
  if (!(p.z() > 0)) return false;
  std::array<double, 12> k{};
  std::copy_n(parameters + kCore, coefficients, k.begin());
  const double inverse_z = 1 / p.z();
  const double x = p.x() * inverse_z, y = p.y() * inverse_z;
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
  const double above = 1 + k[0] * r2 + k[1] * r4 + k[4] * r6;
  const double below = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
  if (!(below > 0)) return false;
  const double g = above / below;
  const double d_above = k[0] + 2 * k[1] * r2 + 3 * k[4] * r4;
  const double d_below = k[5] + 2 * k[6] * r2 + 3 * k[7] * r4;
  const double dg = (d_above - g * d_below) / below;
  const double p1 = k[2], p2 = k[3];
  const double dsx = k[8] + 2 * r2 * k[9], dsy = k[10] + 2 * r2 * k[11];
  bent.point.x() = x * g + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + r2 * k[8] + r4 * k[9];
  bent.point.y() = y * g + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + r2 * k[10] + r4 * k[11];
  const double xx = g + 2 * x * x * dg + 2 * p1 * y + 6 * p2 * x + 2 * x * dsx;
  const double xy = 2 * x * y * dg + 2 * p1 * x + 2 * p2 * y + 2 * y * dsx;
  const double yx = 2 * x * y * dg + 2 * p1 * x + 2 * p2 * y + 2 * x * dsy;
  const double yy = g + 2 * y * y * dg + 6 * p1 * y + 2 * p2 * x + 2 * y * dsy;
  bent.d_point << xx, xy, -(xx * x + xy * y), yx, yy, -(yx * x + yy * y);
  bent.d_point *= inverse_z;
  if (d == nullptr || coefficients == 0) return true;
  const int count = kCore + coefficients;
  double* dx = d + kCore;
  double* dy = d + count + kCore;
  const double u = x / below, v = y / below;
  dx[0] = r2 * u, dy[0] = r2 * v;
  dx[1] = r4 * u, dy[1] = r4 * v;
  dx[2] = 2 * x * y, dy[2] = r2 + 2 * y * y;
  dx[3] = r2 + 2 * x * x, dy[3] = 2 * x * y;
  dx[4] = r6 * u, dy[4] = r6 * v;
  if (coefficients >= 8) {
    dx[5] = -g * r2 * u, dy[5] = -g * r2 * v;
    dx[6] = -g * r4 * u, dy[6] = -g * r4 * v;
    dx[7] = -g * r6 * u, dy[7] = -g * r6 * v;
  }
  if (coefficients >= 12) {
    dx[8] = r2, dx[9] = r4;
    dy[10] = r2, dy[11] = r4;
  }
  return true;
}

/// [Kannala & Brandt, TPAMI 2006], four coefficients.
bool bend_kannala_brandt(const double* parameters, const Eigen::Vector3d& p, Bent& bent,
                         double* d) {
  const double* k = parameters + kCore;
  const double r2 = p.head<2>().squaredNorm(), r = std::sqrt(r2);
  const double norm2 = p.squaredNorm();
  if (!(norm2 > 0)) return false;
  if (r2 < 1e-24 * norm2) {
    if (p.z() <= 0) return false;
    bent.point = p.head<2>() / p.z();
    bent.d_point << 1 / p.z(), 0, 0, 0, 1 / p.z(), 0;
    return true;
  }
  const double theta = std::atan2(r, p.z()), t2 = theta * theta;
  const double radius = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  const double slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
  const Eigen::Vector2d u = p.head<2>() / r;
  bent.point = radius * u;
  const Eigen::Vector3d d_theta(p.z() * u.x() / norm2, p.z() * u.y() / norm2, -r / norm2);
  bent.d_point = slope * u * d_theta.transpose();
  bent.d_point.leftCols<2>() += radius / r * (Eigen::Matrix2d::Identity() - u * u.transpose());
  if (d == nullptr) return true;
  double power = theta * t2;
  for (int i = 0; i < 4; ++i, power *= t2) {
    d[kCore + i] = power * u.x();
    d[2 * kCore + 4 + i] = power * u.y();
  }
  return true;
}

/// Weights of a uniform B-spline's control points about a position in control points, and their
/// derivatives; the outermost piece goes on beyond its end [sim/types/spline_lens.h].
struct Weights {
  int first = 0;
  std::array<double, 4> value{}, slope{};
};
Weights weights(int order, double at, int knots) {
  Weights w;
  if (order == 2) {
    const int middle = std::clamp(static_cast<int>(std::floor(at + 0.5)), 1, knots - 2);
    const double t = at - middle;
    w.first = middle - 1;
    w.value = {0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t), 0};
    w.slope = {t - 0.5, -2 * t, t + 0.5, 0};
    return w;
  }
  const int left = std::clamp(static_cast<int>(std::floor(at)), 1, knots - 3);
  const double t = at - left, s = 1 - t;
  w.first = left - 1;
  w.value = {s * s * s / 6, (t * t * (3 * t - 6) + 4) / 6, (t * (3 + t * (3 - 3 * t)) + 1) / 6,
             t * t * t / 6};
  w.slope = {-0.5 * s * s, t * (1.5 * t - 2), 0.5 + t * (1 - 1.5 * t), 0.5 * t * t};
  return w;
}

bool bend_splined(const SplineLens& grid, const double* parameters, const Eigen::Vector3d& p,
                  Bent& bent, double* d) {
  const std::optional<StereographicPoint> u = stereographic(p);
  if (!u) return false;
  const int margin = grid.order == 2 ? 1 : 2;
  const double scale = (grid.columns - 1 - margin) / (4 * std::tan(grid.fov_x_rad / 4));
  const Weights x = weights(grid.order, u->u.x() * scale + 0.5 * (grid.columns - 1), grid.columns);
  const Weights y = weights(grid.order, u->u.y() * scale + 0.5 * (grid.rows - 1), grid.rows);
  const int count = kCore + 2 * grid.columns * grid.rows;
  Eigen::Vector2d delta = Eigen::Vector2d::Zero();
  Eigen::Matrix2d slope = Eigen::Matrix2d::Zero();
  for (std::size_t j = 0; j <= static_cast<std::size_t>(grid.order); ++j) {
    for (std::size_t i = 0; i <= static_cast<std::size_t>(grid.order); ++i) {
      const int knot =
          (y.first + static_cast<int>(j)) * grid.columns + x.first + static_cast<int>(i);
      const Eigen::Map<const Eigen::Vector2d> control(parameters + kCore + 2 * knot);
      const double weight = x.value[i] * y.value[j];
      delta += weight * control;
      slope.col(0) += x.slope[i] * y.value[j] * control;
      slope.col(1) += x.value[i] * y.slope[j] * control;
      if (d == nullptr) continue;
      d[kCore + 2 * knot] = weight;
      d[count + kCore + 2 * knot + 1] = weight;
    }
  }
  bent.point = u->u + delta;
  bent.d_point = (Eigen::Matrix2d::Identity() + scale * slope) * u->d_point;
  return true;
}

}  // namespace

LensShape shape_of(const Camera& camera) {
  LensShape shape{camera.model, camera.spline};
  shape.grid.delta_u.clear();
  return shape;
}

int lens_parameter_count(const LensShape& shape) {
  if (shape.model == LensModel::splined_stereographic) {
    return kCore + 2 * shape.grid.columns * shape.grid.rows;
  }
  return kCore + distortion_count(shape.model);
}

std::vector<std::string> lens_parameter_names(const LensShape& shape) {
  std::vector<std::string> names = {"fx_px", "fy_px", "cx_px", "cy_px"};
  constexpr std::array<const char*, 12> kOpenCv = {"k1", "k2", "p1", "p2", "k3", "k4",
                                                   "k5", "k6", "s1", "s2", "s3", "s4"};
  const int count = lens_parameter_count(shape);
  for (int i = 0; i < count - kCore; ++i) {
    if (shape.model == LensModel::splined_stereographic) {
      names.push_back("u" + std::to_string(i / 2) + (i % 2 == 0 ? "_x" : "_y"));
    } else if (shape.model == LensModel::kannala_brandt4) {
      names.push_back("k" + std::to_string(i + 1));
    } else {
      names.emplace_back(kOpenCv.at(static_cast<std::size_t>(i)));
    }
  }
  return names;
}

Eigen::VectorXd lens_parameters(const Camera& camera) {
  const LensShape shape = shape_of(camera);
  Eigen::VectorXd p = Eigen::VectorXd::Zero(lens_parameter_count(shape));
  p.head<kCore>() << camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px;
  const bool splined = shape.model == LensModel::splined_stereographic;
  for (Eigen::Index i = kCore; i < p.size(); ++i) {
    const auto at = static_cast<std::size_t>(i - kCore);
    if (!splined) p(i) = camera.distortion[at];
    if (splined && at < camera.spline.delta_u.size()) p(i) = camera.spline.delta_u[at];
  }
  return p;
}

Camera with_parameters(const Camera& like, const Eigen::VectorXd& p) {
  Camera camera = like;
  camera.fx_px = p(0), camera.fy_px = p(1), camera.cx_px = p(2), camera.cy_px = p(3);
  if (like.model == LensModel::splined_stereographic) {
    camera.spline.delta_u.assign(p.data() + kCore, p.data() + p.size());
    return camera;
  }
  camera.distortion = {};
  std::copy(p.data() + kCore, p.data() + p.size(), camera.distortion.begin());
  return camera;
}

bool lens_value(const LensShape& shape, const double* parameters, const Eigen::Vector3d& p,
                LensValue& value, double* d_parameters) {
  const int count = lens_parameter_count(shape);
  if (d_parameters != nullptr) std::fill_n(d_parameters, 2 * count, 0.0);
  Bent bent;
  bool seen = false;
  if (shape.model == LensModel::splined_stereographic) {
    seen = bend_splined(shape.grid, parameters, p, bent, d_parameters);
  } else if (shape.model == LensModel::kannala_brandt4) {
    seen = bend_kannala_brandt(parameters, p, bent, d_parameters);
  } else {
    seen = bend_perspective(count - kCore, parameters, p, bent, d_parameters);
  }
  if (!seen) return false;
  const Eigen::Vector2d f(parameters[0], parameters[1]);
  value.pixel_px = f.cwiseProduct(bent.point) + Eigen::Vector2d(parameters[2], parameters[3]);
  value.d_point = f.asDiagonal() * bent.d_point;
  if (d_parameters == nullptr) return true;
  for (int i = kCore; i < count; ++i) {
    d_parameters[i] *= f.x();
    d_parameters[count + i] *= f.y();
  }
  d_parameters[0] = bent.point.x();
  d_parameters[count + 1] = bent.point.y();
  d_parameters[2] = d_parameters[count + 3] = 1;
  return true;
}

}  // namespace cousin
