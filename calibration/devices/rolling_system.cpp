#include "calibration/devices/rolling_system.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/boards/planar_pose.h"

namespace cousin {
namespace {

using Eigen::Index;
using Vector12d = Eigen::Matrix<double, 12, 1>;

/// Free parameters of the one lens.
std::vector<int> free_of(const ProblemLens& lens) {
  std::vector<int> free;
  for (std::size_t k = 0; k < lens.free.size(); ++k) {
    if (lens.free[k]) free.push_back(static_cast<int>(k));
  }
  return free;
}

/// Where a point is when the row that shows it is read.
struct RolledPoint {
  double rows = 0, s = 0;  ///< after the middle one; that in seconds
  Eigen::Vector3d still;   ///< R X
  PosedFrame turn;         ///< exp(s omega)
  Eigen::Vector3d turned;
  Eigen::Vector3d in_camera;
};

RolledPoint rolled(const Camera& image, const Pose& pose, const Vector6d& velocity, double delay_s,
                   const Eigen::Vector3d& point, double row_px) {
  const double rows = row_px - 0.5 * (image.height_px - 1), s = rows * delay_s;
  const Vector6d motion = s * velocity;
  RolledPoint p{rows, s, pose.rotation * point, PosedFrame(motion.data()), {}, {}};
  p.turned = p.turn.rotation * p.still;
  p.in_camera = p.turned + pose.translation_m + p.turn.translation;
  return p;
}

void add_view(const RollingProblem& all, const RollingState& state, std::size_t v,
              const std::vector<int>& free, RollingSystem& system) {
  const ProblemView& view = all.problem.views[v];
  const ProblemLens& lens = all.problem.lenses.front();
  const auto lenses = static_cast<Index>(free.size());
  const bool by_delay = all.delay_is_free && has_neighbour(all, v);
  const double delay_s = delay_of(all, state, v);
  const Vector6d& velocity = state.velocities[v];
  RowMatrix d_lens(2, lens_parameter_count(lens.shape));
  Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(2, system.shared.cols());
  auto mixed = system.mixed.middleRows<12>(12 * static_cast<Index>(v));
  for (const ProblemPoint& p : view.points) {
    if (p.rejected) continue;
    const RolledPoint at =
        rolled(lens.like, state.poses[v], velocity, delay_s,
               all.problem.target[static_cast<std::size_t>(p.id)], p.pixel_px.y());
    LensValue seen;
    if (!lens_value(lens.shape, state.lens.data(), at.in_camera, seen, d_lens.data())) {
      system.cost = std::numeric_limits<double>::infinity();
      return;
    }
    const Eigen::Vector2d whitened = p.white * (seen.pixel_px - p.pixel_px);
    system.squares += whitened.squaredNorm();
    system.coordinates += 2;
    const Eigen::Matrix2d w = p.white / all.noise;
    const Eigen::Vector2d r = whitened / all.noise;
    const Eigen::Matrix<double, 2, 3> d = w * seen.d_point;
    Eigen::Matrix<double, 2, 12> own;
    own.leftCols<3>() = -d * at.turn.rotation * cross_matrix(at.still);
    own.middleCols<3>(3) = d;
    own.middleCols<3>(6) = -at.s * d * cross_matrix(at.turned) * at.turn.left_jacobian;
    own.rightCols<3>() = at.s * d;
    for (Index k = 0; k < lenses; ++k)
      shared.col(k) = w * d_lens.col(free[static_cast<std::size_t>(k)]);
    if (by_delay) {
      const Eigen::Vector3d speed =
          velocity.head<3>().cross(at.turned) + Eigen::Vector3d(velocity.tail<3>());
      shared.col(lenses) = at.rows * (d * speed);
    }
    system.cost += r.squaredNorm();
    system.chain.own[v] += own.transpose() * own;
    system.right.segment<12>(12 * static_cast<Index>(v)) += own.transpose() * r;
    mixed += own.transpose() * shared;
    system.shared += shared.transpose() * shared;
    system.shared_right += shared.transpose() * r;
  }
}

/// A velocity that wanders: over a step of h, with an acceleration of variance q a step, the misses
/// of place and velocity have the covariance q [h^4 / 3, h^3 / 2; h^3 / 2, h^2].
void add_tie(const RollingProblem& all, const RollingState& state, std::size_t v,
             RollingSystem& system) {
  const double h = all.gap_s[v];
  const Pose &a = state.poses[v], &b = state.poses[v + 1];
  const Vector6d &va = state.velocities[v], &vb = state.velocities[v + 1];
  Vector6d turn;
  turn = pose_vector({b.rotation * a.rotation.conjugate(), Eigen::Vector3d::Zero()});
  const PosedFrame between(turn.data());
  const Eigen::Matrix3d by_b = between.left_jacobian.inverse();
  Eigen::Matrix<double, 12, 1> miss;
  miss << turn.head<3>() - h * va.head<3>(),
      b.translation_m - a.translation_m - h * Eigen::Vector3d(va.tail<3>()), vb - va;
  Matrix12d ja = Matrix12d::Zero(), jb = Matrix12d::Zero();
  ja.topLeftCorner<3, 3>() = -by_b * between.rotation;
  jb.topLeftCorner<3, 3>() = by_b;
  ja.block<3, 3>(3, 3) = -Eigen::Matrix3d::Identity();
  jb.block<3, 3>(3, 3) = Eigen::Matrix3d::Identity();
  ja.topRightCorner<6, 6>() = -h * Eigen::Matrix<double, 6, 6>::Identity();
  ja.bottomRightCorner<6, 6>() = -Eigen::Matrix<double, 6, 6>::Identity();
  jb.bottomRightCorner<6, 6>().setIdentity();
  Matrix12d information = Matrix12d::Zero();
  for (Index k = 0; k < 6; ++k) {
    const double q = all.acceleration_sigma(k) * all.acceleration_sigma(k);
    information(k, k) = 12 / (q * h * h * h * h);
    information(k, k + 6) = information(k + 6, k) = -6 / (q * h * h * h);
    information(k + 6, k + 6) = 4 / (q * h * h);
  }
  system.cost += miss.dot(information * miss);
  const auto at = 12 * static_cast<Index>(v);
  system.chain_of_priors.own[v] += ja.transpose() * information * ja;
  system.chain_of_priors.own[v + 1] += jb.transpose() * information * jb;
  system.chain_of_priors.next[v] += ja.transpose() * information * jb;
  system.right.segment<12>(at) += ja.transpose() * (information * miss);
  system.right.segment<12>(at + 12) += jb.transpose() * (information * miss);
}

void add_priors(const RollingProblem& all, const RollingState& state, const std::vector<int>& free,
                RollingSystem& system) {
  const ProblemLens& lens = all.problem.lenses.front();
  for (std::size_t i = 0; i < free.size(); ++i) {
    const Index k = free[i];
    const double weight = 1 / (lens.prior_sigma(k) * lens.prior_sigma(k));
    if (!(weight > 0)) continue;
    const auto at = static_cast<Index>(i);
    const double off = state.lens(k) - lens.prior_mean(k);
    system.shared_priors(at) += weight;
    system.shared_right(at) += weight * off;
    system.cost += weight * off * off;
  }
  for (std::size_t v = 0; v < state.poses.size(); ++v) {
    if (v + 1 < state.poses.size() && all.gap_s[v] > 0) add_tie(all, state, v, system);
    if (has_neighbour(all, v)) continue;
    const Vector6d weight = all.velocity_sigma.cwiseAbs2().cwiseInverse();
    const Vector6d& velocity = state.velocities[v];
    system.chain_of_priors.own[v].diagonal().tail<6>() += weight;
    system.right.segment<6>(12 * static_cast<Index>(v) + 6) += weight.cwiseProduct(velocity);
    system.cost += weight.dot(velocity.cwiseAbs2());
  }
}

RollingState stepped(const RollingProblem& all, const RollingState& state,
                     const Eigen::VectorXd& own, const Eigen::VectorXd& shared) {
  RollingState next = state;
  const std::vector<int> free = free_of(all.problem.lenses.front());
  for (std::size_t k = 0; k < free.size(); ++k) next.lens(free[k]) += shared(static_cast<Index>(k));
  if (all.delay_is_free) next.delay_s += shared(shared.size() - 1);
  for (std::size_t v = 0; v < state.poses.size(); ++v) {
    const Vector12d d = own.segment<12>(12 * static_cast<Index>(v));
    next.poses[v].rotation = (exp_rotation(d.head<3>()) * state.poses[v].rotation).normalized();
    next.poses[v].translation_m += d.segment<3>(3);
    next.velocities[v] += d.tail<6>();
  }
  return next;
}

}  // namespace

bool has_neighbour(const RollingProblem& problem, std::size_t view) {
  return (view < problem.gap_s.size() && problem.gap_s[view] > 0) ||
         (view > 0 && problem.gap_s[view - 1] > 0);
}

double delay_of(const RollingProblem& problem, const RollingState& state, std::size_t view) {
  return problem.delay_is_free && has_neighbour(problem, view) ? state.delay_s
                                                               : problem.reference_delay_s;
}

std::vector<Eigen::Vector2d> rolling_residuals(const RollingProblem& problem,
                                               const RollingState& state, std::size_t view) {
  const ProblemLens& lens = problem.problem.lenses.front();
  std::vector<Eigen::Vector2d> residuals;
  for (const ProblemPoint& p : problem.problem.views[view].points) {
    const RolledPoint at =
        rolled(lens.like, state.poses[view], state.velocities[view], delay_of(problem, state, view),
               problem.problem.target[static_cast<std::size_t>(p.id)], p.pixel_px.y());
    LensValue seen;
    const bool has = lens_value(lens.shape, state.lens.data(), at.in_camera, seen, nullptr);
    residuals.emplace_back(
        has ? Eigen::Vector2d(seen.pixel_px - p.pixel_px)
            : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return residuals;
}

RollingSystem rolling_system(const RollingProblem& problem, const RollingState& state) {
  const std::vector<int> free = free_of(problem.problem.lenses.front());
  const std::size_t views = state.poses.size();
  const auto n = static_cast<Index>(free.size()) + (problem.delay_is_free ? 1 : 0);
  RollingSystem system;
  system.chain.own.assign(views, Matrix12d::Zero());
  system.chain.next.assign(views > 0 ? views - 1 : 0, Matrix12d::Zero());
  system.chain_of_priors = system.chain;
  system.mixed = Eigen::MatrixXd::Zero(12 * static_cast<Index>(views), n);
  system.shared = Eigen::MatrixXd::Zero(n, n);
  system.shared_priors = Eigen::VectorXd::Zero(n);
  system.right = Eigen::VectorXd::Zero(12 * static_cast<Index>(views));
  system.shared_right = Eigen::VectorXd::Zero(n);
  for (std::size_t v = 0; v < views; ++v) add_view(problem, state, v, free, system);
  add_priors(problem, state, free, system);
  for (std::size_t v = 0; v < views; ++v) system.chain.own[v] += system.chain_of_priors.own[v];
  for (std::size_t v = 0; v + 1 < views; ++v)
    system.chain.next[v] += system.chain_of_priors.next[v];
  system.shared.diagonal() += system.shared_priors;
  return system;
}

int minimise_rolling(const RollingProblem& problem, RollingState& state, int most) {
  constexpr double kFlat = 1e-12, kLargestDamping = 1e12;
  double damping = 1e-6;
  RollingSystem system = rolling_system(problem, state);
  for (int i = 0; i < most; ++i) {
    FrameChain damped = system.chain;
    for (Matrix12d& own : damped.own) own.diagonal() *= 1 + damping;
    const ChainFactor factor(damped);
    if (!factor.ok()) return -1;
    const Eigen::MatrixXd gain = factor.solve(system.mixed);
    const Eigen::VectorXd own = factor.solve(system.right);
    Eigen::MatrixXd reduced = system.shared;
    reduced.diagonal() *= 1 + damping;
    reduced -= system.mixed.transpose() * gain;
    const Eigen::VectorXd scale =
        system.shared.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::VectorXd shared =
        -(scale.asDiagonal() *
          (scale.asDiagonal() * reduced * scale.asDiagonal())
              .ldlt()
              .solve(scale.asDiagonal() * (system.shared_right - system.mixed.transpose() * own)));
    const RollingState next = stepped(problem, state, -(own + gain * shared), shared);
    RollingSystem after = rolling_system(problem, next);
    if (after.cost <= system.cost) {
      const bool flat = system.cost - after.cost <= kFlat * system.cost;
      state = next;
      system = std::move(after);
      if (flat) return i + 1;
      damping = std::max(damping / 10, 1e-12);
    } else {
      damping *= 10;
      if (damping > kLargestDamping) return i + 1;  // no step helps: the minimum to rounding
    }
  }
  return -1;
}

}  // namespace cousin
