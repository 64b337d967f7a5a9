#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cousin {

/// Rigid transform b -> a: x_a = rotation * x_b + translation_m. Name it `a_from_b`.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit norm
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();       ///< origin of b, in a
};

Pose operator*(const Pose& a_from_b, const Pose& b_from_c);
Eigen::Vector3d operator*(const Pose& a_from_b, const Eigen::Vector3d& point_in_b_m);
Pose inverse(const Pose& a_from_b);
Eigen::Matrix4d to_matrix(const Pose& a_from_b);

/// The pose of a 4x4 matrix whose upper-left block is a rotation.
/// @throws std::invalid_argument if the block is not orthonormal to 1e-6, or a number is not
/// finite.
Pose pose_from_matrix(const Eigen::Matrix4d& a_from_b);

/// Camera at `eye` looking at `target`, image y axis as near to -`up` as it gets.
/// @throws std::invalid_argument if eye and target coincide or the view is along `up`.
Pose look_at(const Eigen::Vector3d& eye_in_world_m, const Eigen::Vector3d& target_in_world_m,
             const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());  ///< camera_from_world

/// The moving pose at `fraction` of the way from `begin` to `end`: translation linear in the
/// position of the origin of b, rotation by slerp. For rolling shutters and motion blur.
Pose interpolate(const Pose& begin, const Pose& end, double fraction);

/// Position of the camera centre in the world for a `camera_from_world`.
Eigen::Vector3d centre_in_world_m(const Pose& camera_from_world);

/// Angle of a rotation, in [0, pi].
double angle_rad(const Eigen::Quaterniond& rotation);

}  // namespace cousin
