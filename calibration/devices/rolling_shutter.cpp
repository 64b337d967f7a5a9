#include "calibration/devices/rolling_shutter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "calibration/devices/rolling_solve.h"
#include "calibration/solve/calibration_judgement.h"
#include "sim/config/limits.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

std::string unsupported(const CalibrationInput& input, const CalibrationConfig& config) {
  if (input.cameras.size() != 1)
    return "a rolling shutter is calibrated one camera at a time; there are " +
           std::to_string(input.cameras.size());
  if (config.loss != RobustLoss::none)
    return "a rolling shutter is calibrated without a robust loss; reject_sigmas is there";
  if (config.board_deformation) return "a rolling shutter is calibrated with a flat board";
  return "";
}

/// Views in the order of time, those without one last, and the gaps between neighbours.
std::string order_by_time(const CalibrationInput& input, const RollingShutterConfig& config,
                          RollingProblem& all, std::vector<Vector6d>& poses) {
  std::vector<ProblemView>& views = all.problem.views;
  const auto time_of = [&](const ProblemView& view) {
    return input.views[static_cast<std::size_t>(view.input_view)].time_s;
  };
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double ta = time_of(views[a]), tb = time_of(views[b]);
    if (!std::isfinite(ta) || !std::isfinite(tb)) return std::isfinite(ta) && !std::isfinite(tb);
    return ta < tb;
  });
  std::vector<ProblemView> sorted;
  std::vector<Vector6d> sorted_poses;
  for (const std::size_t i : order) {
    sorted.push_back(views[i]);
    sorted_poses.push_back(poses[static_cast<std::size_t>(views[i].frame)]);
  }
  views = std::move(sorted);
  poses = std::move(sorted_poses);
  all.gap_s.assign(views.size() > 1 ? views.size() - 1 : 0, 0);
  for (std::size_t v = 0; v + 1 < views.size(); ++v) {
    const double gap = time_of(views[v + 1]) - time_of(views[v]);
    if (gap == 0)
      return "view " + std::to_string(views[v].input_view) + " and view " +
             std::to_string(views[v + 1].input_view) + " have the same time";
    if (std::isfinite(gap) && gap <= config.max_gap_s) all.gap_s[v] = gap;
  }
  return "";
}

/// Everything but the start.
RollingProblem rolling_problem(CalibrationProblem problem, const RollingShutterConfig& config) {
  RollingProblem all;
  all.problem = std::move(problem);
  const double rows = std::max(1, all.problem.lenses.front().like.height_px - 1);
  const double unit = all.problem.unit_m;
  const double readout_s = config.readout_s > 0 ? config.readout_s : config.usual_readout_s;
  all.reference_delay_s = readout_s / rows;
  // A motion over the readout is what is held about zero: with a known readout, its velocity.
  all.velocity_sigma << Eigen::Vector3d::Constant(config.rate_rad_per_s),
      Eigen::Vector3d::Constant(config.speed_m_per_s / unit);
  all.velocity_sigma *= config.usual_readout_s / readout_s;
  all.acceleration_sigma << Eigen::Vector3d::Constant(config.turn_acceleration_rad_per_s2),
      Eigen::Vector3d::Constant(config.acceleration_m_per_s2 / unit);
  return all;
}

/// Velocities as differences of the poses, where there are neighbours.
RollingState start_of(const RollingProblem& all, const Eigen::VectorXd& lens,
                      const std::vector<Vector6d>& poses) {
  RollingState state;
  state.lens = lens;
  for (const Vector6d& pose : poses) state.poses.push_back(pose_of_vector(pose));
  state.velocities.assign(poses.size(), Vector6d::Zero());
  for (std::size_t v = 0; v < poses.size(); ++v) {
    const std::size_t from = v > 0 && all.gap_s[v - 1] > 0 ? v - 1 : v;
    const std::size_t to = v < all.gap_s.size() && all.gap_s[v] > 0 ? v + 1 : v;
    if (from == to) continue;
    double gap = 0;
    for (std::size_t i = from; i < to; ++i) gap += all.gap_s[i];
    const Pose &a = state.poses[from], &b = state.poses[to];
    state.velocities[v] =
        pose_vector({b.rotation * a.rotation.conjugate(), b.translation_m - a.translation_m}) / gap;
  }
  return state;
}

void describe(const RollingProblem& all, const RollingState& state,
              const RollingCovariance& covariance, const CalibrationInput& input,
              RollingShutterResult& result) {
  CalibrationResult& c = result.calibration;
  const double unit = all.problem.unit_m;
  const double rows = std::max(1, all.problem.lenses.front().like.height_px - 1);
  c.cameras = {with_parameters(all.problem.lenses.front().like, state.lens)};
  c.camera_from_rig = {Pose{}};
  c.frames.clear();
  c.residuals.clear();
  c.rejected = 0;
  double squares = 0;
  for (std::size_t v = 0; v < state.poses.size(); ++v) {
    const ProblemView& view = all.problem.views[v];
    Pose pose = state.poses[v];
    pose.translation_m = unit * pose.translation_m - pose.rotation * all.problem.centre_m;
    c.frames.push_back({input.views[static_cast<std::size_t>(view.input_view)].frame, pose});
    Vector6d motion = delay_of(all, state, v) * rows * state.velocities[v];
    motion.tail<3>() *= unit;
    result.views.push_back({view.input_view, has_neighbour(all, v), motion});
    const std::vector<Eigen::Vector2d> residuals = rolling_residuals(all, state, v);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const ProblemPoint& p = view.points[i];
      c.residuals.push_back({view.input_view, p.id, residuals[i], p.rejected});
      c.rejected += p.rejected ? 1 : 0;
      if (!p.rejected) squares += residuals[i].squaredNorm();
    }
  }
  std::sort(c.frames.begin(), c.frames.end(),
            [](const auto& a, const auto& b) { return a.frame < b.frame; });
  // What the start's solver said is of another model.
  c.solver_deviations.resize(0);
  c.corrected_deviations.resize(0);
  c.solver_rms_px = std::numeric_limits<double>::quiet_NaN();
  c.solver_rms_name.clear();
  c.observations = observation_count(all.problem);
  c.rms_px = std::sqrt(squares / (2.0 * c.observations));
  describe_noise(all.problem, all.noise, c);
  c.parameters = rolling_names(all);
  c.values.resize(static_cast<Eigen::Index>(c.parameters.size()));
  Eigen::Index at = 0;
  for (std::size_t k = 0; k < all.problem.lenses.front().free.size(); ++k) {
    if (all.problem.lenses.front().free[k])
      c.values(at++) = state.lens(static_cast<Eigen::Index>(k));
  }
  if (all.delay_is_free) c.values(at) = state.delay_s;
  c.covariance = covariance.shared.covariance;
  Vector6d twist_unit;
  twist_unit << 1, 1, 1, unit, unit, unit;
  c.mean_frame_gain = twist_unit.asDiagonal() * covariance.mean_frame_gain;
  c.mean_frame_covariance =
      twist_unit.asDiagonal() * covariance.mean_frame_covariance * twist_unit.asDiagonal();
  c.not_determined = covariance.shared.not_determined;
  if (!c.not_determined.empty()) c.reason = "the views do not fix these parameters";
}

/// The line delay, or why there is none.
void judge_delay(const RollingProblem& all, const RollingState& state,
                 const RollingShutterConfig& config, RollingShutterResult& result) {
  CalibrationResult& c = result.calibration;
  const double rows = std::max(1, all.problem.lenses.front().like.height_px - 1);
  std::ostringstream why;
  if (config.readout_s > 0) {
    result.line_delay_s = config.readout_s / rows;
    return;
  }
  if (!all.delay_is_free) {
    why << "no two views have time stamps at most " << config.max_gap_s
        << " s apart: single pictures tell the product of line delay and velocity only";
  } else {
    const double sigma_s = rows * deviation(c, kLineDelay);
    if (sigma_s <= config.max_readout_deviation_s && c.not_determined.empty()) {
      result.line_delay_s = state.delay_s;
      return;
    }
    why << "the readout has a deviation of " << sigma_s << " s (at most "
        << config.max_readout_deviation_s << "): the camera hardly moves, or too little between "
        << "neighbouring views";
  }
  if (std::find(c.not_determined.begin(), c.not_determined.end(), kLineDelay) ==
      c.not_determined.end())
    c.not_determined.emplace_back(kLineDelay);
  c.status = CalibrationStatus::not_determined;
  if (c.reason.empty()) c.reason = why.str();
}

/// As if all rows were read at once, outliers held back by a loss.
CalibrationConfig all_rows_at_once(const CalibrationConfig& calibration) {
  CalibrationConfig start = calibration;
  start.reject_sigmas = 0;
  if (calibration.reject_sigmas > 0 && start.solver == CalibrationSolver::ceres)
    start.loss = RobustLoss::cauchy;
  return start;
}

/// The start's poses in the problem's units; views of frames without one are left out.
std::vector<Vector6d> take_start_poses(const CalibrationResult& start, RollingProblem& all) {
  std::vector<Vector6d> poses(all.problem.frames.size());
  std::vector<bool> known(poses.size(), false);
  for (const CalibrationFrame& f : start.frames) {
    const auto at = std::find(all.problem.frames.begin(), all.problem.frames.end(), f.frame);
    const auto i = static_cast<std::size_t>(at - all.problem.frames.begin());
    Pose pose = f.rig_from_target;
    pose.translation_m = (pose * all.problem.centre_m) / all.problem.unit_m;
    poses[i] = pose_vector(pose);
    known[i] = true;
  }
  std::erase_if(all.problem.views, [&](const ProblemView& view) {
    return !known[static_cast<std::size_t>(view.frame)];
  });
  return poses;
}

/// Names neighbours of one frame; empty if there are none.
std::string views_of_one_frame(const std::vector<ProblemView>& views) {
  for (std::size_t v = 1; v < views.size(); ++v) {
    if (views[v].frame == views[v - 1].frame)
      return "views " + std::to_string(views[v - 1].input_view) + " and " +
             std::to_string(views[v].input_view) + " are of one frame";
  }
  return "";
}

}  // namespace

Fields fields(RollingShutterConfig& c) {
  return {
      {"readout_s", &c.readout_s, "known, first row to last; 0 = solve for it", 0, 10},
      {"speed_m_per_s", &c.speed_m_per_s, "deviation of a lone view's speed", 1e-9, 1e6},
      {"rate_rad_per_s", &c.rate_rad_per_s, "deviation of a lone view's turning", 1e-9, 1e6},
      {"usual_readout_s", &c.usual_readout_s, "for which these two are meant", 1e-6, 10},
      {"acceleration_m_per_s2", &c.acceleration_m_per_s2,
       "deviation, a step between neighbours in time", 1e-9, 1e6},
      {"turn_acceleration_rad_per_s2", &c.turn_acceleration_rad_per_s2, "the same of turning", 1e-9,
       1e6},
      {"max_gap_s", &c.max_gap_s, "between time stamps of neighbours", 1e-6, 10},
      {"max_readout_deviation_s", &c.max_readout_deviation_s,
       "above it the line delay is not determined", 1e-9, 10},
  };
}

void validate(const RollingShutterConfig& config) {
  RollingShutterConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy));
}

RollingShutterResult calibrate_rolling_shutter(const CalibrationInput& input,
                                               const CalibrationConfig& calibration,
                                               const RollingShutterConfig& config) {
  validate(config);
  validate(calibration);
  const StageClock clock("calibrate_rolling_shutter");
  RollingShutterResult result;
  CalibrationResult& c = result.calibration;
  const auto refuse = [&](CalibrationStatus status, const std::string& reason) {
    c.status = status;
    c.reason = reason;
    c.seconds = clock.finish().wall_s;
    return result;
  };
  const std::string unable = unsupported(input, calibration);
  if (!unable.empty()) return refuse(CalibrationStatus::bad_input, unable);

  c = calibrate(input, all_rows_at_once(calibration));
  if (c.cameras.empty() || c.frames.empty()) return result;

  std::string complaint;
  RollingProblem all = rolling_problem(make_problem(input, calibration, complaint), config);
  std::vector<Vector6d> poses = take_start_poses(c, all);
  complaint = views_of_one_frame(all.problem.views);
  if (complaint.empty()) complaint = order_by_time(input, config, all, poses);
  if (!complaint.empty()) return refuse(CalibrationStatus::bad_input, complaint);
  result.neighbours = static_cast<int>(
      std::count_if(all.gap_s.begin(), all.gap_s.end(), [](double gap) { return gap > 0; }));
  all.delay_is_free = config.readout_s == 0 && result.neighbours > 0;

  RollingState state = start_of(all, lens_parameters(c.cameras.front()), poses);
  // What the start leaves, in the corners' own deviations: much less would let velocities wander
  // as if nothing tied them, along a valley of delays.
  const RollingSystem start_system = rolling_system(all, state);
  const double start_noise = std::sqrt(start_system.squares / start_system.coordinates);
  if (start_noise > 0 && std::isfinite(start_noise)) all.noise = start_noise;
  RollingCovariance covariance;
  c.status = CalibrationStatus::ok;
  c.reason.clear();
  c.not_determined.clear();
  complaint = solve_rolling(all, state, covariance, c.iterations, c.cost_px2);
  if (!complaint.empty() && all.delay_is_free) {
    // A camera that hardly moves leaves a valley: any delay, and the velocities that go with it.
    c.not_determined = {kLineDelay};
    return refuse(CalibrationStatus::not_determined,
                  complaint + " while the line delay is free: is there motion between neighbours?");
  }
  if (!complaint.empty()) return refuse(CalibrationStatus::not_converged, complaint);
  describe(all, state, covariance, input, result);
  judge_calibration(input, calibration, c);
  judge_delay(all, state, config, result);
  c.seconds = clock.finish().wall_s;
  return result;
}

}  // namespace cousin
