#include "sim/geometry/similarity.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

/// Whether points fill more than a line.
bool spans_a_plane(const Eigen::Matrix3Xd& centred) {
  const Eigen::Vector3d spread =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred * centred.transpose()).eigenvalues();
  constexpr double kLeastShare = 1e-12;  // of squared lengths
  return spread.allFinite() && spread.y() > kLeastShare * spread.z();
}

}  // namespace

Eigen::Vector3d operator*(const WorldSimilarity& a_from_b, const Eigen::Vector3d& point_in_b) {
  return a_from_b.scale * (a_from_b.rotation * point_in_b) + a_from_b.shift_m;
}

Pose moved(const Pose& camera_from_b, const WorldSimilarity& a_from_b) {
  // x_c = R x_b + t with x_b = r' (x_a - shift) / s; the camera's own unit grows with the world's.
  Pose camera_from_a;
  camera_from_a.rotation = (camera_from_b.rotation * a_from_b.rotation.conjugate()).normalized();
  camera_from_a.translation_m =
      a_from_b.scale * camera_from_b.translation_m - camera_from_a.rotation * a_from_b.shift_m;
  return camera_from_a;
}

SimilarityFit fit_similarity(const std::vector<Eigen::Vector3d>& in_a,
                             const std::vector<Eigen::Vector3d>& in_b, ScaleFreedom freedom) {
  if (in_a.size() != in_b.size()) {
    throw std::invalid_argument("fit_similarity: " + std::to_string(in_a.size()) + " points and " +
                                std::to_string(in_b.size()));
  }
  SimilarityFit fit;
  if (in_a.size() < 3) return fit;
  const auto n = static_cast<Eigen::Index>(in_a.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = in_a[static_cast<std::size_t>(i)];
    b.col(i) = in_b[static_cast<std::size_t>(i)];
  }
  const Eigen::Vector3d middle_a = a.rowwise().mean(), middle_b = b.rowwise().mean();
  a.colwise() -= middle_a;
  b.colwise() -= middle_b;
  if (!spans_a_plane(a) || !spans_a_plane(b)) return fit;
  const Eigen::Matrix4d t = Eigen::umeyama(b, a, freedom == ScaleFreedom::free);
  const Eigen::Matrix3d scaled = t.topLeftCorner<3, 3>();
  WorldSimilarity& s = fit.a_from_b;
  s.scale = freedom == ScaleFreedom::free ? std::cbrt(scaled.determinant()) : 1;
  s.rotation = Eigen::Quaterniond(Eigen::Matrix3d(scaled / s.scale)).normalized();
  s.shift_m = middle_a - s.scale * (s.rotation * middle_b);
  if (!(s.scale > 0)) return fit;
  const Eigen::Matrix3d rotation = s.rotation.toRotationMatrix();
  const double left = (a - s.scale * (rotation * b)).squaredNorm();
  fit.rms_m = std::sqrt(left / static_cast<double>(n));
  const double freedoms = 3 * static_cast<double>(n) - (freedom == ScaleFreedom::free ? 7 : 6);
  // d(scale)/scale moves each point by its distance from the middle.
  fit.scale_sigma_share =
      freedom == ScaleFreedom::free ? std::sqrt(left / freedoms / a.squaredNorm()) : 0;
  fit.ok = true;
  return fit;
}

}  // namespace cousin
