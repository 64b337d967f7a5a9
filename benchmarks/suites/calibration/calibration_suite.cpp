#include "benchmarks/suites/calibration/calibration_suite.h"

#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>

#include "benchmarks/suites/calibration/calibration_row.h"
#include "benchmarks/suites/calibration/cause_rows.h"
#include "benchmarks/suites/calibration/choice_rows.h"
#include "benchmarks/suites/calibration/corner_views.h"
#include "benchmarks/suites/calibration/coverage.h"
#include "benchmarks/suites/calibration/detection_rows.h"
#include "benchmarks/suites/calibration/exhibit_rows.h"
#include "benchmarks/suites/calibration/rig_rows.h"
#include "calibration/solve/calibration_uncertainty.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

using Rows = std::vector<ScoreRow>;

CalibrationConfig tight(CalibrationSolver solver) {
  CalibrationConfig config;
  config.solver = solver;
  config.max_iterations = 300;
  return config;
}

struct Lens4 {
  const char* name;
  LensModel model;
  bool without_k3;
};

/// The three solvers' minima on the same corners.
void agreement_rows(Rows& rows, std::uint64_t seed) {
  const std::vector<Lens4> lenses = {{"opencv4", LensModel::opencv5, true},
                                     {"opencv5", LensModel::opencv5, false},
                                     {"opencv8", LensModel::opencv8, false},
                                     {"opencv12", LensModel::opencv12, false},
                                     {"kannala_brandt4", LensModel::kannala_brandt4, false}};
  for (const Lens4& lens : lenses) {
    const CornerViews views = make_corner_views({study_camera(lens.model)}, {Pose{}}, close_views(),
                                                Rng(seed).fork("agreement"));
    CalibrationConfig config = tight(CalibrationSolver::ceres);
    if (lens.without_k3) config.fixed = {"k3"};
    const CalibrationResult ours = calibrate(views.input, config);
    for (const CalibrationSolver other : {CalibrationSolver::opencv, CalibrationSolver::mrcal}) {
      if (other == CalibrationSolver::mrcal && lens.model == LensModel::kannala_brandt4) continue;
      config.solver = other;
      CalibrationResult theirs = calibrate(views.input, config);
      ScoreRow row = calibration_row("agreement", lens.name,
                                     "ceres against " + std::string(to_string(other)), seed);
      row.n = ours.observations;
      if (ours.status == CalibrationStatus::not_built || theirs.values.size() == 0) {
        rows.push_back(not_built(
            row, ours.status == CalibrationStatus::not_built ? ours.reason : theirs.reason));
        continue;
      }
      row.metric = "cost of the other from its own start, over ours";
      row.value = theirs.cost_px2 / ours.cost_px2;
      rows.push_back(row);
      row.metric = "seconds of the other over ours";
      row.value = theirs.seconds / ours.seconds;
      rows.push_back(row);
      if (other == CalibrationSolver::opencv) {
        // From its own start it may end in another minimum: the row above tells; from ours it may
        // leave for one. Here minima are compared: the lower of its two.
        CalibrationInput near = views.input;
        near.cameras[0].start = ours.cameras.at(0);
        CalibrationResult from_ours = calibrate(near, config);
        row.metric = "cost of the other from our solution, over ours";
        row.value = from_ours.cost_px2 / ours.cost_px2;
        rows.push_back(row);
        if (from_ours.cost_px2 < theirs.cost_px2) theirs = std::move(from_ours);
      }
      double apart = 0;
      for (std::size_t i = 0; i < ours.parameters.size(); ++i) {
        const auto at = static_cast<Eigen::Index>(i);
        apart = std::max(apart, std::abs(ours.values(at) - theirs.values(at)) /
                                    deviation(ours, ours.parameters[i]));
      }
      rows.push_back(at_most(row, "cost, relative difference", "1",
                             std::abs(ours.cost_px2 / theirs.cost_px2 - 1), 1e-6));
      rows.push_back(
          at_most(row, "parameters, largest difference over deviation", "1", apart, 1e-3));
      row.metric = "RMS of the other as it defines it, over the RMS per coordinate";
      row.value = theirs.solver_rms_px / theirs.rms_px;
      rows.push_back(row);
    }
  }
}

void noise_free_rows(Rows& rows, std::uint64_t seed) {
  CornerViewsConfig config = close_views();
  config.noise_px = 0;
  for (const LensModel model :
       {LensModel::pinhole, LensModel::opencv5, LensModel::opencv8, LensModel::opencv12,
        LensModel::kannala_brandt4, LensModel::splined_stereographic}) {
    const bool splined = model == LensModel::splined_stereographic;
    CornerViewsConfig of_model = config;
    if (splined) of_model.frames = 60, of_model.columns = 12, of_model.rows = 9;
    const CornerViews views =
        make_corner_views({study_camera(model)}, {Pose{}}, of_model, Rng(seed).fork("noise-free"));
    for (const CalibrationSolver solver : {CalibrationSolver::ceres, CalibrationSolver::mrcal}) {
      if (solver == CalibrationSolver::mrcal && !splined) continue;
      ScoreRow row = calibration_row("noise-free corners", std::string(to_string(model)),
                                     std::string(to_string(solver)), seed);
      const CalibrationResult result = calibrate(views.input, tight(solver));
      if (result.status == CalibrationStatus::not_built) {
        rows.push_back(not_built(row, result.reason));
        continue;
      }
      // Where corners were: a spline's surface says nothing beyond.
      const double radius = splined ? 260 : 0;
      ProjectionDifference off;
      if (!result.cameras.empty())
        off = projection_difference(views.cameras[0], result.cameras[0], {}, radius);
      double largest = off.pixel_px.empty() ? std::nan("") : 0;
      for (std::size_t i = 0; i < off.difference_px.size(); ++i) {
        const Eigen::Vector2d from_middle = off.pixel_px[i] - Eigen::Vector2d(319.5, 239.5);
        if (radius > 0 && from_middle.norm() > radius) continue;
        largest = std::max(largest, off.difference_px[i].norm());
      }
      if (solver == CalibrationSolver::mrcal) {
        // mrcal pulls its surface to zero with a weight that its C API does not let go.
        row.metric = "projection error, largest within 260 px of the middle; regularised";
        row.unit = "px";
        row.value = largest;
        rows.push_back(row);
        continue;
      }
      rows.push_back(at_most(row,
                             splined ? "projection error, largest within 260 px of the middle"
                                     : "projection error, largest",
                             "px", largest, splined ? 1e-3 : 1e-6));
    }
  }
}

void coverage_rows(Rows& rows, std::uint64_t seed, bool quick) {
  struct Case {
    const char* name;
    ProjectionGauge gauge;
    double distance_m;
  };
  const double far = std::numeric_limits<double>::infinity();
  for (const Case& c : {Case{"best fit, infinity", ProjectionGauge::best_fit, far},
                        Case{"mean frames, 0.35 m", ProjectionGauge::mean_frames, 0.35},
                        Case{"mean frames, infinity", ProjectionGauge::mean_frames, far}}) {
    CoverageConfig config;
    config.views = close_views();
    config.gauge = c.gauge;
    config.distance_m = c.distance_m;
    config.calibrations = quick ? 300 : 1000;
    ScoreRow row = calibration_row("coverage of projection intervals", c.name, "ceres", seed);
    const Coverage found = projection_coverage(config, Rng(seed).fork("coverage"));
    row.n = found.calibrations;
    if (found.calibrations == 0) {
      rows.push_back(not_built(row, "no calibration succeeded"));
      continue;
    }
    row.metric = "within 95 % intervals (0.93..0.97)";
    row.value = found.within_95;
    rows.push_back(limited(row, between(0.93, 0.97)));
    row.metric = "within 68 % intervals (0.65..0.71)";
    row.value = found.within_68;
    rows.push_back(limited(row, between(0.65, 0.71)));
  }
}

/// Both from corners to covariance; the best of five, since other work disturbs.
void speed_rows(Rows& rows, std::uint64_t seed) {
  const CornerViews views = make_corner_views({study_camera(LensModel::opencv8)}, {Pose{}},
                                              close_views(), Rng(seed).fork("speed"));
  double best[2] = {1e9, 1e9}, cost[2] = {0, 0};
  for (int i = 0; i < 5; ++i) {
    for (int s = 0; s < 2; ++s) {
      const CalibrationResult result = calibrate(
          views.input, tight(s == 0 ? CalibrationSolver::ceres : CalibrationSolver::opencv));
      best[s] = std::min(best[s], result.seconds);
      cost[s] = result.cost_px2;
    }
  }
  ScoreRow row = calibration_row("speed", "30 images of 40 corners, opencv8", "ceres", seed);
  if (std::isnan(cost[0])) {
    rows.push_back(not_built(row, "not built in: Ceres (WITH_CERES=OFF)"));
    return;
  }
  rows.push_back(at_most(row, "seconds over OpenCV's", "1", best[0] / best[1], 1));
  rows.push_back(at_most(row, "cost over OpenCV's, less 1", "1", cost[0] / cost[1] - 1, 1e-6));
  row.metric = "seconds";
  row.unit = "s";
  row.value = row.wall_s = best[0];
  rows.push_back(row);
}

void add(Rows& rows, const Rows& more) { rows.insert(rows.end(), more.begin(), more.end()); }

}  // namespace

ScoreFile calibration_suite(std::uint64_t seed, bool quick, const Progress& progress) {
  struct Part {
    const char* name;
    std::function<void(Rows&)> run;
  };
  const std::vector<Part> parts = {
      {"detection on rendered boards", [&](Rows& rows) { add(rows, detection_rows(seed, quick)); }},
      {"agreement of solvers", [&](Rows& rows) { agreement_rows(rows, seed); }},
      {"noise-free corners", [&](Rows& rows) { noise_free_rows(rows, seed); }},
      {"coverage", [&](Rows& rows) { coverage_rows(rows, seed, quick); }},
      {"speed", [&](Rows& rows) { speed_rows(rows, seed); }},
      {"hand-eye", [&](Rows& rows) { add(rows, hand_eye_rows(seed, quick)); }},
      {"rig of eight cameras", [&](Rows& rows) { add(rows, joint_rows(seed, quick)); }},
      {"exhibits", [&](Rows& rows) { add(rows, exhibit_rows(seed, quick)); }},
      {"causes of a wrong calibration", [&](Rows& rows) { add(rows, cause_rows(seed, quick)); }},
      {"choosing a calibration", [&](Rows& rows) { add(rows, choice_rows(seed, quick)); }}};
  ScoreFile file;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (progress) progress(parts[i].name, static_cast<int>(i), static_cast<int>(parts.size()));
    const StageClock clock(parts[i].name);
    parts[i].run(file.scores);
    ScoreRow seconds = calibration_row(parts[i].name, parts[i].name, "ours", seed);
    seconds.metric = "seconds";
    seconds.unit = "s";
    seconds.value = seconds.wall_s = clock.finish().wall_s;
    file.scores.push_back(seconds);
  }
  return file;
}

}  // namespace cousin
