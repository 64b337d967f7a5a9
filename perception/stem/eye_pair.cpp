#include "perception/stem/eye_pair.h"

#include <Eigen/Geometry>
#include <cmath>

#include "calibration/bundle/triangulation.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Signed distance of a point from a line, both with z = 1; nothing for a line without a direction.
std::optional<double> distance_from(const Vector3d& line, const Vector3d& point) {
  const double length = line.head<2>().norm();
  if (!(length > 1e-6 * line.norm())) return std::nullopt;
  return point.dot(line) / length;
}

}  // namespace

EyePair::EyePair(const Camera& left_camera, const Camera& right_camera,
                 const Pose& right_from_left_eye)
    : left(left_camera),
      right(right_camera),
      right_from_left(right_from_left_eye),
      baseline_m(right_from_left_eye.translation_m.norm()) {
  const Vector3d way = right_from_left.translation_m / std::max(baseline_m, 1e-12);
  Matrix3d cross;
  cross << 0, -way.z(), way.y(), way.z(), 0, -way.x(), -way.y(), way.x(), 0;
  essential = cross * right_from_left.rotation.toRotationMatrix();
}

std::optional<EpipolarDistance> epipolar_distance(const EyePair& eyes, const Vector2d& left_px,
                                                  const Vector2d& right_px) {
  const auto left = eyes.left.unproject(left_px), right = eyes.right.unproject(right_px);
  if (!left || !right || !(left->z() > 0) || !(right->z() > 0)) return std::nullopt;
  const Vector3d l = *left / left->z(), r = *right / right->z();
  Vector3d in_right = eyes.essential * l, in_left = eyes.essential.transpose() * r;
  // Distances grow downwards in the right image, whichever way the baseline points.
  const double sign = in_right.y() < 0 ? -1 : 1;
  const auto away_right = distance_from(sign * in_right, r);
  const auto away_left = distance_from(sign * in_left, l);
  if (!away_right || !away_left) return std::nullopt;
  return EpipolarDistance{*away_right * eyes.right.camera().fy_px,
                          *away_left * eyes.left.camera().fy_px};
}

std::optional<Vector3d> middle_of_rays(const EyePair& eyes, const Vector2d& left_px,
                                       const Vector2d& right_px) {
  const auto left = eyes.left.unproject(left_px), right = eyes.right.unproject(right_px);
  if (!left || !right) return std::nullopt;
  const Vector3d turned = eyes.right_from_left.rotation.conjugate() * *right;
  constexpr double kParallel_rad = 1e-4;
  if (left->cross(turned).norm() < kParallel_rad) return std::nullopt;
  const Vector3d eye = centre_in_world_m(eyes.right_from_left);
  const Vector3d middle = nearest_to_lines({Vector3d::Zero(), eye}, {*left, turned});
  if (!middle.allFinite() || middle.dot(*left) <= 0 || (middle - eye).dot(turned) <= 0)
    return std::nullopt;
  return middle;
}

}  // namespace cousin
