#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "calibration/calibration_seed.h"
#include "calibration/calibration_solvers.h"

extern "C" {
#include <mrcal/mrcal.h>
}

namespace cousin {
namespace {

SolverRun refuse(const std::string& reason) {
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
  std::vector<double> intrinsics;
  std::vector<mrcal_pose_t> frames;
  mrcal_calobject_warp_t warp{};
  std::vector<mrcal_observation_board_t> boards;
  std::vector<mrcal_point3_t> pool;
  int image_size[2] = {0, 0};

  mrcal_stats_t optimise(const mrcal_problem_selections_t& what) {
    const mrcal_problem_constants_t constants{1e-3, 1e9};
    return mrcal_optimize(nullptr, 0, nullptr, 0, intrinsics.data(), nullptr, frames.data(),
                          nullptr, &warp, 1, 0, static_cast<int>(frames.size()), 0, 0,
                          boards.data(), nullptr, static_cast<int>(boards.size()), 0, pool.data(),
                          &model, image_size, what, &constants, lattice.spacing, lattice.columns,
                          lattice.rows, false, false);
  }
};

void add_views(const CalibrationProblem& problem, const CalibrationState& state,
               MrcalProblem& mrcal) {
  const Lattice& lattice = mrcal.lattice;
  const Pose target_from_lattice{Eigen::Quaterniond::Identity(),
                                 {lattice.first.x(), lattice.first.y(), 0}};
  const auto cells = static_cast<std::size_t>(lattice.columns * lattice.rows);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    const ProblemView& view = problem.views[v];
    mrcal.frames.push_back(pose_to(
        pose_of_vector(state.frames[static_cast<std::size_t>(view.frame)]) * target_from_lattice));
    mrcal.boards.push_back({{0, -1}, static_cast<int>(v)});
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
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    state.frames[v] = pose_vector(pose_from(mrcal.frames[v]) * lattice_from_target);
    for (ProblemPoint& p : problem.views[v].points) {
      const auto cell = static_cast<std::size_t>(lattice.cell[static_cast<std::size_t>(p.id)]);
      p.rejected = mrcal.pool[v * cells + cell].z < 0;
    }
  }
  const auto n = static_cast<Eigen::Index>(mrcal.intrinsics.size());
  state.lenses.front().head(n) = Eigen::Map<const Eigen::VectorXd>(mrcal.intrinsics.data(), n);
  state.deformation = {mrcal.warp.x2, mrcal.warp.y2};
}

std::string unsupported(const CalibrationProblem& problem) {
  const CalibrationConfig& config = problem.config;
  if (problem.lens_of_camera.size() != 1) return "one camera at a time";
  if (config.weigh_by_covariance) return "observations are not weighed by a covariance";
  if (config.loss != RobustLoss::none) return "it has no robust loss";
  if (config.focal_prior_share + config.centre_prior_px + config.distortion_prior +
          config.deformation_prior_share >
      0)
    return "it has no priors of one's own";
  return "";
}

}  // namespace

SolverRun solve_with_mrcal(CalibrationProblem& problem, CalibrationState& state) {
  std::string unable = unsupported(problem);
  MrcalProblem mrcal;
  const std::optional<Lattice> lattice = lattice_of(problem);
  if (unable.empty() && !lattice) unable = "its target is a full square lattice of points";
  const std::string name = mrcal_name(problem.lenses.front(), unable);
  if (!unable.empty()) return refuse(unable);
  if (!mrcal_lensmodel_from_name(&mrcal.model, name.c_str())) return refuse("no lens " + name);
  mrcal.lattice = *lattice;

  // mrcal 2.2 has no seeding in C: our lens without distortion and our poses.
  state.lenses = {seed_lens(problem, 0)};
  assemble_rig(problem, seed_view_poses(problem, state.lenses), state);
  SolverRun run;
  if (problem.views.size() != problem.frames.size()) return refuse("two views of one frame");
  if (problem.views.empty()) {
    run.status = CalibrationStatus::not_determined;
    run.reason = "no view has a pose of the target under any focal length";
    return run;
  }
  const Camera& like = problem.lenses.front().like;
  mrcal.image_size[0] = like.width_px;
  mrcal.image_size[1] = like.height_px;
  const auto count = static_cast<std::size_t>(mrcal_lensmodel_num_params(&mrcal.model));
  mrcal.intrinsics.assign(state.lenses.front().data(), state.lenses.front().data() + count);
  add_views(problem, state, mrcal);

  const bool splined = problem.lenses.front().shape.model == LensModel::splined_stereographic;
  mrcal_problem_selections_t what{};
  what.do_optimize_intrinsics_core = true;
  what.do_optimize_frames = true;
  mrcal_stats_t stats = mrcal.optimise(what);
  what.do_optimize_intrinsics_core = !splined;
  what.do_optimize_intrinsics_distortions = count > 4;
  what.do_apply_regularization = splined;  // else its unseen control points are singular
  what.do_optimize_calobject_warp = problem.config.board_deformation;
  what.do_apply_outlier_rejection = problem.config.reject_sigmas > 0;
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

}  // namespace cousin
