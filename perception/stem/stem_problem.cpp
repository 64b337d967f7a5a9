#include "perception/stem/stem_problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The inverse root of the covariance of (left x, left y, right x, right y).
Eigen::Matrix4d whitening(const StemSighting& s, const StemFitConfig& config, double moved_px) {
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  const double both = config.common_share * s.left.sigma_px * s.right.sigma_px;
  for (int k = 0; k < 2; ++k) {
    covariance(k, k) = s.left.sigma_px * s.left.sigma_px;
    covariance(k + 2, k + 2) = s.right.sigma_px * s.right.sigma_px;
    covariance(k, k + 2) = covariance(k + 2, k) = both;
  }
  covariance(2, 2) += moved_px * moved_px;
  covariance.diagonal().array() += 1e-4;  // truth has no error at all
  const Eigen::Matrix4d root = covariance.llt().matrixL();
  return root.inverse();
}

StemFrame frame_of(const std::vector<Vector3d>& points_m) {
  StemFrame frame;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& point : points_m) middle += point / static_cast<double>(points_m.size());
  frame.origin_m = middle;
  frame.depth = middle.normalized();
  Vector3d up = points_m.back() - points_m.front();
  up -= frame.depth * frame.depth.dot(up);
  if (!(up.norm() > 1e-6)) up = Vector3d(0, -1, 0) - frame.depth * -frame.depth.y();
  frame.up = up.normalized();
  frame.side = frame.up.cross(frame.depth);
  for (const Vector3d& point : points_m)
    frame.half_m = std::max(frame.half_m, std::abs(frame.up.dot(point - middle)));
  return frame;
}

/// Slopes of a stem that grows straight up, along the line of sight and to the side.
Eigen::Vector2d upright_slopes(const StemProblem& p) {
  const double along = p.up.up.dot(p.frame.up);
  if (along < 0.2) return Eigen::Vector2d::Zero();
  return {p.up.up.dot(p.frame.depth) / along, p.up.up.dot(p.frame.side) / along};
}

/// Whitened residuals: five of each node, then the priors. Empty where a node is behind an eye.
VectorXd residuals(const StemProblem& p, const VectorXd& at) {
  const auto n = static_cast<Eigen::Index>(p.sightings.size());
  VectorXd r = VectorXd::Zero(kPerNode * n + kStemShape - 2 + kStemRig);
  const Vector2d offset_px = at.segment<2>(kStemShape);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const StemSighting& s = p.sightings[k];
    const Vector3d node_m = p.node_m(at, k);
    const auto left = p.eyes.left.project(node_m);
    const auto right = p.eyes.right.project(p.eyes.right_from_left * node_m);
    if (!left || !right) return {};
    Eigen::Vector4d off;
    off << *left - s.left.pixel_px, *right + offset_px - s.right.pixel_px;
    r.segment<4>(kPerNode * i) = p.white[k] * off;
    if (s.shifted_px) {
      const double seen_px = s.shifted_px->x() - s.left.pixel_px.x();
      r(kPerNode * i + 4) =
          (right->x() + offset_px.x() + at(kStemShape + 2) - left->x() - seen_px) /
          s.shift_sigma_px;
    }
  }
  Eigen::Index row = kPerNode * n;
  const double half = p.frame.half_m, bend_m = 0.25 * p.config.bend_rad * half;
  const Eigen::Vector2d lean = upright_slopes(p);
  const double lean_tan = std::tan(p.up.is_of_ground ? p.config.upright_rad : p.config.lean_rad);
  r(row++) = (at(1) / half - lean.x()) / lean_tan;
  r(row++) = at(2) / bend_m;
  r(row++) = at(3) / bend_m;
  r(row++) = (at(5) / half - lean.y()) / lean_tan;
  r(row++) = at(6) / bend_m;
  r(row++) = at(7) / bend_m;
  r.segment<2>(row) = offset_px / std::max(1e-3, p.config.calibration_px);
  r(row + 2) = at(kStemShape + 2) / std::max(1e-3, p.config.shift_bias_px);
  return r;
}

/// Levenberg-Marquardt.
StemSolution solve(const StemProblem& p, VectorXd at) {
  StemSolution solution;
  VectorXd here = residuals(p, at);
  if (here.size() == 0) return solution;
  const auto numbers = [&p](const VectorXd& x) { return residuals(p, x); };
  MatrixXd normal;
  double damping = 1e-4;
  for (int step = 0; step < 40; ++step) {
    const MatrixXd slope = slopes(numbers, at, here.size());
    if (slope.size() == 0) return solution;
    normal = slope.transpose() * slope;
    const VectorXd right = slope.transpose() * here;
    bool is_better = false;
    double moved = 0;
    for (int attempt = 0; attempt < 8 && !is_better; ++attempt) {
      MatrixXd damped = normal;
      damped.diagonal() *= 1 + damping;
      const VectorXd move = damped.ldlt().solve(right);
      const VectorXd there = residuals(p, at - move);
      is_better = there.size() > 0 && there.squaredNorm() <= here.squaredNorm() * (1 + 1e-14);
      damping = is_better ? std::max(1e-12, 0.1 * damping) : 10 * damping;
      if (!is_better) continue;
      at -= move;
      here = there;
      moved = move.cwiseAbs().maxCoeff();
    }
    if (!is_better || moved < 1e-9) break;
  }
  const Eigen::LDLT<MatrixXd> inverse(normal);
  if (inverse.info() != Eigen::Success || !inverse.isPositive()) return solution;
  solution.covariance = inverse.solve(MatrixXd::Identity(normal.rows(), normal.cols()));
  solution.is_there = solution.covariance.allFinite() && at.allFinite();
  solution.at = std::move(at);
  solution.residual = std::move(here);
  return solution;
}

}  // namespace

double motion_px(const EyePair& eyes, const StemFitConfig& config, double depth_m, double apart_s) {
  return config.motion_m_per_s * std::abs(apart_s) * eyes.right.camera().fx_px /
         std::max(depth_m, 0.05);
}

MatrixXd slopes(const std::function<VectorXd(const VectorXd&)>& numbers, const VectorXd& at,
                Eigen::Index count) {
  MatrixXd slope(count, at.size());
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    const double step = 1e-6;
    VectorXd high = at, low = at;
    high(k) += step;
    low(k) -= step;
    const VectorXd above = numbers(high), below = numbers(low);
    if (above.size() != count || below.size() != count) return {};
    slope.col(k) = (above - below) / (2 * step);
  }
  return slope;
}

std::optional<Vector3d> first_guess(const EyePair& eyes, const StemSighting& s) {
  if (s.shifted_px) return middle_of_rays(eyes, s.left.pixel_px, *s.shifted_px);
  return middle_of_rays(eyes, s.left.pixel_px, s.right.pixel_px);
}

StemSolution solve_stem(StemProblem& p, double apart_s) {
  std::vector<Vector3d> points_m;
  for (const StemSighting& s : p.sightings) points_m.push_back(*first_guess(p.eyes, s));
  p.frame = frame_of(points_m);
  p.white.clear();
  for (const StemSighting& s : p.sightings) {
    p.white.push_back(
        whitening(s, p.config, motion_px(p.eyes, p.config, p.frame.origin_m.z(), apart_s)));
  }
  VectorXd at = VectorXd::Zero(p.unknowns());
  at(1) = p.frame.half_m * upright_slopes(p).x();
  for (std::size_t i = 0; i < points_m.size(); ++i)
    at(kStemShape + kStemRig + static_cast<Eigen::Index>(i)) =
        p.frame.up.dot(points_m[i] - p.frame.origin_m);
  return solve(p, at);
}

}  // namespace cousin
