#include "calibration/boards/board_bundle.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "calibration/boards/lens_jacobian.h"

namespace cousin {
namespace {

// Parameters of a view: rotation vector and translation added to the start, focal jitter, then, for
// a rolling shutter, turn (rad) and shift (m) during readout.
constexpr int kPose = 6, kJitter = 6, kMotion = 7, kGlobalSize = 7, kRollingSize = 13;
// Shared parameters: relative focal scale, principal point offset (px), distortion offsets; of a
// bent sheet its bends (m) last.
constexpr int kScale = 0, kCentre = 1, kDistortion = 3, kBends = 3;
constexpr double kBendReach_m = 0.05;  ///< half of the seed board's side
constexpr double kLossSigmas = 3;

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Heights of a sheet at a place of the board, a bend of 1 m each: along x, twisted, along y. Their
/// means over a plate of twice the reach are 0.
Eigen::Vector3d bend_heights(const Eigen::Vector3d& in_board_m) {
  const double x = in_board_m.x() / kBendReach_m, y = in_board_m.y() / kBendReach_m;
  return {x * x - 1.0 / 3, x * y, y * y - 1.0 / 3};
}

int view_size(const BundleView& view) { return view.readout_s > 0 ? kRollingSize : kGlobalSize; }

Camera adjusted(const Camera& reported, double jitter, const double* shared) {
  Camera camera = reported;
  const double factor = (1 + shared[kScale]) * (1 + jitter);
  camera.fx_px *= factor;
  camera.fy_px *= factor;
  camera.cx_px += shared[kCentre];
  camera.cy_px += shared[kCentre + 1];
  for (int i = 0; i < distortion_count(camera.model); ++i) {
    camera.distortion[static_cast<std::size_t>(i)] += shared[kDistortion + i];
  }
  return camera;
}

Pose moved(const Pose& start, const double* view) {
  return {(exp_rotation(Eigen::Map<const Eigen::Vector3d>(view)) * start.rotation).normalized(),
          start.translation_m + Eigen::Map<const Eigen::Vector3d>(view + 3)};
}

/// Left Jacobian of the rotation group to second order: increments stay far below a radian.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& v) {
  const Eigen::Matrix3d c = cross_matrix(v);
  return Eigen::Matrix3d::Identity() + 0.5 * c + c * c / 6;
}

/// Residual of one corner, whitened by its covariance, with analytic derivatives.
class CornerCost final : public ceres::CostFunction {
 public:
  CornerCost(const BundleView& view, const BoardPoint& point, const Eigen::Matrix2d& white,
             bool is_bent)
      : view_(view),
        point_(point),
        white_(white),
        is_bent_(is_bent),
        fraction_((point.pixel_px.y() - 0.5 * (view.reported.height_px - 1)) /
                  std::max(1, view.reported.height_px - 1)) {
    set_num_residuals(2);
    mutable_parameter_block_sizes()->push_back(view_size(view));
    mutable_parameter_block_sizes()->push_back(kDistortion + distortion_count(view.reported.model) +
                                               (is_bent ? kBends : 0));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* v = parameters[0];
    const Camera camera = adjusted(view_.reported, v[kJitter], parameters[1]);
    const bool rolling = view_size(view_) == kRollingSize;
    const Eigen::Index bend = parameter_block_sizes()[1] - kBends;
    Eigen::Vector3d in_board_m = point_.in_board_m;
    if (is_bent_)
      in_board_m.z() += bend_heights(point_.in_board_m)
                            .dot(Eigen::Map<const Eigen::Vector3d>(parameters[1] + bend));
    const Eigen::Vector3d turned = exp_rotation(Eigen::Map<const Eigen::Vector3d>(v)) *
                                   (view_.camera_from_board.rotation * in_board_m);
    const Eigen::Vector3d still =
        turned + view_.camera_from_board.translation_m + Eigen::Map<const Eigen::Vector3d>(v + 3);
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    if (rolling) {
      turn = exp_rotation(fraction_ * Eigen::Map<const Eigen::Vector3d>(v + kMotion))
                 .toRotationMatrix();
      shift = fraction_ * Eigen::Map<const Eigen::Vector3d>(v + kMotion + 3);
    }
    const Eigen::Vector3d p = turn * still + shift;
    const std::optional<Projection> seen = project_with_jacobian(camera, p);
    if (!seen) return false;
    const Eigen::Vector2d residual = white_ * (seen->pixel_px - point_.pixel_px);
    std::copy_n(residual.data(), 2, residuals);
    if (jacobians == nullptr) return true;
    const Eigen::Vector2d from_centre(seen->pixel_px.x() - camera.cx_px,
                                      seen->pixel_px.y() - camera.cy_px);
    if (jacobians[0] != nullptr) {
      Eigen::Map<RowMatrix> j(jacobians[0], 2, view_size(view_));
      const Eigen::Matrix<double, 2, 3> d = seen->d_point * turn;
      j.leftCols<3>() =
          -d * cross_matrix(turned) * left_jacobian(Eigen::Map<const Eigen::Vector3d>(v));
      j.middleCols<3>(3) = d;
      j.col(kJitter) = from_centre / (1 + v[kJitter]);
      if (rolling) {
        j.middleCols<3>(kMotion) = -fraction_ * seen->d_point * cross_matrix(turn * still);
        j.middleCols<3>(kMotion + 3) = fraction_ * seen->d_point;
      }
      j = white_ * j;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<RowMatrix> j(jacobians[1], 2, parameter_block_sizes()[1]);
      j.col(kScale) = from_centre / (1 + parameters[1][kScale]);
      j.middleCols<2>(kCentre).setIdentity();
      j.middleCols(kDistortion, distortion_count(camera.model)) = d_pixel_d_distortion(camera, p);
      if (is_bent_) {
        const Eigen::Vector3d upwards =
            exp_rotation(Eigen::Map<const Eigen::Vector3d>(v)) *
            (view_.camera_from_board.rotation * Eigen::Vector3d(0, 0, 1));
        j.rightCols<kBends>() =
            seen->d_point * (turn * upwards) * bend_heights(point_.in_board_m).transpose();
      }
      j = white_ * j;
    }
    return true;
  }

 private:
  const BundleView& view_;
  const BoardPoint& point_;
  Eigen::Matrix2d white_;
  bool is_bent_;
  double fraction_;  ///< of the readout, from the middle row
};

/// parameter / sigma for some parameters of a block; sigma = infinity leaves one free.
class Prior final : public ceres::CostFunction {
 public:
  explicit Prior(Eigen::VectorXd sigma) : sigma_(std::move(sigma)) {
    set_num_residuals(static_cast<int>(sigma_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(sigma_.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = sigma_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) =
        Eigen::Map<const Eigen::VectorXd>(parameters[0], n).cwiseQuotient(sigma_);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<RowMatrix>(jacobians[0], n, n) = sigma_.cwiseInverse().asDiagonal();
    }
    return true;
  }

 private:
  Eigen::VectorXd sigma_;
};

Eigen::VectorXd view_prior(const BundleView& view, const BoardPosesConfig& config) {
  Eigen::VectorXd sigma =
      Eigen::VectorXd::Constant(view_size(view), std::numeric_limits<double>::infinity());
  sigma(kJitter) = config.focal_jitter;
  if (view.readout_s > 0) {
    sigma.segment<3>(kMotion).setConstant(config.hand_rate_rad_per_s * view.readout_s);
    sigma.segment<3>(kMotion + 3).setConstant(config.hand_speed_m_per_s * view.readout_s);
  }
  return sigma;
}

Eigen::VectorXd shared_prior(const Camera& camera, const BoardPosesConfig& config, bool is_bent) {
  Eigen::VectorXd sigma(kDistortion + distortion_count(camera.model) + (is_bent ? kBends : 0));
  sigma.setConstant(config.distortion_prior);
  if (is_bent) sigma.tail<kBends>().setConstant(config.sheet_bend_m);
  sigma(kScale) = config.focal_prior;
  sigma.segment<2>(kCentre).setConstant(config.centre_prior_px_per_width * camera.width_px);
  return sigma;
}

/// Everything that is solved for, and what it was measured with.
struct Bundle {
  const std::vector<BundleView>& views;
  const BoardPosesConfig& config;
  /// All parameters in one piece, views first: Ceres eliminates blocks in the order of their
  /// addresses, which must not depend on the heap.
  std::vector<double> parameters;
  std::vector<std::size_t> offsets;  ///< of each view's parameters
  int shared_size = 0;
  bool is_bent = false;
  bool lens_fixed = false;

  Bundle(const std::vector<BundleView>& all, const BoardPosesConfig& c, bool bent)
      : views(all),
        config(c),
        shared_size(kDistortion + distortion_count(all.front().reported.model) +
                    (bent ? kBends : 0)),
        is_bent(bent),
        lens_fixed(!c.refine_lens || static_cast<int>(all.size()) < c.min_views_for_lens) {
    std::size_t size = 0;
    for (const BundleView& view : all) {
      offsets.push_back(size);
      size += static_cast<std::size_t>(view_size(view));
    }
    parameters.assign(size + static_cast<std::size_t>(shared_size), 0.0);
  }
  double* own(std::size_t i) { return parameters.data() + offsets[i]; }
  const double* own(std::size_t i) const { return parameters.data() + offsets[i]; }
  double* shared() {
    return parameters.data() + parameters.size() - static_cast<std::size_t>(shared_size);
  }
  const double* shared() const {
    return parameters.data() + parameters.size() - static_cast<std::size_t>(shared_size);
  }

  Eigen::Matrix2d white(const BoardPoint& p) const {
    return whitening(p.covariance_px2 + isotropic_px2(config.corner_floor_px));
  }
};

bool solve(Bundle& bundle) {
  ceres::Problem::Options ownership;
  ceres::Problem problem(ownership);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const Camera& first = bundle.views.front().reported;
  problem.AddParameterBlock(bundle.shared(), bundle.shared_size);
  problem.AddResidualBlock(new Prior(shared_prior(first, bundle.config, bundle.is_bent)), nullptr,
                           bundle.shared());
  if (bundle.lens_fixed) problem.SetParameterBlockConstant(bundle.shared());
  ordering->AddElementToGroup(bundle.shared(), 1);
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    const BundleView& view = bundle.views[i];
    double* parameters = bundle.own(i);
    problem.AddParameterBlock(parameters, view_size(view));
    ordering->AddElementToGroup(parameters, 0);
    problem.AddResidualBlock(new Prior(view_prior(view, bundle.config)), nullptr, parameters);
    for (const BoardPoint& p : view.points) {
      problem.AddResidualBlock(new CornerCost(view, p, bundle.white(p), bundle.is_bent),
                               new ceres::CauchyLoss(kLossSigmas), parameters, bundle.shared());
    }
    if (bundle.lens_fixed)
      problem.SetManifold(parameters, new ceres::SubsetManifold(view_size(view), {kJitter}));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.num_threads = 1;  // fixed: the sums' order must not depend on the caller's threads
  options.max_num_iterations = bundle.config.max_iterations;
  options.function_tolerance = 1e-10;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.termination_type == ceres::CONVERGENCE;
}

/// Normal equations of a view's own and the shared parameters.
struct ViewSystem {
  Eigen::MatrixXd own, mixed, shared;
  double weighted_squares = 0;  ///< robust
  double squares_px2 = 0;
};

ViewSystem linearize(const Bundle& bundle, std::size_t i) {
  const BundleView& view = bundle.views[i];
  const int own = view_size(view), all = bundle.shared_size;
  ViewSystem s{Eigen::MatrixXd::Zero(own, own), Eigen::MatrixXd::Zero(own, all),
               Eigen::MatrixXd::Zero(all, all)};
  RowMatrix jv(2, own), js(2, all);
  for (const BoardPoint& p : view.points) {
    const Eigen::Matrix2d white = bundle.white(p);
    const CornerCost cost(view, p, white, bundle.is_bent);
    const std::array<const double*, 2> parameters{bundle.own(i), bundle.shared()};
    std::array<double*, 2> jacobians{jv.data(), js.data()};
    Eigen::Vector2d r;
    if (!cost.Evaluate(parameters.data(), r.data(), jacobians.data())) continue;
    const double weight =
        1 / (1 + r.squaredNorm() / (kLossSigmas * kLossSigmas));  // of the Cauchy loss
    s.own += weight * jv.transpose() * jv;
    s.mixed += weight * jv.transpose() * js;
    s.shared += weight * js.transpose() * js;
    s.weighted_squares += weight * r.squaredNorm();
    s.squares_px2 += (white.inverse() * r).squaredNorm();
  }
  const Eigen::VectorXd prior = view_prior(view, bundle.config).cwiseInverse();
  s.own += Eigen::MatrixXd(prior.cwiseAbs2().asDiagonal());
  return s;
}

/// Covariances of the poses by the Schur complement of the shared lens, scaled by the variance of
/// the residuals where that is above what the corners predict. A lens that is not refined counts
/// with its prior.
void add_covariances(const Bundle& bundle, BundleResult& result) {
  const Eigen::VectorXd prior =
      shared_prior(bundle.views.front().reported, bundle.config, bundle.is_bent);
  Eigen::MatrixXd schur = prior.cwiseAbs2().cwiseInverse().asDiagonal();
  std::vector<ViewSystem> systems;
  std::vector<Eigen::MatrixXd> inverses;
  double squares = 0, count = 0;
  for (std::size_t i = 0; i < bundle.views.size(); ++i) {
    systems.push_back(linearize(bundle, i));
    const ViewSystem& s = systems.back();
    const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(s.own.rows(), s.own.cols());
    inverses.push_back(s.own.ldlt().solve(identity));
    if (!bundle.lens_fixed) schur += s.shared - s.mixed.transpose() * inverses.back() * s.mixed;
    squares += s.weighted_squares;
    count += 2.0 * static_cast<double>(bundle.views[i].points.size()) - kPose;
  }
  result.misfit = std::sqrt(squares / std::max(1.0, count));
  const double factor = std::max(1.0, squares / std::max(1.0, count));
  const Eigen::MatrixXd shared =
      schur.ldlt().solve(Eigen::MatrixXd::Identity(schur.rows(), schur.cols()));
  for (std::size_t i = 0; i < systems.size(); ++i) {
    const Eigen::MatrixXd gain = inverses[i] * systems[i].mixed;
    const Eigen::MatrixXd covariance = inverses[i] + gain * shared * gain.transpose();
    result.views[i].covariance = factor * covariance.topLeftCorner<kPose, kPose>();
    result.views[i].rms_px = std::sqrt(systems[i].squares_px2 /
                                       (2.0 * static_cast<double>(bundle.views[i].points.size())));
  }
}

}  // namespace

BundleResult bundle_adjust(const std::vector<BundleView>& views, const BoardPosesConfig& config,
                           bool is_bent) {
  BundleResult result;
  result.adjusted = true;
  if (views.empty()) {
    result.converged = true;
    return result;
  }
  Bundle bundle(views, config, is_bent);
  result.converged = solve(bundle);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double* own = bundle.own(i);
    result.views.push_back({moved(views[i].camera_from_board, own),
                            adjusted(views[i].reported, own[kJitter], bundle.shared())});
  }
  add_covariances(bundle, result);
  return result;
}

}  // namespace cousin
