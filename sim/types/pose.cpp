#include "sim/types/pose.h"

#include <cmath>
#include <stdexcept>

namespace cousin {

Pose operator*(const Pose& a_from_b, const Pose& b_from_c) {
  return {(a_from_b.rotation * b_from_c.rotation).normalized(),
          a_from_b.rotation * b_from_c.translation_m + a_from_b.translation_m};
}

Eigen::Vector3d operator*(const Pose& a_from_b, const Eigen::Vector3d& point_in_b_m) {
  return a_from_b.rotation * point_in_b_m + a_from_b.translation_m;
}

Pose inverse(const Pose& a_from_b) {
  const Eigen::Quaterniond rotation = a_from_b.rotation.conjugate();
  return {rotation, -(rotation * a_from_b.translation_m)};
}

Eigen::Matrix4d to_matrix(const Pose& a_from_b) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = a_from_b.rotation.toRotationMatrix();
  m.topRightCorner<3, 1>() = a_from_b.translation_m;
  return m;
}

Pose pose_from_matrix(const Eigen::Matrix4d& a_from_b) {
  const Eigen::Matrix3d rotation = a_from_b.topLeftCorner<3, 3>();
  if (!a_from_b.allFinite() ||
      !(rotation * rotation.transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-6) ||
      rotation.determinant() < 0) {
    throw std::invalid_argument("pose matrix: the upper-left 3x3 block is not a rotation");
  }
  return {Eigen::Quaterniond(rotation).normalized(), a_from_b.topRightCorner<3, 1>()};
}

Pose look_at(const Eigen::Vector3d& eye_in_world_m, const Eigen::Vector3d& target_in_world_m,
             const Eigen::Vector3d& up) {
  const Eigen::Vector3d forward = target_in_world_m - eye_in_world_m;
  const Eigen::Vector3d right = forward.cross(up);
  if (forward.norm() < 1e-12 || right.norm() < 1e-9 * forward.norm()) {
    throw std::invalid_argument("look_at: eye and target coincide, or the view is along `up`");
  }
  Eigen::Matrix3d camera_from_world;
  camera_from_world.row(0) = right.normalized();
  camera_from_world.row(2) = forward.normalized();
  camera_from_world.row(1) = camera_from_world.row(2).cross(camera_from_world.row(0));
  return {Eigen::Quaterniond(camera_from_world).normalized(), -camera_from_world * eye_in_world_m};
}

Pose interpolate(const Pose& begin, const Pose& end, double fraction) {
  return {begin.rotation.slerp(fraction, end.rotation).normalized(),
          (1 - fraction) * begin.translation_m + fraction * end.translation_m};
}

Eigen::Vector3d centre_in_world_m(const Pose& camera_from_world) {
  return -(camera_from_world.rotation.conjugate() * camera_from_world.translation_m);
}

double angle_rad(const Eigen::Quaterniond& rotation) {
  return 2 * std::atan2(rotation.vec().norm(), std::abs(rotation.w()));
}

}  // namespace cousin
