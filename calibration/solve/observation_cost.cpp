#include "calibration/solve/observation_cost.h"

#include <Eigen/Geometry>
#include <cmath>

#include "calibration/boards/planar_pose.h"

namespace cousin {
namespace {

Eigen::Matrix3d left_jacobian_of(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const Eigen::Matrix3d c = cross_matrix(v);
  if (angle < 1e-4) return Eigen::Matrix3d::Identity() + 0.5 * c + c * c / 6;
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / a2 * c +
         (angle - std::sin(angle)) / (a2 * angle) * c * c;
}

}  // namespace

Vector6d pose_vector(const Pose& pose) {
  const Eigen::AngleAxisd turn(pose.rotation.normalized());
  Vector6d v;
  v << turn.angle() * turn.axis(), pose.translation_m;
  return v;
}

Pose pose_of_vector(const Vector6d& v) { return {exp_rotation(v.head<3>()), v.tail<3>()}; }

PosedFrame::PosedFrame(const double* v)
    : rotation(exp_rotation(Eigen::Map<const Eigen::Vector3d>(v)).toRotationMatrix()),
      translation(Eigen::Map<const Eigen::Vector3d>(v + 3)),
      left_jacobian(left_jacobian_of(Eigen::Map<const Eigen::Vector3d>(v))) {}

bool observe(const LensShape& shape, const double* lens, const PosedFrame* camera_from_rig,
             const PosedFrame& rig_from_points, const Eigen::Vector3d& point,
             ObservationValue& value, double* d_lens) {
  const Eigen::Vector3d turned = rig_from_points.rotation * point;
  const Eigen::Vector3d in_rig = turned + rig_from_points.translation;
  Eigen::Vector3d turned_rig = in_rig, in_camera = in_rig;
  if (camera_from_rig != nullptr) {
    turned_rig = camera_from_rig->rotation * in_rig;
    in_camera = turned_rig + camera_from_rig->translation;
  }
  LensValue seen;
  if (!lens_value(shape, lens, in_camera, seen, d_lens)) return false;
  value.pixel_px = seen.pixel_px;
  if (d_lens == nullptr) return true;
  Eigen::Matrix<double, 2, 3> d_rig = seen.d_point;
  if (camera_from_rig != nullptr) {
    value.d_camera_from_rig.leftCols<3>() =
        -seen.d_point * cross_matrix(turned_rig) * camera_from_rig->left_jacobian;
    value.d_camera_from_rig.rightCols<3>() = seen.d_point;
    d_rig = seen.d_point * camera_from_rig->rotation;
  }
  value.d_rig_from_points.leftCols<3>() =
      -d_rig * cross_matrix(turned) * rig_from_points.left_jacobian;
  value.d_rig_from_points.rightCols<3>() = d_rig;
  value.d_point = d_rig * rig_from_points.rotation;
  return true;
}

bool observe_zoomed(const LensShape& shape, const double* lens, double zoom, const PosedFrame& pose,
                    const Eigen::Vector3d& point, ObservationValue& value, double* d_lens,
                    Eigen::Vector2d* d_zoom) {
  if (!observe(shape, lens, nullptr, pose, point, value, d_lens)) return false;
  constexpr int kCentre = 2;  // fx, fy, cx, cy, ...
  const Eigen::Vector2d from_centre =
      value.pixel_px - Eigen::Vector2d(lens[kCentre], lens[kCentre + 1]);
  if (d_zoom != nullptr) *d_zoom = from_centre;
  if (zoom == 1) return true;
  value.pixel_px += (zoom - 1) * from_centre;
  if (d_lens == nullptr) return true;
  Eigen::Map<RowMatrix> by_lens(d_lens, 2, lens_parameter_count(shape));
  by_lens *= zoom;
  for (int k = 0; k < 2; ++k) by_lens(k, kCentre + k) += 1 - zoom;
  value.d_rig_from_points *= zoom;
  value.d_point *= zoom;
  return true;
}

Softened soften(RobustLoss loss, double turn, const Eigen::Vector2d& residual) {
  Softened soft;
  const double s = residual.squaredNorm(), a2 = turn * turn;
  if (loss == RobustLoss::none || (loss == RobustLoss::huber && s <= a2)) return soft;
  double rho = 0;
  if (loss == RobustLoss::huber) {
    rho = 2 * turn * std::sqrt(s) - a2;
    soft.weight = turn / std::sqrt(s);
  } else {
    rho = a2 * std::log1p(s / a2);
    soft.weight = 1 / (1 + s / a2);
  }
  if (s < 1e-8 * a2) return soft;
  soft.factor = std::sqrt(rho / s);
  const double d_factor = (soft.weight * s - rho) / (2 * soft.factor * s * s);
  soft.d =
      soft.factor * Eigen::Matrix2d::Identity() + 2 * d_factor * residual * residual.transpose();
  return soft;
}

}  // namespace cousin
