#include "calibration/solve/calibrate.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "calibration/solve/calibration_covariance.h"
#include "calibration/solve/calibration_judgement.h"
#include "calibration/solve/calibration_problem.h"
#include "calibration/solve/calibration_solvers.h"
#include "calibration/solve/normal_mad.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr int kMostPasses = 20;

SolverRun run_solver(CalibrationProblem& problem, CalibrationState& state) {
  switch (problem.config.solver) {
    case CalibrationSolver::opencv:
      return solve_with_opencv(problem, state);
    case CalibrationSolver::mrcal:
      return solve_with_mrcal(problem, state);
    case CalibrationSolver::ceres:
      break;
  }
  return solve_with_ceres(problem, state);
}

/// Marks observations beyond `reject_sigmas` robust deviations. @return how many are new
int reject(CalibrationProblem& problem, const CalibrationState& state) {
  std::vector<double> sizes;
  std::vector<std::vector<Eigen::Vector2d>> all;
  for (const ProblemView& view : problem.views) {
    all.push_back(residuals_of(problem, state, view));
    for (std::size_t i = 0; i < view.points.size(); ++i) {
      all.back()[i] = view.points[i].white * all.back()[i];
      if (view.points[i].rejected || !all.back()[i].allFinite()) continue;
      sizes.push_back(std::abs(all.back()[i].x()));
      sizes.push_back(std::abs(all.back()[i].y()));
    }
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double limit = problem.config.reject_sigmas * kNormalMad * *middle;
  int rejected = 0;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    for (std::size_t i = 0; i < problem.views[v].points.size(); ++i) {
      ProblemPoint& p = problem.views[v].points[i];
      if (p.rejected || all[v][i].cwiseAbs().maxCoeff() <= limit) continue;
      p.rejected = true;
      ++rejected;
    }
  }
  return rejected;
}

/// Views that keep fewer than four points are dropped, and frames without views.
void drop_emptied(CalibrationProblem& problem, CalibrationState& state) {
  std::erase_if(problem.views, [](const ProblemView& view) {
    return std::count_if(view.points.begin(), view.points.end(),
                         [](const ProblemPoint& p) { return !p.rejected; }) < 4;
  });
  std::vector<int> numbers;
  std::vector<Vector6d> frames;
  int last = -1;
  for (ProblemView& view : problem.views) {
    const int frame = view.frame;
    if (frame != last) {
      numbers.push_back(problem.frames[static_cast<std::size_t>(frame)]);
      frames.push_back(state.frames[static_cast<std::size_t>(frame)]);
      last = frame;
    }
    view.frame = static_cast<int>(numbers.size()) - 1;
  }
  problem.frames = std::move(numbers);
  state.frames = std::move(frames);
}

/// Two Gauss-Newton steps from where Ceres stopped: the cost is flat to rounding within 1e-7 of a
/// deviation of its minimum, the normal equations are not. Kept unless the cost says otherwise.
void polish(const CalibrationProblem& problem, CalibrationState& state) {
  constexpr double kFlat = 1e-9;
  for (int i = 0; i < 2; ++i) {
    const SharedSystem system = shared_system(problem, state);
    const SharedCovariance inverse = invert(system);
    if (!inverse.not_determined.empty()) return;
    const CalibrationState next = gauss_newton_step(problem, state, system, inverse);
    if (!(shared_system(problem, next).cost <= (1 + kFlat) * system.cost)) return;
    state = next;
  }
}

/// Residuals that count and are far off by all others' measure.
int count_outliers(const std::vector<CalibrationResidual>& residuals) {
  constexpr double kSigmas = 10, kLeast_px = 0.1;
  std::vector<double> sizes;
  for (const CalibrationResidual& r : residuals) {
    if (r.rejected || !r.residual_px.allFinite()) continue;
    sizes.push_back(std::abs(r.residual_px.x()));
    sizes.push_back(std::abs(r.residual_px.y()));
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double limit = std::max(kSigmas * kNormalMad * *middle, kLeast_px);
  return static_cast<int>(std::count_if(residuals.begin(), residuals.end(), [&](const auto& r) {
    return !r.rejected && !(r.residual_px.cwiseAbs().maxCoeff() <= limit);
  }));
}

void describe_residuals(const CalibrationProblem& problem, const CalibrationState& state,
                        CalibrationResult& result) {
  double squares = 0;
  for (const ProblemView& view : problem.views) {
    const std::vector<Eigen::Vector2d> residuals = residuals_of(problem, state, view);
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      const ProblemPoint& p = view.points[i];
      result.residuals.push_back({view.input_view, p.id, residuals[i], p.rejected});
      result.rejected += p.rejected ? 1 : 0;
      if (!p.rejected) squares += residuals[i].squaredNorm();
    }
  }
  result.observations = observation_count(problem);
  result.outliers = count_outliers(result.residuals);
  result.rms_px = std::sqrt(squares / (2.0 * result.observations));
}

void describe_state(const CalibrationProblem& problem, const CalibrationState& state,
                    const CalibrationInput& input, CalibrationResult& result) {
  for (std::size_t c = 0; c < problem.lens_of_camera.size(); ++c) {
    const auto lens = static_cast<std::size_t>(problem.lens_of_camera[c]);
    Camera camera = with_parameters(problem.lenses[lens].like, state.lenses[lens]);
    camera.width_px = input.cameras[c].start.width_px;
    camera.height_px = input.cameras[c].start.height_px;
    result.cameras.push_back(camera);
    Pose pose = pose_of_vector(state.cameras[c]);
    pose.translation_m *= problem.unit_m;
    result.camera_from_rig.push_back(pose);
  }
  for (std::size_t f = 0; f < problem.frames.size(); ++f) {
    Pose pose = pose_of_vector(state.frames[f]);
    pose.translation_m = problem.unit_m * pose.translation_m - pose.rotation * problem.centre_m;
    result.frames.push_back({problem.frames[f], pose});
  }
  result.deformation_m = problem.unit_m * state.deformation;
}

/// Covariance, and what it and rounding leave undetermined.
void describe_covariance(const CalibrationProblem& problem, const CalibrationState& state,
                         CalibrationResult& result) {
  const SharedSystem system = shared_system(problem, state);
  const SharedCovariance inverse = invert(system);
  const int spare = system.coordinates - free_parameter_count(problem, true);
  const double variance = spare > 0 ? system.squares / spare : 0;
  result.parameters = system.names;
  result.values = system.values.cwiseProduct(system.scale);
  result.covariance =
      variance * system.scale.asDiagonal() * inverse.covariance * system.scale.asDiagonal();
  Vector6d twist_unit;
  twist_unit << 1, 1, 1, problem.unit_m, problem.unit_m, problem.unit_m;
  result.mean_frame_gain =
      twist_unit.asDiagonal() * system.mean_frame_gain * system.scale.cwiseInverse().asDiagonal();
  result.mean_frame_covariance =
      variance * twist_unit.asDiagonal() * system.mean_frame_covariance * twist_unit.asDiagonal();
  describe_noise(problem, spare > 0 ? std::sqrt(variance) : std::nan(""), result);
  result.cost_px2 = system.cost;
  result.not_determined = inverse.not_determined;
  if (!result.not_determined.empty()) result.reason = "the views do not fix these parameters";
  if (spare <= 0) {
    result.not_determined = system.names;
    result.reason = std::to_string(system.coordinates) + " coordinates for " +
                    std::to_string(free_parameter_count(problem, true)) + " parameters";
  }
}

void describe_solver(const SolverRun& run, CalibrationResult& result) {
  result.solver_rms_px = run.rms_px;
  result.solver_rms_name = run.rms_name;
  if (run.deviations.empty()) return;
  const double n = result.observations;
  const double p = static_cast<double>(result.parameters.size()) +
                   6.0 * static_cast<double>(result.frames.size());
  result.solver_deviations =
      Eigen::VectorXd::Constant(result.values.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto at = run.deviations.find(result.parameters[i]);
    if (at != run.deviations.end())
      result.solver_deviations(static_cast<Eigen::Index>(i)) = at->second;
  }
  result.corrected_deviations = std::sqrt((n - p) / (2 * n - p)) * result.solver_deviations;
}

CalibrationResult finished(CalibrationResult result, const StageClock& clock) {
  result.seconds = clock.finish().wall_s;
  return result;
}

}  // namespace

CalibrationInput calibration_input(const CalibrationTarget& target, std::vector<TargetView> views,
                                   const std::vector<Camera>& cameras) {
  CalibrationInput input;
  for (const TargetPoint& p : target_points(target)) {
    // Ids may have gaps (the seed board's markers hide corners): those are never observed.
    while (static_cast<int>(input.target_m.size()) < p.id) input.target_m.emplace_back(0, 0, 0);
    input.target_m.emplace_back(p.at_m.x(), p.at_m.y(), 0);
  }
  input.views = std::move(views);
  for (const Camera& camera : cameras) input.cameras.push_back({camera, -1});
  return input;
}

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationConfig& config) {
  validate(config);
  const StageClock clock("calibrate");
  CalibrationResult result;
  CalibrationProblem problem = make_problem(input, config, result.reason);
  result.status = CalibrationStatus::bad_input;
  if (!result.reason.empty()) return finished(result, clock);
  CalibrationState state;
  SolverRun run = run_solver(problem, state);
  const bool solved = !state.frames.empty() && !problem.views.empty() &&
                      run.status != CalibrationStatus::not_built &&
                      run.status != CalibrationStatus::bad_input && run.not_determined.empty();
  const bool rejects =
      solved && config.reject_sigmas > 0 && config.solver != CalibrationSolver::mrcal;
  for (int pass = 0, found = 1; rejects && found > 0 && pass < kMostPasses; ++pass) {
    found = reject(problem, state);
    if (found == 0 && pass > 0) break;
    drop_emptied(problem, state);
    if (problem.views.empty()) break;
    problem.config.reject_sigmas = 0;  // from here on without the loss that found the outliers
    const int before = run.iterations;
    run = run_solver(problem, state);
    run.iterations += before;
    problem.config.reject_sigmas = config.reject_sigmas;
  }
  result.status = run.status;
  result.reason = run.reason;
  result.not_determined = run.not_determined;
  result.iterations = run.iterations;
  if (!solved || problem.views.empty()) return finished(result, clock);
  if (config.solver == CalibrationSolver::ceres && run.status == CalibrationStatus::ok)
    polish(problem, state);
  describe_state(problem, state, input, result);
  describe_residuals(problem, state, result);
  describe_covariance(problem, state, result);
  judge_calibration(input, config, result);
  describe_solver(run, result);
  return finished(result, clock);
}

}  // namespace cousin
