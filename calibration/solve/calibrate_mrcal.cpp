#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "calibration/solve/calibration_seed.h"
#include "calibration/solve/calibration_solvers.h"

extern "C" {
#include <mrcal/mrcal.h>
}

namespace cousin {
namespace {

SolverRun refuse_mrcal(const std::string& reason) {
  SolverRun run;
  run.status = CalibrationStatus::bad_input;
  run.reason = "mrcal: " + reason;
  return run;
}

/// The target as mrcal wants it: a full square lattice from (0, 0).
struct Lattice {
  int columns = 0, rows = 0;
  double spacing = 0;
  Eigen::Vector2d first;  ///< of the lattice, in the problem's target frame
  std::vector<int> cell;  ///< row * columns + column of each id
};

std::optional<Lattice> lattice_of(const CalibrationProblem& problem) {
  Lattice lattice;
  Eigen::Vector2d low = problem.target.front().head<2>(), high = low;
  double spacing = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d& first = problem.target.front();
  for (const Eigen::Vector3d& p : problem.target) {
    if (std::abs(p.z()) > 1e-9) return std::nullopt;
    low = low.cwiseMin(p.head<2>());
    high = high.cwiseMax(p.head<2>());
    const double step = (p - first).norm();
    if (step > 1e-9) spacing = std::min(spacing, step);
  }
  const Eigen::Vector2d extent = (high - low) / spacing;
  if (!(extent.maxCoeff() < 1000)) return std::nullopt;
  lattice.columns = static_cast<int>(std::lround(extent.x())) + 1;
  lattice.rows = static_cast<int>(std::lround(extent.y())) + 1;
  if (lattice.columns < 2 || lattice.rows < 2) return std::nullopt;
  lattice.spacing = (high.x() - low.x()) / (lattice.columns - 1);
  lattice.first = low;
  for (const Eigen::Vector3d& p : problem.target) {
    const Eigen::Vector2d at = (p.head<2>() - low) / lattice.spacing;
    const Eigen::Vector2d cell(std::round(at.x()), std::round(at.y()));
    if ((at - cell).norm() > 1e-6) return std::nullopt;
    lattice.cell.push_back(static_cast<int>(cell.y()) * lattice.columns +
                           static_cast<int>(cell.x()));
  }
  return lattice;
}

/// mrcal's name of the lens; an explanation in `unable` where it has none.
std::string mrcal_name(const ProblemLens& lens, std::string& unable) {
  const auto fixed_from = [&](std::size_t from) {
    return std::count(lens.free.begin() + static_cast<std::ptrdiff_t>(from), lens.free.end(),
                      false);
  };
  switch (lens.shape.model) {
    case LensModel::pinhole:
      return "LENSMODEL_PINHOLE";
    case LensModel::opencv5:
      if (!lens.free[8] && fixed_from(4) == 1 && lens.prior_mean(8) == 0)
        return "LENSMODEL_OPENCV4";
      if (fixed_from(0) > 0) unable = "it can fix k3 at 0, and no other parameter";
      return "LENSMODEL_OPENCV5";
    case LensModel::opencv8:
      if (fixed_from(0) > 0) unable = "it fixes all distortion or none";
      return "LENSMODEL_OPENCV8";
    case LensModel::opencv12:
      if (fixed_from(0) > 0) unable = "it fixes all distortion or none";
      return "LENSMODEL_OPENCV12";
    case LensModel::splined_stereographic: {
      const double degrees = lens.shape.grid.fov_x_rad * 180 / std::numbers::pi;
      if (std::abs(degrees - std::round(degrees)) > 1e-9)
        unable = "the field of view of its splines is of whole degrees";
      return "LENSMODEL_SPLINED_STEREOGRAPHIC_order=" + std::to_string(lens.shape.grid.order) +
             "_Nx=" + std::to_string(lens.shape.grid.columns) +
             "_Ny=" + std::to_string(lens.shape.grid.rows) +
             "_fov_x_deg=" + std::to_string(std::lround(degrees));
    }
    case LensModel::kannala_brandt4:
      break;
  }
  unable = "it has no kannala_brandt4 lens";
  return {};
}

mrcal_pose_t pose_to(const Pose& pose) {
  const Vector6d v = pose_vector(pose);
  return {{{v(0), v(1), v(2)}}, {{v(3), v(4), v(5)}}};
}

Pose pose_from(const mrcal_pose_t& pose) {
  Vector6d v;
  v << pose.r.x, pose.r.y, pose.r.z, pose.t.x, pose.t.y, pose.t.z;
  return pose_of_vector(v);
}

/// Everything that mrcal_optimize reads and writes.
struct MrcalProblem {
  mrcal_lensmodel_t model{};
  Lattice lattice;
  std::vector<double> intrinsics;        ///< lens by lens
  std::vector<mrcal_pose_t> extrinsics;  ///< of cameras 1..
  std::vector<mrcal_pose_t> frames;
  mrcal_calobject_warp_t warp{};
  std::vector<mrcal_observation_board_t> boards;
  std::vector<mrcal_point3_t> pool;
  std::vector<int> image_sizes;    ///< width, height of each lens
  std::vector<std::size_t> order;  ///< of the problem's views: by frame, then camera

  mrcal_stats_t optimise(const mrcal_problem_selections_t& what) {
    const mrcal_problem_constants_t constants{1e-3, 1e9};
    return mrcal_optimize(nullptr, 0, nullptr, 0, intrinsics.data(), extrinsics.data(),
                          frames.data(), nullptr, &warp, static_cast<int>(image_sizes.size() / 2),
                          static_cast<int>(extrinsics.size()), static_cast<int>(frames.size()), 0,
                          0, boards.data(), nullptr, static_cast<int>(boards.size()), 0,
                          pool.data(), &model, image_sizes.data(), what, &constants,
                          lattice.spacing, lattice.columns, lattice.rows, false, false);
  }
};

void add_views(const CalibrationProblem& problem, const CalibrationState& state,
               MrcalProblem& mrcal) {
  const Lattice& lattice = mrcal.lattice;
  const Pose target_from_lattice{Eigen::Quaterniond::Identity(),
                                 {lattice.first.x(), lattice.first.y(), 0}};
  const auto cells = static_cast<std::size_t>(lattice.columns * lattice.rows);
  for (const Vector6d& frame : state.frames)
    mrcal.frames.push_back(pose_to(pose_of_vector(frame) * target_from_lattice));
  for (std::size_t c = 1; c < state.cameras.size(); ++c)
    mrcal.extrinsics.push_back(pose_to(pose_of_vector(state.cameras[c])));
  mrcal.order.resize(problem.views.size());
  std::iota(mrcal.order.begin(), mrcal.order.end(), std::size_t{0});
  std::sort(mrcal.order.begin(), mrcal.order.end(), [&](std::size_t a, std::size_t b) {
    const ProblemView &x = problem.views[a], &y = problem.views[b];
    return x.frame != y.frame ? x.frame < y.frame : x.camera < y.camera;
  });
  for (const std::size_t v : mrcal.order) {
    const ProblemView& view = problem.views[v];
    mrcal.boards.push_back(
        {{problem.lens_of_camera[static_cast<std::size_t>(view.camera)], view.camera - 1},
         view.frame});
    const std::size_t from = mrcal.pool.size();
    mrcal.pool.resize(from + cells, mrcal_point3_t{{0, 0, -1}});
    for (const ProblemPoint& p : view.points) {
      const auto cell = static_cast<std::size_t>(lattice.cell[static_cast<std::size_t>(p.id)]);
      mrcal.pool[from + cell] = {{p.pixel_px.x(), p.pixel_px.y(), p.rejected ? -1.0 : 1.0}};
    }
  }
}

void take_views(CalibrationProblem& problem, CalibrationState& state, const MrcalProblem& mrcal) {
  const Lattice& lattice = mrcal.lattice;
  const Pose lattice_from_target{Eigen::Quaterniond::Identity(),
                                 {-lattice.first.x(), -lattice.first.y(), 0}};
  const auto cells = static_cast<std::size_t>(lattice.columns * lattice.rows);
  for (std::size_t f = 0; f < state.frames.size(); ++f)
    state.frames[f] = pose_vector(pose_from(mrcal.frames[f]) * lattice_from_target);
  for (std::size_t c = 1; c < state.cameras.size(); ++c)
    state.cameras[c] = pose_vector(pose_from(mrcal.extrinsics[c - 1]));
  for (std::size_t i = 0; i < mrcal.order.size(); ++i) {
    for (ProblemPoint& p : problem.views[mrcal.order[i]].points) {
      const auto cell = static_cast<std::size_t>(lattice.cell[static_cast<std::size_t>(p.id)]);
      p.rejected = mrcal.pool[i * cells + cell].z < 0;
    }
  }
  const auto n = static_cast<Eigen::Index>(mrcal.intrinsics.size() / state.lenses.size());
  for (std::size_t i = 0; i < state.lenses.size(); ++i)
    state.lenses[i].head(n) = Eigen::Map<const Eigen::VectorXd>(
        mrcal.intrinsics.data() + static_cast<Eigen::Index>(i) * n, n);
  state.deformation = {mrcal.warp.x2, mrcal.warp.y2};
}

std::string unsupported(const CalibrationProblem& problem) {
  const CalibrationConfig& config = problem.config;
  for (const ProblemLens& lens : problem.lenses) {
    const LensShape &a = lens.shape, &b = problem.lenses.front().shape;
    const SplineLens &p = a.grid, &q = b.grid;
    if (a.model != b.model || p.order != q.order || p.columns != q.columns || p.rows != q.rows ||
        p.fov_x_rad != q.fov_x_rad)
      return "all its cameras have one lens model";
  }
  if (config.weigh_by_covariance) return "observations are not weighed by a covariance";
  if (config.loss != RobustLoss::none) return "it has no robust loss";
  if (config.focal_prior_share + config.centre_prior_px + config.distortion_prior +
          config.deformation_prior_share >
      0)
    return "it has no priors of one's own";
  return "";
}

/// From a state's lenses and poses to a minimum, with mrcal's own outlier pass if that is asked
/// for.
SolverRun optimise_from(CalibrationProblem& problem, const Lattice& lattice,
                        const std::string& model, CalibrationState& state) {
  MrcalProblem mrcal;
  if (!mrcal_lensmodel_from_name(&mrcal.model, model.c_str()))
    return refuse_mrcal("no lens " + model);
  mrcal.lattice = lattice;
  const auto count = static_cast<Eigen::Index>(mrcal_lensmodel_num_params(&mrcal.model));
  for (std::size_t i = 0; i < problem.lenses.size(); ++i) {
    const Camera& like = problem.lenses[i].like;
    mrcal.image_sizes.insert(mrcal.image_sizes.end(), {like.width_px, like.height_px});
    mrcal.intrinsics.insert(mrcal.intrinsics.end(), state.lenses[i].data(),
                            state.lenses[i].data() + count);
  }
  add_views(problem, state, mrcal);

  const bool splined = problem.lenses.front().shape.model == LensModel::splined_stereographic;
  mrcal_problem_selections_t what{};
  what.do_optimize_intrinsics_core = true;
  what.do_optimize_frames = true;
  what.do_optimize_extrinsics = !mrcal.extrinsics.empty();
  mrcal_stats_t stats = mrcal.optimise(what);
  what.do_optimize_intrinsics_core = !splined;
  what.do_optimize_intrinsics_distortions = count > 4;
  what.do_apply_regularization = splined;  // else its unseen control points are singular
  what.do_optimize_calobject_warp = problem.config.board_deformation;
  what.do_apply_outlier_rejection = problem.config.reject_sigmas > 0;
  SolverRun run;
  // It stops early by its own limits, which its C API does not give out: again from where it is.
  constexpr int kRestarts = 10;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRestarts && stats.rms_reproj_error__pixels >= 0; ++i) {
    stats = mrcal.optimise(what);
    ++run.iterations;
    if (!(stats.rms_reproj_error__pixels < before * (1 - 1e-13))) break;
    before = stats.rms_reproj_error__pixels;
  }
  run.rms_px = stats.rms_reproj_error__pixels;
  run.rms_name = "mrcal_optimize: as mrcal gives it";
  if (!(stats.rms_reproj_error__pixels >= 0)) {
    run.status = CalibrationStatus::not_converged;
    run.reason = "mrcal: the optimisation failed";
  }
  take_views(problem, state, mrcal);
  return run;
}

/// As calibrate_ceres does: from the plain coefficients' solution too, with poses found anew; the
/// lower of both.
void optimise_by_plain_lens(const CalibrationProblem& unsolved, const Lattice& lattice,
                            const std::string& model, const CalibrationState& begin,
                            CalibrationProblem& problem, CalibrationState& state, SolverRun& run) {
  CalibrationProblem again = unsolved;
  CalibrationState lean = begin;
  const SolverRun plain = optimise_from(again, lattice, "LENSMODEL_OPENCV5", lean);
  again = unsolved;
  CalibrationState rich;
  rich.lenses = lean.lenses;
  assemble_rig(again, seed_view_poses(again, rich.lenses), rich);
  if (again.views.size() != unsolved.views.size()) return;
  SolverRun found = optimise_from(again, lattice, model, rich);
  found.iterations += plain.iterations + run.iterations;
  run.iterations = found.iterations;
  if (found.status != run.status || !(found.rms_px < run.rms_px)) return;
  run = found;
  state = std::move(rich);
  problem = std::move(again);
}

}  // namespace

SolverRun solve_with_mrcal(CalibrationProblem& problem, CalibrationState& state) {
  std::string unable = unsupported(problem);
  const std::optional<Lattice> lattice = lattice_of(problem);
  if (unable.empty() && !lattice) unable = "its target is a full square lattice of points";
  const std::string name = mrcal_name(problem.lenses.front(), unable);
  if (!unable.empty()) return refuse_mrcal(unable);

  // mrcal 2.2 has no seeding in C: our lenses without distortion and our poses.
  state = {};
  for (std::size_t i = 0; i < problem.lenses.size(); ++i)
    state.lenses.push_back(seed_lens(problem, static_cast<int>(i)));
  const std::vector<int> alone =
      assemble_rig(problem, seed_view_poses(problem, state.lenses), state);
  SolverRun run;
  if (problem.views.empty() || !alone.empty()) {
    run.status = CalibrationStatus::not_determined;
    run.reason = problem.views.empty() ? "no view has a pose of the target under any focal length"
                                       : "cameras that share no frame with the others";
    for (const int c : alone) run.not_determined.push_back("camera" + std::to_string(c) + ".pose");
    return run;
  }
  for (std::size_t v = 1; v < problem.views.size(); ++v) {
    if (problem.views[v].frame == problem.views[v - 1].frame &&
        problem.views[v].camera == problem.views[v - 1].camera)
      return refuse_mrcal("two views of one frame");
  }
  const CalibrationProblem unsolved = problem;
  const CalibrationState begin = state;
  run = optimise_from(problem, *lattice, name, state);
  const ProblemLens& lens = problem.lenses.front();
  if (problem.lens_of_camera.size() == 1 && !lens.given && is_rational(lens.shape.model))
    optimise_by_plain_lens(unsolved, *lattice, name, begin, problem, state, run);
  return run;
}

}  // namespace cousin
