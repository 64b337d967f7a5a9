#include "calibration/boards/homography.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace cousin {
namespace {

/// Similarity that moves points to mean zero and mean distance sqrt(2).
template <class Get>
Eigen::Matrix3d normalizer(const std::vector<PlanePoint>& points, const Get& get) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const PlanePoint& p : points) mean += get(p);
  mean /= static_cast<double>(points.size());
  double distance = 0;
  for (const PlanePoint& p : points) distance += (get(p) - mean).norm();
  distance /= static_cast<double>(points.size());
  const double scale = distance > 0 ? std::sqrt(2.0) / distance : 1.0;
  Eigen::Matrix3d m;
  m << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return m;
}

/// Least-squares homography between normalised coordinates; false if the points do not fix it.
bool linear_fit(const std::vector<PlanePoint>& points, const Eigen::Matrix3d& from,
                const Eigen::Matrix3d& to, Eigen::Matrix3d& result) {
  Eigen::Matrix<double, 9, 9> ata = Eigen::Matrix<double, 9, 9>::Zero();
  for (const PlanePoint& p : points) {
    const Eigen::Vector3d x = from * p.in_plane.homogeneous();
    const Eigen::Vector3d y = to * p.normalized.homogeneous();
    Eigen::Matrix<double, 9, 1> a, b;
    a << x, Eigen::Vector3d::Zero(), -y.x() * x;
    b << Eigen::Vector3d::Zero(), x, -y.y() * x;
    ata += a * a.transpose() + b * b.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(ata);
  // A second vanishing eigenvalue: the points lie on a line (or too few).
  if (!(solver.eigenvalues()(1) > 1e-9 * solver.eigenvalues()(8))) return false;
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  result << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  return true;
}

}  // namespace

Eigen::Vector2d transfer(const Eigen::Matrix3d& homography, const Eigen::Vector2d& point) {
  return (homography * point.homogeneous()).hnormalized();
}

HomographyFit fit_homography(const std::vector<PlanePoint>& points, double huber) {
  HomographyFit fit;
  if (points.size() < 4) return fit;
  const Eigen::Matrix3d from = normalizer(points, [](const PlanePoint& p) { return p.in_plane; });
  const Eigen::Matrix3d to = normalizer(points, [](const PlanePoint& p) { return p.normalized; });
  Eigen::Matrix3d h;
  if (!linear_fit(points, from, to, h)) return fit;
  if (std::abs(h(2, 2)) < 1e-12) return fit;
  h /= h(2, 2);

  for (int iteration = 0; iteration < 10; ++iteration) {
    Eigen::Matrix<double, 8, 8> jtj = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> jtr = Eigen::Matrix<double, 8, 1>::Zero();
    for (const PlanePoint& p : points) {
      const Eigen::Vector3d x = from * p.in_plane.homogeneous();
      const Eigen::Vector3d y = h * x;
      const Eigen::Vector2d seen = (to * p.normalized.homogeneous()).head<2>();
      const Eigen::Vector2d predicted = y.head<2>() / y.z();
      const double sigma = p.sigma * to(0, 0);
      const Eigen::Vector2d r = (seen - predicted) / sigma;
      Eigen::Matrix<double, 2, 8> j;
      j << x.transpose(), 0, 0, 0, -predicted.x() * x.head<2>().transpose(),  //
          0, 0, 0, x.transpose(), -predicted.y() * x.head<2>().transpose();
      j /= y.z() * sigma;
      const double norm = r.norm();
      const double weight = norm > huber ? huber / norm : 1.0;
      jtj += weight * j.transpose() * j;
      jtr += weight * j.transpose() * r;
    }
    const Eigen::Matrix<double, 8, 1> step = jtj.ldlt().solve(jtr);
    if (!step.allFinite()) return fit;
    h(0, 0) += step(0), h(0, 1) += step(1), h(0, 2) += step(2);
    h(1, 0) += step(3), h(1, 1) += step(4), h(1, 2) += step(5);
    h(2, 0) += step(6), h(2, 1) += step(7);
    if (step.norm() < 1e-12) break;
  }
  fit.normalized_from_plane = to.inverse() * h * from;
  fit.normalized_from_plane /= fit.normalized_from_plane.norm();
  int positive = 0;
  for (const PlanePoint& p : points) {
    positive += (fit.normalized_from_plane * p.in_plane.homogeneous()).z() > 0 ? 1 : -1;
  }
  if (positive < 0) fit.normalized_from_plane *= -1;
  fit.ok = fit.normalized_from_plane.allFinite();
  for (const PlanePoint& p : points) {
    fit.residual.push_back((transfer(fit.normalized_from_plane, p.in_plane) - p.normalized).norm() /
                           p.sigma);
  }
  return fit;
}

}  // namespace cousin
