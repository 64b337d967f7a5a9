#include "calibration/bundle/bundle_frame.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

#include "calibration/boards/planar_pose.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

struct Similarity {
  Matrix3d rotation = Matrix3d::Identity();
  double scale = 1;
  Vector3d shift = Vector3d::Zero();
};

double spread_of(const Matrix3Xd& points) {
  return (points.colwise() - points.rowwise().mean()).norm();
}

/// The rotation nearest to the sum of the cameras' own [Kabsch, Acta Cryst. A32, 1976].
Matrix3d mean_turn(const std::vector<Vector6d>& after, const std::vector<Vector6d>& before) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t i = 0; i < before.size(); ++i) {
    sum += (pose_of_vector(before[i]).rotation.conjugate() * pose_of_vector(after[i]).rotation)
               .toRotationMatrix();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

/// world_after -> world_before
Similarity back_to_start(const BundleProblem& after, const std::vector<Vector6d>& before) {
  // Centres that are a line to the digits that poses are written with say nothing of a turn about
  // it.
  constexpr double kRail = 1e-4;
  Matrix3Xd from(3, before.size()), to(3, before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    from.col(at) = centre_in_world_m(pose_of_vector(after.poses[i]));
    to.col(at) = centre_in_world_m(pose_of_vector(before[i]));
  }
  const bool has_scale = after.gauge == BundleGauge::similarity;
  Similarity result;
  if (are_on_a_line(from, kRail) || are_on_a_line(to, kRail)) {
    result.rotation = mean_turn(after.poses, before);
    const double apart = spread_of(from);
    if (has_scale && apart > 0) result.scale = spread_of(to) / apart;
    result.shift = to.rowwise().mean() - result.scale * (result.rotation * from.rowwise().mean());
    return result;
  }
  const Eigen::Matrix4d t = Eigen::umeyama(from, to, has_scale);
  result.scale = std::cbrt(t.topLeftCorner<3, 3>().determinant());
  result.rotation = t.topLeftCorner<3, 3>() / result.scale;
  result.shift = t.topRightCorner<3, 1>();
  return result;
}

}  // namespace

bool are_on_a_line(const Matrix3Xd& points, double most_share) {
  if (points.cols() < 3) return true;
  const Matrix3Xd apart = points.colwise() - points.rowwise().mean();
  const Vector3d squares =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(apart * apart.transpose()).eigenvalues();
  return squares.y() <= most_share * most_share * squares.z();
}

void hold_frame(const std::vector<Vector6d>& before, BundleProblem& problem) {
  if (problem.gauge == BundleGauge::metric) return;
  const Similarity s = back_to_start(problem, before);
  for (Vector3d& point : problem.points) point = s.scale * (s.rotation * point) + s.shift;
  for (Vector6d& vector : problem.poses) {
    const Pose pose = pose_of_vector(vector);
    Pose moved;
    moved.rotation = Eigen::Quaterniond(pose.rotation * Eigen::Quaterniond(s.rotation).conjugate());
    moved.translation_m = s.scale * pose.translation_m - moved.rotation * s.shift;
    vector = pose_vector(moved);
  }
}

}  // namespace cousin
