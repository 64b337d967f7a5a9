#include "calibration/bundle/triangulation.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "calibration/boards/planar_pose.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A sighting with its lens made once.
struct View {
  explicit View(const PointSighting& s)
      : lens(s.lens),
        pose(s.camera_from_world),
        pixel_px(s.pixel_px),
        white(whitening(s.covariance_px2)) {}
  Lens lens;
  Pose pose;  ///< camera_from_first
  Eigen::Vector2d pixel_px;
  Eigen::Matrix2d white;
};

/// Normal equations at (x/z, y/z, 1/z) of the first camera.
struct Normal {
  Matrix3d matrix = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  double squares = 0;
};

/// A point at homogeneous (a, b, 1, w): in each camera R (a, b, 1) + w t, scaled at will.
std::optional<Normal> normal_at(const std::vector<View>& views, const Vector3d& at) {
  Normal normal;
  for (const View& view : views) {
    const Matrix3d rotation = view.pose.rotation.toRotationMatrix();
    const Vector3d in_camera =
        rotation * Vector3d(at.x(), at.y(), 1) + at.z() * view.pose.translation_m;
    const auto seen = view.lens.project_with_jacobian(in_camera);
    if (!seen) return std::nullopt;
    Matrix3d d;
    d << rotation.col(0), rotation.col(1), view.pose.translation_m;
    const Eigen::Matrix<double, 2, 3> slope = view.white * seen->d_point * d;
    const Eigen::Vector2d residual = view.white * (seen->pixel_px - view.pixel_px);
    normal.matrix += slope.transpose() * slope;
    normal.right -= slope.transpose() * residual;
    normal.squares += residual.squaredNorm();
  }
  return normal;
}

/// Levenberg-Marquardt; the last point that improved.
std::optional<Normal> minimise(const std::vector<View>& views, Vector3d& at) {
  std::optional<Normal> here = normal_at(views, at);
  if (!here) return here;
  double damping = 1e-6;
  for (int step = 0; step < 60; ++step) {
    Matrix3d damped = here->matrix;
    damped.diagonal() *= 1 + damping;
    const Vector3d move = damped.ldlt().solve(here->right);
    if (!move.allFinite()) break;
    const std::optional<Normal> there = normal_at(views, at + move);
    if (there && there->squares <= here->squares) {
      const bool is_there = move.squaredNorm() < 1e-28 * (1 + at.squaredNorm());
      at += move;
      here = there;
      damping = std::max(1e-12, 0.1 * damping);
      if (is_there) break;
    } else {
      damping *= 10;
      if (damping > 1e10) break;
    }
  }
  return here;
}

double widest_angle(const std::vector<Vector3d>& directions) {
  double widest = 0;
  for (std::size_t a = 0; a < directions.size(); ++a) {
    for (std::size_t b = a + 1; b < directions.size(); ++b) {
      widest = std::max(widest, std::atan2(directions[a].cross(directions[b]).norm(),
                                           directions[a].dot(directions[b])));
    }
  }
  return widest;
}

/// Takes a point (x/z, y/z, 1/z) of the first camera and its covariance to the world.
void place_in_world(const Pose& first, const Vector3d& at, const Matrix3d& covariance,
                    Triangulation& result) {
  const double z = 1 / at.z();
  Matrix3d slope;  // of the point by (x/z, y/z, 1/z)
  slope << z, 0, -at.x() * z * z, 0, z, -at.y() * z * z, 0, 0, -z * z;
  const Matrix3d to_world = first.rotation.conjugate().toRotationMatrix();
  result.in_world_m = centre_in_world_m(first) + to_world * (z * Vector3d(at.x(), at.y(), 1));
  result.covariance_m2 = to_world * slope * covariance * slope.transpose() * to_world.transpose();
}

}  // namespace

std::string_view to_string(TriangulationStatus status) {
  switch (status) {
    case TriangulationStatus::ok:
      return "ok";
    case TriangulationStatus::too_few:
      return "too_few";
    case TriangulationStatus::no_direction:
      return "no_direction";
    case TriangulationStatus::parallel:
      return "parallel";
    case TriangulationStatus::behind:
      return "behind";
    case TriangulationStatus::disagree:
      return "disagree";
  }
  throw std::invalid_argument("triangulation status " + std::to_string(static_cast<int>(status)) +
                              " does not exist");
}

Vector3d nearest_to_lines(const std::vector<Vector3d>& origins_m,
                          const std::vector<Vector3d>& directions) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (std::size_t i = 0; i < origins_m.size(); ++i) {
    const Matrix3d across = Matrix3d::Identity() - directions[i] * directions[i].transpose();
    normal += across;
    right += across * origins_m[i];
  }
  return normal.ldlt().solve(right);
}

Triangulation triangulate(const std::vector<PointSighting>& sightings,
                          const TriangulationConfig& config) {
  Triangulation result;
  if (sightings.size() < 2) return result;
  // In the first camera's axes, so that a far origin of the world costs no digits.
  const Pose first = sightings.front().camera_from_world;
  std::vector<View> views;
  std::vector<Vector3d> origins, directions;
  for (const PointSighting& sighting : sightings) {
    View& view = views.emplace_back(sighting);
    view.pose.rotation = sighting.camera_from_world.rotation * first.rotation.conjugate();
    const Vector3d apart = centre_in_world_m(sighting.camera_from_world) - centre_in_world_m(first);
    view.pose.translation_m = -(sighting.camera_from_world.rotation * apart);
    const auto way = view.lens.unproject(sighting.pixel_px);
    if (!way) {
      result.status = TriangulationStatus::no_direction;
      return result;
    }
    origins.emplace_back(first.rotation * apart);
    directions.emplace_back(view.pose.rotation.conjugate() * *way);
  }
  result.parallax_rad = widest_angle(directions);
  result.status = TriangulationStatus::parallel;
  if (result.parallax_rad < config.min_parallax_rad) return result;
  const Vector3d& ahead = directions.front();
  if (!(ahead.z() > 0)) {
    result.status = TriangulationStatus::no_direction;
    return result;
  }
  const Vector3d start = nearest_to_lines(origins, directions);
  Vector3d at(ahead.x() / ahead.z(), ahead.y() / ahead.z(), 0);
  if (start.allFinite() && start.z() > 0) at.z() = 1 / start.z();
  const std::optional<Normal> normal = minimise(views, at);
  if (!normal) {
    result.status = TriangulationStatus::behind;
    return result;
  }
  const Matrix3d covariance = normal->matrix.inverse();
  const auto freedoms = 2.0 * static_cast<double>(views.size()) - 3;
  result.residual_sigmas = std::sqrt(normal->squares / freedoms);
  const double deviation = std::sqrt(covariance(2, 2));
  if (!std::isfinite(deviation)) return result;
  result.depth_sigmas = at.z() / deviation;
  if (result.residual_sigmas > config.max_residual_sigmas) {
    result.status = TriangulationStatus::disagree;
    return result;
  }
  if (std::abs(result.depth_sigmas) < config.min_depth_sigmas) return result;
  if (at.z() < 0) {
    result.status = TriangulationStatus::behind;
    return result;
  }
  place_in_world(first, at, covariance, result);
  result.status = TriangulationStatus::ok;
  return result;
}

}  // namespace cousin
