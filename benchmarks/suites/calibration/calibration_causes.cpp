#include "benchmarks/suites/calibration/calibration_causes.h"

#include <tbb/parallel_for.h>

#include <limits>
#include <numbers>

#include "benchmarks/suites/calibration/reprojection.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::size_t kP1 = 2;  ///< place of p1 among opencv5's coefficients

CauseOutcome run_one(const CalibrationCause& cause, double amount, const Rng& rng) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  CornerViewsConfig config = strawberry_views();
  cause.set(amount, config);
  const Camera truth = strawberry_camera();
  const CornerViews views = make_corner_views({truth}, {Pose{}}, config, rng);
  CalibrationConfig solve;
  solve.solver = cause.solver;
  solve.tolerance = 1e-10;
  const CalibrationResult found = calibrate(views.input, solve);
  CauseOutcome outcome{kNone, kNone, kNone, kNone, kNone, kNone, false};
  outcome.is_refused = found.status != CalibrationStatus::ok;
  if (found.cameras.empty()) return outcome;
  const Camera& lens = found.cameras.front();
  outcome.p1_error = lens.distortion[kP1] - truth.distortion[kP1];
  outcome.centre_px = std::hypot(lens.cx_px - truth.cx_px, lens.cy_px - truth.cy_px);
  outcome.projection_px = projection_difference(truth, lens).rms_px;
  const ReprojectionErrors errors = reprojection_errors(found);
  outcome.tutorial_px = errors.tutorial_px;
  outcome.mean_distance_px = errors.mean_distance_px;
  outcome.rms_point_px = errors.rms_point_px;
  return outcome;
}

/// Tilts as small as the amount, in degrees.
void tilt(double degrees, CornerViewsConfig& views) { views.tilt_rad = degrees * kDegree; }

/// How many photographs there are, how good, and from where.
std::vector<CalibrationCause> causes_of_views() {
  using Views = CornerViewsConfig;
  return {
      {"corner noise", "px", {0.04, 0.1, 0.22, 0.5}, [](double v, Views& c) { c.noise_px = v; }},
      {"few photographs", "1", {5, 10}, [](double v, Views& c) { c.frames = static_cast<int>(v); }},
      {"largest tilt", "deg", {2, 3, 4, 5, 10, 45}, tilt},
      {"largest tilt, solved by OpenCV", "deg", {2, 3, 5, 10}, tilt, CalibrationSolver::opencv},
      {"largest tilt, corners to 0.22 px",
       "deg",
       {3, 5, 10},
       [](double v, Views& c) {
         tilt(v, c);
         c.noise_px = 0.22;
       }},
      {"board kept to the middle of the picture, share",
       "1",
       {0.1, 0.3},
       [](double v, Views& c) {
         c.region = {0.5 - 0.5 * v, 0.5 - 0.5 * v, 0.5 + 0.5 * v, 0.5 + 0.5 * v};
       }},
      {"board kept to the lower half",
       "1",
       {1},
       [](double, Views& c) {
         c.region = {0, 0.5, 1, 1};
       }},
      {"far away, nearest",
       "m",
       {0.6, 0.9},
       [](double v, Views& c) {
         c.near_m = v;
         c.far_m = v + 0.3;
       }},
  };
}

/// Boards that are bent, lifted, stretched or sheared.
std::vector<CalibrationCause> causes_of_board() {
  using Views = CornerViewsConfig;
  return {
      {"paper bent along its length",
       "m",
       {0.0005, 0.001, 0.002, 0.004},
       [](double v, Views& c) { c.deformation_m.y() = v; }},
      {"an end of the paper lifts",
       "m",
       {0.001, 0.002, 0.005, 0.01},
       [](double v, Views& c) { c.flaws.edge_m = v; }},
      {"an end lifts, tilts up to 5 degrees",
       "m",
       {0.001, 0.002, 0.005},
       [](double v, Views& c) {
         c.flaws.edge_m = v;
         tilt(5, c);
       }},
      {"paper flutters in the hand",
       "m",
       {0.0005, 0.001, 0.002},
       [](double v, Views& c) { c.flaws.flutter_m = v; }},
      {"print stretched across",
       "1",
       {0.002, 0.005, 0.02},
       [](double v, Views& c) { c.flaws.stretch_x = 1 + v; }},
      {"print sheared",
       "1",
       {0.002, 0.005, 0.02, 0.03},
       [](double v, Views& c) { c.flaws.shear = v; }},
      {"print sheared, corners to 0.04 px",
       "1",
       {0.02, 0.03},
       [](double v, Views& c) {
         c.flaws.shear = v;
         c.noise_px = 0.04;
       }},
      {"print sheared, tilts up to 5 degrees",
       "1",
       {0.005, 0.02},
       [](double v, Views& c) {
         c.flaws.shear = v;
         tilt(5, c);
       }},
      {"a corner of the paper lifts",
       "m",
       {0.001, 0.002, 0.005, 0.01},
       [](double v, Views& c) { c.flaws.twist_m = v; }},
      {"a corner lifts, tilts up to 5 degrees",
       "m",
       {0.002, 0.005},
       [](double v, Views& c) {
         c.flaws.twist_m = v;
         tilt(5, c);
       }},
  };
}

/// Where corners are found, the board being right.
std::vector<CalibrationCause> causes_of_corners() {
  using Views = CornerViewsConfig;
  return {
      {"rows read one after another in the hand, turn",
       "rad",
       {0.0005, 0.002, 0.005},
       [](double v, Views& c) { c.flaws.turn_rad = v; }},
      {"corners found off along both axes",
       "px",
       {0.5},
       [](double v, Views& c) {
         c.flaws.shift_px = {v, v};
       }},
      {"corners of the next square, share",
       "1",
       {0.003, 0.01, 0.03},
       [](double v, Views& c) {
         c.outlier_share = v;
         c.outlier_px = 15;
       }},
  };
}

}  // namespace

CornerViewsConfig strawberry_views() {
  CornerViewsConfig views;
  views.columns = 5;
  views.rows = 8;
  views.pitch_m = 0.025;
  views.frames = 30;
  views.tilt_rad = 20 * kDegree;
  views.noise_px = 0.1;
  return views;
}

Camera strawberry_camera() {
  Camera camera{LensModel::opencv5, 640, 480, 390, 390, 319.5, 239.5, {}, {}};
  camera.distortion = {-0.0557, 0.0603, -0.00098, -0.00085, -0.0161};
  return camera;
}

const std::vector<CalibrationCause>& calibration_causes() {
  static const std::vector<CalibrationCause> causes = [] {
    std::vector<CalibrationCause> all = causes_of_views();
    for (const auto& more : {causes_of_board(), causes_of_corners()})
      all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return causes;
}

std::vector<CauseOutcome> run_cause(const CalibrationCause& cause, double amount, int count,
                                    const Rng& rng) {
  std::vector<CauseOutcome> outcomes(static_cast<std::size_t>(count));
  tbb::parallel_for(std::size_t{0}, outcomes.size(),
                    [&](std::size_t i) { outcomes[i] = run_one(cause, amount, rng.fork(i)); });
  return outcomes;
}

}  // namespace cousin
