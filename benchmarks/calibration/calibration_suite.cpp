#include "benchmarks/calibration/calibration_suite.h"

#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>

#include "benchmarks/calibration/corner_views.h"
#include "benchmarks/calibration/coverage.h"
#include "benchmarks/calibration/detection_rows.h"
#include "benchmarks/calibration/hand_eye_views.h"
#include "calibration/calibration_uncertainty.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

using Rows = std::vector<ScoreRow>;

ScoreRow base_row(const std::string& scene, const std::string& case_name, const std::string& method,
                  std::uint64_t seed) {
  ScoreRow row;
  row.suite = "calibration";
  row.scene = scene;
  row.case_name = case_name;
  row.method = method;
  row.seed = seed;
  row.unit = "1";
  row.n = 1;
  return row;
}

CornerViewsConfig close_views() {
  CornerViewsConfig config;
  config.near_m = 0.2;
  config.far_m = 0.45;
  return config;
}

CalibrationConfig tight(CalibrationSolver solver) {
  CalibrationConfig config;
  config.solver = solver;
  config.max_iterations = 300;
  return config;
}

ScoreRow at_most(ScoreRow row, const std::string& metric, const std::string& unit, double value,
                 double limit) {
  char text[32];
  std::snprintf(text, sizeof text, " (at most %g)", limit);
  row.metric = metric + text;
  row.unit = unit;
  row.value = value;
  return limited(row, value <= limit);
}

ScoreRow not_built(ScoreRow row, const std::string& reason) {
  row.metric = reason;
  row.status = ScoreStatus::not_built;
  return row;
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
      ScoreRow row =
          base_row("agreement", lens.name, "ceres against " + std::string(to_string(other)), seed);
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
      ScoreRow row = base_row("noise-free corners", std::string(to_string(model)),
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
    ScoreRow row = base_row("coverage of projection intervals", c.name, "ceres", seed);
    const Coverage found = projection_coverage(config, Rng(seed).fork("coverage"));
    row.n = found.calibrations;
    if (found.calibrations == 0) {
      rows.push_back(not_built(row, "no calibration succeeded"));
      continue;
    }
    row.metric = "within 95 % intervals (0.93..0.97)";
    row.value = found.within_95;
    rows.push_back(limited(row, found.within_95 >= 0.93 && found.within_95 <= 0.97));
    row.metric = "within 68 % intervals (0.65..0.71)";
    row.value = found.within_68;
    rows.push_back(limited(row, found.within_68 >= 0.65 && found.within_68 <= 0.71));
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
  ScoreRow row = base_row("speed", "30 images of 40 corners, opencv8", "ceres", seed);
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

/// A camera on an arm: 20 poses, 0.1 px, 0.2 mm, 0.02 degrees; motions that leave it open.
void hand_eye_rows(Rows& rows, std::uint64_t seed, bool quick) {
  const int arms = quick ? 20 : 100;
  ScoreRow row = base_row("hand-eye", "20 poses, 0.1 px, 0.2 mm, 0.02 degrees", "ours", seed);
  row.n = arms;
  double place2 = 0, turn2 = 0, refused[2] = {0, 0};
  for (int i = 0; i < arms; ++i) {
    const Rng rng = Rng(seed).fork("hand-eye").fork(static_cast<std::uint64_t>(i));
    HandEyeViewsConfig config;
    const HandEyeViews views = make_hand_eye_views(config, rng);
    const HandEyeError error = hand_eye_error(views, calibrate_hand_eye(views.input));
    place2 += error.place_m * error.place_m;
    turn2 += error.turn_rad * error.turn_rad;
    for (int k = 0; k < 2; ++k) {
      config.motion = k == 0 ? ArmMotion::translation : ArmMotion::one_axis;
      refused[k] += calibrate_hand_eye(make_hand_eye_views(config, rng).input).status ==
                    CalibrationStatus::not_determined;
    }
  }
  rows.push_back(at_most(row, "place, RMS error", "m", std::sqrt(place2 / arms), 3e-4));
  rows.push_back(at_most(row, "rotation, RMS error", "rad", std::sqrt(turn2 / arms), 5.24e-4));
  for (int k = 0; k < 2; ++k) {
    row.case_name = k == 0 ? "pure translation" : "parallel axes";
    row.metric = "share refused (1)";
    row.unit = "1";
    row.value = refused[k] / arms;
    rows.push_back(limited(row, refused[k] == arms));
  }
}

/// Eight cameras in a ring about the board, 500 frames, 60 corners, one solution.
void joint_rows(Rows& rows, std::uint64_t seed, bool quick) {
  std::vector<Camera> cameras(8, study_camera(LensModel::opencv5));
  std::vector<Pose> poses;
  Rng rng = Rng(seed).fork("ring");
  for (int c = 0; c < 8; ++c) {
    cameras[static_cast<std::size_t>(c)].fx_px += uniform(rng, -5, 5);
    cameras[static_cast<std::size_t>(c)].cx_px += uniform(rng, -5, 5);
    const double x = 0.06 * (c % 4), y = 0.06 * (c / 4);
    poses.push_back(inverse(
        Pose{Eigen::Quaterniond(1, -0.03 * (c / 4), 0.03 * (c % 4), 0).normalized(), {x, y, 0}}));
  }
  poses.front() = Pose{};
  CornerViewsConfig config = close_views();
  config.columns = 10;
  config.rows = 6;
  config.pitch_m = 0.02;
  config.near_m = 0.35;
  config.far_m = 0.6;
  config.frames = quick ? 200 : 500;
  const CornerViews views = make_corner_views(cameras, poses, config, Rng(seed).fork("joint"));
  const StageClock clock("joint");
  const CalibrationResult result = calibrate(views.input);
  const StageTiming time = clock.finish();
  ScoreRow row =
      base_row("rig", "8 cameras, " + std::to_string(config.frames) + " frames, 60 corners",
               "ceres, one thread", seed);
  row.n = result.observations;
  row.wall_s = time.wall_s;
  row.cpu_s = time.cpu_s;
  row.peak_rss_mb = peak_rss_mb();
  if (result.status == CalibrationStatus::not_built) {
    rows.push_back(not_built(row, result.reason));
    return;
  }
  rows.push_back(at_most(row, "seconds, corners to covariance", "s", time.wall_s, quick ? 12 : 30));
  rows.push_back(at_most(row, "peak memory of the process", "MB", row.peak_rss_mb, 1024));
  double worst_m = 0, worst = 0;
  for (std::size_t c = 1; c < result.camera_from_rig.size(); ++c) {
    const Eigen::Vector3d off =
        result.camera_from_rig[c].translation_m - views.camera_from_rig[c].translation_m;
    worst_m = std::max(worst_m, off.norm());
    for (int k = 0; k < 3; ++k) {
      const std::string name = "camera" + std::to_string(c) + ".t_" + "xyz"[k];
      worst = std::max(worst, std::abs(off(k)) / deviation(result, name));
    }
  }
  row.metric = "largest error of a camera's place";
  row.unit = "m";
  row.value = result.cameras.empty() ? std::nan("") : worst_m;
  rows.push_back(row);
  // 21 numbers: the largest of so many normals is below 4.2 in 99.9 of 100 cases.
  rows.push_back(at_most(row, "the same over its deviation, largest of 21", "1",
                         result.cameras.empty() ? std::nan("") : worst, 4.2));
}

}  // namespace

ScoreFile calibration_suite(std::uint64_t seed, bool quick, const Progress& progress) {
  struct Part {
    const char* name;
    std::function<void(Rows&)> run;
  };
  const std::vector<Part> parts = {
      {"detection on rendered boards",
       [&](Rows& rows) {
         const Rows found = detection_rows(seed, quick);
         rows.insert(rows.end(), found.begin(), found.end());
       }},
      {"agreement of solvers", [&](Rows& rows) { agreement_rows(rows, seed); }},
      {"noise-free corners", [&](Rows& rows) { noise_free_rows(rows, seed); }},
      {"coverage", [&](Rows& rows) { coverage_rows(rows, seed, quick); }},
      {"speed", [&](Rows& rows) { speed_rows(rows, seed); }},
      {"hand-eye", [&](Rows& rows) { hand_eye_rows(rows, seed, quick); }},
      {"rig of eight cameras", [&](Rows& rows) { joint_rows(rows, seed, quick); }}};
  ScoreFile file;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (progress) progress(parts[i].name, static_cast<int>(i), static_cast<int>(parts.size()));
    const StageClock clock(parts[i].name);
    parts[i].run(file.scores);
    ScoreRow seconds = base_row(parts[i].name, parts[i].name, "ours", seed);
    seconds.metric = "seconds";
    seconds.unit = "s";
    seconds.value = seconds.wall_s = clock.finish().wall_s;
    file.scores.push_back(seconds);
  }
  return file;
}

}  // namespace cousin
