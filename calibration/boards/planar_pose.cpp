#include "calibration/boards/planar_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "calibration/boards/homography.h"
#include "sim/types/seams.h"

namespace cousin {
namespace {

constexpr double kHuberSigmas = 3;
constexpr double kHopeless = 1e30;  // cost of a pose with points behind the camera
constexpr double kSamePose_rad = 0.0175;

struct System {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  double cost = 0;
  double squares_px2 = 0;
};

/// Robust cost and normal equations in (rotation vector of the camera-side increment, translation).
System linearize(const Lens& lens, const std::vector<BoardPoint>& points, const Pose& pose) {
  System system;
  for (const BoardPoint& p : points) {
    const Eigen::Vector3d turned = pose.rotation * p.in_board_m;
    const std::optional<Projection> seen = lens.project_with_jacobian(turned + pose.translation_m);
    if (!seen) {
      system.cost = kHopeless;
      return system;
    }
    const Eigen::Matrix2d white = whitening(p.covariance_px2);
    const Eigen::Vector2d r = white * (p.pixel_px - seen->pixel_px);
    Eigen::Matrix<double, 2, 6> j;
    j << -seen->d_point * cross_matrix(turned), seen->d_point;
    j = white * j;
    const double norm = r.norm();
    const double weight = norm > kHuberSigmas ? kHuberSigmas / norm : 1;
    system.cost += norm > kHuberSigmas ? kHuberSigmas * (2 * norm - kHuberSigmas) : norm * norm;
    system.normal += weight * j.transpose() * j;
    system.right += weight * j.transpose() * r;
    system.squares_px2 += (p.pixel_px - seen->pixel_px).squaredNorm();
  }
  return system;
}

struct Refined {
  Pose pose;
  System system;
  bool converged = false;
};

Refined refine(const Lens& lens, const std::vector<BoardPoint>& points, const Pose& start) {
  constexpr int kIterations = 60;
  Refined best{start, linearize(lens, points, start)};
  double damping = 1e-4;
  for (int i = 0; i < kIterations && best.system.cost < kHopeless; ++i) {
    Eigen::Matrix<double, 6, 6> damped = best.system.normal;
    damped.diagonal() *= 1 + damping;
    const Eigen::Matrix<double, 6, 1> step = damped.ldlt().solve(best.system.right);
    if (!step.allFinite()) return best;
    const Pose next{(exp_rotation(step.head<3>()) * best.pose.rotation).normalized(),
                    best.pose.translation_m + step.tail<3>()};
    const System system = linearize(lens, points, next);
    if (system.cost <= best.system.cost) {
      const double gain = best.system.cost - system.cost;
      best.pose = next;
      best.system = system;
      damping = std::max(damping / 10, 1e-12);
      if (gain <= 1e-9 * best.system.cost || step.norm() < 1e-13) {
        best.converged = true;
        return best;
      }
    } else {
      damping *= 10;
      if (damping > 1e10) {  // no step helps any more: this is the minimum to rounding
        best.converged = true;
        return best;
      }
    }
  }
  return best;
}

Pose pose_of(const Eigen::Matrix3d& normalized_from_board) {
  const double scale =
      std::sqrt(normalized_from_board.col(0).norm() * normalized_from_board.col(1).norm());
  Eigen::Matrix3d m = normalized_from_board / scale;
  const Eigen::Vector3d translation = m.col(2);
  m.col(2) = m.col(0).cross(m.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (rotation.determinant() < 0) rotation.col(2) *= -1;
  return {Eigen::Quaterniond(rotation).normalized(), translation};
}

/// The plane's normal mirrored about the line of sight to its origin; the origin stays.
Pose mirrored(const Pose& pose) {
  const Eigen::Vector3d sight = pose.translation_m.normalized();
  const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d mirror = 2 * normal.dot(sight) * sight - normal;
  return {(Eigen::Quaterniond::FromTwoVectors(normal, mirror) * pose.rotation).normalized(),
          pose.translation_m};
}

}  // namespace

Eigen::Matrix2d whitening(const Eigen::Matrix2d& covariance) {
  return covariance.llt().matrixL().solve(Eigen::Matrix2d::Identity());
}

Eigen::Quaterniond exp_rotation(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const double s = angle > 1e-8 ? std::sin(0.5 * angle) / angle : 0.5;
  return Eigen::Quaterniond(std::cos(0.5 * angle), s * v.x(), s * v.y(), s * v.z()).normalized();
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

PlanarPose estimate_planar_pose(const Camera& camera, const std::vector<BoardPoint>& points) {
  PlanarPose result;
  const Lens lens(camera);  // finds once where the lens folds
  std::vector<PlanePoint> plane;
  for (const BoardPoint& p : points) {
    const std::optional<Eigen::Vector3d> ray = lens.unproject(p.pixel_px);
    if (!ray || ray->z() < 1e-3) return result;
    plane.push_back({p.in_board_m.head<2>(), ray->head<2>() / ray->z(),
                     rms_sigma_px(p.covariance_px2) / camera.fx_px});
  }
  const HomographyFit fit = fit_homography(plane);
  if (!fit.ok) return result;
  const Pose start = pose_of(fit.normalized_from_plane);
  Refined best = refine(lens, points, start);
  Refined other = refine(lens, points, mirrored(best.system.cost < kHopeless ? best.pose : start));
  if (other.system.cost < best.system.cost) std::swap(best, other);
  result.ok = best.converged && best.system.cost < kHopeless;
  result.camera_from_board = best.pose;
  // Where points miss by more than their deviations say, costs count by what they do miss by.
  const double freedoms = std::max(1.0, 2.0 * static_cast<double>(points.size()) - 6);
  const double unit = std::max(1.0, best.system.cost / freedoms);
  result.is_ambiguous = result.ok && other.converged &&
                        other.system.cost - best.system.cost < kAmbiguousCost * unit &&
                        other.pose.rotation.angularDistance(best.pose.rotation) > kSamePose_rad;
  result.rms_px = std::sqrt(best.system.squares_px2 / (2.0 * static_cast<double>(points.size())));
  return result;
}

}  // namespace cousin
