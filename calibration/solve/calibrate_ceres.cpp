#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "calibration/solve/calibration_seed.h"
#include "calibration/solve/calibration_solvers.h"
#include "calibration/solve/quiet_ceres.h"

namespace cousin {
namespace {

constexpr int kSeedViewsPerLens = 40;

/// All residuals of one view, whitened, under the loss. Blocks: the frame's pose, the lens, then,
/// where they matter, the camera's pose and the deformation.
class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(const CalibrationProblem& problem, const ProblemView& view, RobustLoss loss)
      : problem_(problem), view_(view), loss_(loss), in_rig_(view.camera > 0) {
    lens_ = &problem.lenses[static_cast<std::size_t>(
        problem.lens_of_camera[static_cast<std::size_t>(view.camera)])];
    int points = 0;
    for (const ProblemPoint& p : view.points) points += p.rejected ? 0 : 1;
    set_num_residuals(2 * points);
    auto& sizes = *mutable_parameter_block_sizes();
    sizes.push_back(6);
    sizes.push_back(lens_parameter_count(lens_->shape));
    if (in_rig_) sizes.push_back(6);
    if (problem.config.board_deformation) sizes.push_back(2);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const PosedFrame frame(parameters[0]);
    std::optional<PosedFrame> camera;
    if (in_rig_) camera.emplace(parameters[2]);
    const std::size_t bent = in_rig_ ? 3 : 2;
    const bool bends = problem_.config.board_deformation;
    const Eigen::Vector2d k =
        bends ? Eigen::Vector2d(Eigen::Map<const Eigen::Vector2d>(parameters[bent]))
              : Eigen::Vector2d::Zero();
    const int n = lens_parameter_count(lens_->shape);
    RowMatrix d_lens(2, n);
    ObservationValue value;
    Eigen::Index row = 0;
    for (const ProblemPoint& p : view_.points) {
      if (p.rejected) continue;
      if (!observe(lens_->shape, parameters[1], camera ? &*camera : nullptr, frame,
                   deformed(problem_, p.id, k), value, jacobians ? d_lens.data() : nullptr))
        return false;
      const Eigen::Vector2d residual = p.white * (value.pixel_px - p.pixel_px);
      const Softened soft = soften(loss_, problem_.config.loss_px, residual);
      Eigen::Map<Eigen::Vector2d>(residuals + row) = soft.factor * residual;
      if (jacobians != nullptr) {
        const Eigen::Matrix2d w = soft.d * p.white;
        const auto put = [&](std::size_t block, const auto& d) {
          if (jacobians[block] == nullptr) return;
          Eigen::Map<RowMatrix>(jacobians[block] + row * d.cols(), 2, d.cols()).noalias() =
              w.lazyProduct(d);
        };
        put(0, value.d_rig_from_points);
        put(1, d_lens);
        if (in_rig_) put(2, value.d_camera_from_rig);
        if (bends) {
          const Eigen::Matrix<double, 2, 2, Eigen::RowMajor> d =
              value.d_point.col(2) * d_deformation(problem_, p.id).transpose();
          put(bent, d);
        }
      }
      row += 2;
    }
    return true;
  }

 private:
  const CalibrationProblem& problem_;
  const ProblemView& view_;
  RobustLoss loss_;
  bool in_rig_;
  const ProblemLens* lens_ = nullptr;
};

/// (parameter - mean) / sigma for those of a block that have a prior.
class BlockPrior final : public ceres::CostFunction {
 public:
  BlockPrior(Eigen::VectorXd mean, const Eigen::VectorXd& sigma)
      : mean_(std::move(mean)), weight_(sigma.cwiseInverse()) {
    set_num_residuals(static_cast<int>(mean_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(mean_.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = mean_.size();
    Eigen::Map<Eigen::VectorXd>(residuals, n) =
        weight_.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(parameters[0], n) - mean_);
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMatrix>(jacobians[0], n, n) = weight_.asDiagonal();
    return true;
  }

 private:
  Eigen::VectorXd mean_, weight_;
};

/// One minimisation: which lens parameters move, under which loss, how far.
struct Stage {
  std::vector<std::vector<bool>> free;
  RobustLoss loss = RobustLoss::none;
  double tolerance = 1e-6;
  int max_iterations = 30;
};

/// All parameters in one piece, frames first: Ceres eliminates blocks in the order of their
/// addresses, which must not depend on the heap.
struct PackedState {
  std::vector<double> values;
  std::vector<std::size_t> lenses;
  std::size_t cameras = 0, deformation = 0;

  explicit PackedState(const CalibrationState& state) {
    const auto add = [&](const auto& block) {
      values.insert(values.end(), block.data(), block.data() + block.size());
    };
    for (const Vector6d& frame : state.frames) add(frame);
    for (const Eigen::VectorXd& lens : state.lenses) {
      lenses.push_back(values.size());
      add(lens);
    }
    cameras = values.size();
    for (const Vector6d& camera : state.cameras) add(camera);
    deformation = values.size();
    add(state.deformation);
  }
  double* frame(int i) { return values.data() + 6 * static_cast<std::size_t>(i); }
  double* lens(std::size_t i) { return values.data() + lenses[i]; }
  double* camera(std::size_t i) { return values.data() + cameras + 6 * i; }
  double* bent() { return values.data() + deformation; }

  void unpack(CalibrationState& state) {
    for (std::size_t i = 0; i < state.frames.size(); ++i)
      state.frames[i] = Eigen::Map<Vector6d>(frame(static_cast<int>(i)));
    for (std::size_t i = 0; i < state.lenses.size(); ++i)
      state.lenses[i] = Eigen::Map<Eigen::VectorXd>(lens(i), state.lenses[i].size());
    for (std::size_t i = 0; i < state.cameras.size(); ++i)
      state.cameras[i] = Eigen::Map<Vector6d>(camera(i));
    state.deformation = Eigen::Map<Eigen::Vector2d>(bent());
  }
};

void add_blocks(const CalibrationProblem& problem, const Stage& stage, PackedState& packed,
                ceres::Problem& ceres_problem, ceres::ParameterBlockOrdering& ordering) {
  for (std::size_t i = 0; i < problem.frames.size(); ++i) {
    ceres_problem.AddParameterBlock(packed.frame(static_cast<int>(i)), 6);
    ordering.AddElementToGroup(packed.frame(static_cast<int>(i)), 0);
  }
  for (std::size_t i = 0; i < problem.lenses.size(); ++i) {
    const ProblemLens& lens = problem.lenses[i];
    const int n = lens_parameter_count(lens.shape);
    ceres_problem.AddParameterBlock(packed.lens(i), n);
    ordering.AddElementToGroup(packed.lens(i), 1);
    std::vector<int> constant;
    for (int k = 0; k < n; ++k) {
      if (!stage.free[i][static_cast<std::size_t>(k)]) constant.push_back(k);
    }
    if (static_cast<int>(constant.size()) == n) {
      ceres_problem.SetParameterBlockConstant(packed.lens(i));
    } else if (!constant.empty()) {
      ceres_problem.SetManifold(packed.lens(i), new ceres::SubsetManifold(n, constant));
    }
    if (lens.prior_sigma.array().isFinite().any()) {
      ceres_problem.AddResidualBlock(new BlockPrior(lens.prior_mean, lens.prior_sigma), nullptr,
                                     packed.lens(i));
    }
  }
  for (std::size_t i = 1; i < problem.lens_of_camera.size(); ++i) {
    ceres_problem.AddParameterBlock(packed.camera(i), 6);
    ordering.AddElementToGroup(packed.camera(i), 1);
  }
  if (!problem.config.board_deformation) return;
  ceres_problem.AddParameterBlock(packed.bent(), 2);
  ordering.AddElementToGroup(packed.bent(), 1);
  const double sigma = problem.config.deformation_prior_share;
  if (sigma > 0) {
    ceres_problem.AddResidualBlock(
        new BlockPrior(Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(sigma)), nullptr,
        packed.bent());
  }
}

ceres::Solver::Summary minimise(const CalibrationProblem& problem, const Stage& stage,
                                CalibrationState& state) {
  quiet_warnings();
  PackedState packed(state);
  ceres::Problem ceres_problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  add_blocks(problem, stage, packed, ceres_problem, *ordering);
  for (const ProblemView& view : problem.views) {
    auto cost = std::make_unique<ViewCost>(problem, view, stage.loss);
    if (cost->num_residuals() == 0) continue;
    std::vector<double*> blocks = {
        packed.frame(view.frame),
        packed.lens(static_cast<std::size_t>(
            problem.lens_of_camera[static_cast<std::size_t>(view.camera)]))};
    if (view.camera > 0) blocks.push_back(packed.camera(static_cast<std::size_t>(view.camera)));
    if (problem.config.board_deformation) blocks.push_back(packed.bent());
    ceres_problem.AddResidualBlock(cost.release(), nullptr, blocks);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.num_threads = 1;  // fixed: the sums' order must not depend on the caller's threads
  options.max_num_iterations = stage.max_iterations;
  options.function_tolerance = stage.tolerance;
  options.parameter_tolerance = 1e-15;
  options.gradient_tolerance = 1e-30;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  packed.unpack(state);
  return summary;
}

/// The core, then also the first two radial coefficients or a fisheye's first, then all.
SolverRun solve_staged(const CalibrationProblem& problem, CalibrationState& state, bool from_core) {
  SolverRun run;
  Stage stage;
  stage.loss = problem.config.loss;
  if (problem.config.reject_sigmas > 0 && stage.loss == RobustLoss::none)
    stage.loss = RobustLoss::cauchy;
  for (const ProblemLens& lens : problem.lenses) {
    stage.free.push_back(lens.free);
    const bool splined = lens.shape.model == LensModel::splined_stereographic;
    if (splined && from_core) std::fill_n(stage.free.back().begin(), 4, true);
    for (std::size_t k = splined ? 4 : 6; from_core && k < lens.free.size(); ++k)
      stage.free.back()[k] = false;
  }
  if (from_core) {
    stage.max_iterations = 15;
    run.iterations += static_cast<int>(minimise(problem, stage, state).iterations.size());
  }
  for (std::size_t i = 0; i < problem.lenses.size(); ++i) stage.free[i] = problem.lenses[i].free;
  stage.tolerance = problem.config.tolerance;
  stage.max_iterations = problem.config.max_iterations;
  const ceres::Solver::Summary summary = minimise(problem, stage, state);
  run.iterations += static_cast<int>(summary.iterations.size());
  run.rms_px = std::sqrt(2 * summary.final_cost / std::max(1, 2 * observation_count(problem)));
  run.rms_name = "root of twice Ceres' cost over the coordinates: priors and loss included";
  if (summary.termination_type != ceres::CONVERGENCE) {
    run.status = CalibrationStatus::not_converged;
    run.reason = "Ceres: " + summary.message;
  }
  return run;
}

/// A rig's lenses each alone, from some of their views, so that the joint solution starts near.
void seed_lenses(const CalibrationProblem& problem, CalibrationState& state, SolverRun& run) {
  for (std::size_t i = 0; i < problem.lenses.size(); ++i) {
    Eigen::VectorXd lens = seed_lens(problem, static_cast<int>(i));
    if (problem.lens_of_camera.size() > 1) {
      CalibrationProblem single =
          single_lens_problem(problem, static_cast<int>(i), kSeedViewsPerLens);
      single.config.tolerance = 1e-8;
      CalibrationState alone;
      alone.lenses = {lens};
      assemble_rig(single, seed_view_poses(single, alone.lenses), alone);
      if (!single.views.empty()) {
        run.iterations += solve_staged(single, alone, !problem.lenses[i].given).iterations;
        lens = alone.lenses.front();
      }
    }
    state.lenses.push_back(lens);
  }
}

/// A rational lens from the solution of its plain five coefficients, with poses found anew. All
/// coefficients freed at once may end where poles of the fraction lie beside the image, at eight
/// times the residuals; the lower of both ways is taken.
void solve_by_plain_lens(const CalibrationProblem& problem, const CalibrationState& begin,
                         CalibrationState& state, SolverRun& run) {
  constexpr std::size_t kPlain = 4 + 5;
  CalibrationProblem plain = problem;
  for (std::size_t k = kPlain; k < plain.lenses.front().free.size(); ++k)
    plain.lenses.front().free[k] = false;
  CalibrationState lean = begin;
  SolverRun by_plain = solve_staged(plain, lean, true);
  CalibrationProblem again = problem;
  CalibrationState rich;
  rich.lenses = lean.lenses;
  assemble_rig(again, seed_view_poses(again, rich.lenses), rich);
  if (again.views.size() != problem.views.size()) return;
  const int before = by_plain.iterations + run.iterations;
  by_plain = solve_staged(again, rich, false);
  run.iterations = before + by_plain.iterations;
  if (!(by_plain.rms_px < run.rms_px)) return;
  by_plain.iterations = run.iterations;
  run = by_plain;
  state = std::move(rich);
}

}  // namespace

CalibrationSolver default_calibration_solver() { return CalibrationSolver::ceres; }

SolverRun solve_with_ceres(CalibrationProblem& problem, CalibrationState& state) {
  SolverRun seeded;
  const bool from_start = state.lenses.empty();
  if (from_start) {
    seed_lenses(problem, state, seeded);
    const std::vector<int> alone =
        assemble_rig(problem, seed_view_poses(problem, state.lenses), state);
    if (problem.views.empty()) {
      seeded.status = CalibrationStatus::not_determined;
      seeded.reason = "no view has a pose of the target under any focal length";
      return seeded;
    }
    if (!alone.empty()) {
      seeded.status = CalibrationStatus::not_determined;
      seeded.reason = "cameras that share no frame with the others";
      for (const int c : alone)
        seeded.not_determined.push_back("camera" + std::to_string(c) + ".pose");
      return seeded;
    }
  }
  const bool from_core =
      from_start && problem.lens_of_camera.size() == 1 && !problem.lenses.front().given;
  const CalibrationState begin = state;
  SolverRun run = solve_staged(problem, state, from_core);
  if (from_core && is_rational(problem.lenses.front().shape.model))
    solve_by_plain_lens(problem, begin, state, run);
  run.iterations += seeded.iterations;
  return run;
}

}  // namespace cousin
