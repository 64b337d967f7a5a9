#include "benchmarks/calibration/studies.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "benchmarks/calibration/board_photographs.h"
#include "benchmarks/calibration/calibration_errors.h"
#include "benchmarks/calibration/study_points.h"
#include "calibration/calibration_uncertainty.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr const char* kSuite = "calibration";
constexpr const char* kPooled = "study";

/// What is averaged over the runs of a point.
struct StudyMetric {
  const char* name;
  const char* unit;
  const char* shown;  ///< on a plot, with its unit; empty = not drawn
  double scale;       ///< from `unit` to what is shown
};
constexpr std::array<StudyMetric, 10> kMetrics = {
    {{"projection.rms", "px", "projection error, RMS over the image (px)", 1},
     {"projection.worst", "px", "", 1},
     {"projection.predicted", "px", "", 1},
     {"fruit.position", "m", "sideways error of a fruit at 0.5 m (mm)", 1e3},
     {"seed.length", "m", "error of a seed's length of 10 mm (µm)", 1e6},
     {"reprojection.rms_coordinate", "px", "", 1},
     {"reprojection.rms_point", "px", "", 1},
     {"reprojection.tutorial", "px", "", 1},
     {"focal.error", "1", "", 1},
     {"centre.error", "px", "", 1}}};

struct Photographed {
  std::vector<TargetView> views;
  std::vector<Camera> true_lenses;  ///< of the views
  Camera nominal;
  Camera reported;  ///< by the device, of the first view
  CalibrationTarget target;
  double seconds = 0;  ///< of finding the board
};

/// Photographs a view and finds the board in it; a few at a time, as each holds a picture.
Photographed photograph(const std::vector<std::string>& sets, std::uint64_t seed) {
  const BoardPhotographs board(sets, seed);
  Photographed result;
  result.target = board.target();
  const auto n = static_cast<std::size_t>(board.size());
  result.views.resize(n);
  std::vector<Image<Rgb8>> pictures(n);
  for (std::size_t i = 0; i < n; ++i) {
    const SensorFrame taken = board.take(static_cast<int>(i)).sensors.at(0);
    pictures[i] = taken.color;
    if (i == 0) result.reported = taken.reported;
    result.true_lenses.push_back(board.truth().front().views.at(i).camera);
  }
  const StageClock clock("find");
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    result.views[i] = find_target(light_of(pictures[i]), result.target);
    result.views[i].frame = static_cast<int>(i);
  });
  result.seconds = clock.finish().wall_s;
  result.nominal = result.true_lenses.front();
  return result;
}

/// The camera's size and the model; nothing that only the truth knows.
Camera unknown_lens(const Camera& like, LensModel model) {
  Camera camera;
  camera.model = model;
  camera.width_px = like.width_px;
  camera.height_px = like.height_px;
  if (model == LensModel::splined_stereographic) {
    camera.spline.order = 3;
    camera.spline.columns = 11;
    camera.spline.rows = 8;
    camera.spline.fov_x_rad = 1.7;
  }
  return camera;
}

/// Mean square of the errors over some of the views' lenses: one where they are the same, as many
/// as five where the camera focuses anew each time.
CalibrationErrors errors_over(const std::vector<Camera>& lenses, const StudyPoint& point,
                              const Camera& estimate) {
  std::vector<Camera> some;
  for (std::size_t i = 0; i < lenses.size(); i += std::max<std::size_t>(1, lenses.size() / 5)) {
    if (some.empty() || !(some.back() == lenses[i])) some.push_back(lenses[i]);
  }
  CalibrationErrors sum;
  for (const Camera& lens : some) {
    const CalibrationErrors e =
        calibration_errors(point.at_work ? point.at_work(lens) : lens, estimate);
    sum.projection_px += e.projection_px * e.projection_px;
    sum.projection_worst_px = std::max(sum.projection_worst_px, e.projection_worst_px);
    sum.fruit_m += e.fruit_m * e.fruit_m;
    sum.seed_m += e.seed_m * e.seed_m;
  }
  const auto n = static_cast<double>(some.size());
  sum.projection_px = std::sqrt(sum.projection_px / n);
  sum.fruit_m = std::sqrt(sum.fruit_m / n);
  sum.seed_m = std::sqrt(sum.seed_m / n);
  return sum;
}

/// Reprojection error as OpenCV's tutorial prints it: of each view the root of the sum of squares
/// over the number of points, averaged over the views. It shrinks with the points a view has.
double tutorial_error_px(const CalibrationResult& result) {
  std::map<int, std::pair<double, int>> of_view;
  for (const CalibrationResidual& r : result.residuals) {
    if (r.rejected) continue;
    auto& [squares, count] = of_view[r.view];
    squares += r.residual_px.squaredNorm();
    ++count;
  }
  double sum = 0;
  for (const auto& [view, of] : of_view) sum += std::sqrt(of.first) / of.second;
  return of_view.empty() ? ScoreRow::kNone : sum / static_cast<double>(of_view.size());
}

/// The device's own lens, as a result of no time and no corners.
CalibrationResult factory_result(const Camera& reported) {
  CalibrationResult result;
  result.status = CalibrationStatus::ok;
  result.cameras = {reported};
  return result;
}

/// RMS over the image of the deviation that the calibration predicts of its own projection.
double predicted_px(const CalibrationResult& found) {
  if (found.covariance.size() == 0) return ScoreRow::kNone;
  return rms_deviation_px(projection_uncertainty(found, 0));
}

std::vector<ScoreRow> run_method(const StudyPoint& point, const StudyMethod& method,
                                 const Photographed& seen, int run, std::uint64_t seed) {
  const StageClock clock("solve");
  const CalibrationResult found =
      method.is_factory ? factory_result(seen.reported)
                        : calibrate(calibration_input(seen.target, seen.views,
                                                      {unknown_lens(seen.nominal, method.model)}),
                                    method.solve);
  ScoreRow base;
  base.suite = kSuite;
  base.scene = point.axis;
  base.case_name = point.name() + " run " + std::to_string(run);
  base.method = method.name;
  base.seed = seed;
  base.n = found.observations;
  if (!method.is_factory) base.wall_s = seen.seconds + clock.finish().wall_s;
  const bool is_solved = found.status == CalibrationStatus::ok;
  base.status = is_solved                                      ? ScoreStatus::ok
                : found.status == CalibrationStatus::not_built ? ScoreStatus::not_built
                                                               : ScoreStatus::not_solved;
  const bool has_numbers = is_solved || found.status == CalibrationStatus::not_determined;
  std::array<double, kMetrics.size()> values;
  values.fill(ScoreRow::kNone);
  if (has_numbers && !found.cameras.empty()) {
    const Camera& lens = found.cameras.front();
    const CalibrationErrors errors = errors_over(seen.true_lenses, point, lens);
    const Camera truth = point.at_work ? point.at_work(seen.nominal) : seen.nominal;
    values = {errors.projection_px,
              errors.projection_worst_px,
              predicted_px(found),
              errors.fruit_m,
              errors.seed_m,
              found.rms_px,
              found.rms_px * std::sqrt(2.0),
              tutorial_error_px(found),
              lens.fx_px / truth.fx_px - 1,
              std::hypot(lens.cx_px - truth.cx_px, lens.cy_px - truth.cy_px)};
  }
  std::vector<ScoreRow> rows;
  for (std::size_t m = 0; m < kMetrics.size(); ++m) {
    ScoreRow row = base;
    row.metric = kMetrics[m].name;
    row.unit = kMetrics[m].unit;
    row.value = values[m];
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string run_point(const StudyPoint& point, const std::vector<std::string>& sets, int run,
                      std::uint64_t seed) {
  // The same camera, board and way of going about for all points of a study.
  const std::uint64_t own =
      Rng(seed).fork("calibration study").fork(static_cast<std::uint64_t>(run))();
  Photographed seen = photograph(sets, own);
  spoil(seen.views, point.outlier_share, Rng(own).fork("outliers"));
  ScoreFile file;
  for (const StudyMethod& method : point.methods) {
    std::vector<ScoreRow> rows = run_method(point, method, seen, run, seed);
    file.scores.insert(file.scores.end(), rows.begin(), rows.end());
  }
  return to_json(file);
}

void add_group(const StudyPoint& point, const StudyMethod& method,
               const std::vector<ScoreRow>& rows, const StudiesConfig& config,
               std::vector<ScoreRow>& pooled) {
  for (const StudyMetric& metric : kMetrics) {
    ScoreRow base;
    base.suite = kSuite;
    base.scene = point.axis;
    base.case_name = point.name();
    base.method = method.name;
    base.seed = config.seed;
    std::vector<TraitPair> pairs;
    int runs = 0, solved = 0;
    double wall_s = 0;
    for (const ScoreRow& row : rows) {
      if (row.scene != point.axis || row.method != method.name || row.metric != metric.name ||
          !row.case_name.starts_with(point.name() + " run "))
        continue;
      ++runs;
      solved += row.status == ScoreStatus::ok;
      wall_s += row.wall_s;
      if (row.status == ScoreStatus::not_built) base.status = ScoreStatus::not_built;
      if (std::isfinite(row.value))
        pairs.push_back({0, row.value, ScoreRow::kNone, std::to_string(runs)});
    }
    if (runs == 0) continue;
    base.wall_s = wall_s / runs;
    if (base.status == ScoreStatus::ok && solved < runs) base.status = ScoreStatus::not_solved;
    if (pairs.size() > 1) {
      const TraitStatistics s = trait_statistics(
          pairs, Rng(config.seed).fork("calibration").fork(point.name()).fork(metric.name));
      pooled.push_back(with_interval(base, metric.name, metric.unit, s.rmse, s.n));
    } else {
      base.metric = metric.name;
      base.unit = metric.unit;
      base.value = pairs.empty() ? ScoreRow::kNone : std::abs(pairs.front().measured);
      base.n = static_cast<std::int64_t>(pairs.size());
      pooled.push_back(base);
    }
    if (&metric == kMetrics.data()) {
      ScoreRow row = pooled.back();
      row.metric = "solved";
      row.unit = "1";
      row.value = static_cast<double>(solved) / runs;
      row.n = runs;
      row.ci_low = row.ci_high = ScoreRow::kNone;
      pooled.push_back(std::move(row));
    }
  }
}

bool is_study_row(const ScoreRow& row) {
  return row.suite == kSuite && !row.case_name.empty() &&
         row.case_name.find(" run ") == std::string::npos;
}

LinePlot plot_of(const std::vector<ScoreRow>& rows, const std::string& axis,
                 const StudyMetric& metric) {
  LinePlot plot;
  plot.title = metric.shown;
  plot.title = plot.title.substr(0, plot.title.find(" (")) + ", over " + study_label(axis);
  plot.x_label = study_label(axis);
  plot.y_label = metric.shown;
  plot.log_y = true;
  bool has_interval = false;
  for (const StudyPoint& point : study_points(false)) {
    if (point.axis != axis) continue;
    for (const ScoreRow& row : rows) {
      if (!is_study_row(row) || row.case_name != point.name() || row.metric != metric.name ||
          !(row.value > 0))
        continue;
      const auto at = std::find_if(plot.series.begin(), plot.series.end(),
                                   [&](const LineSeries& s) { return s.name == row.method; });
      LineSeries& series = at == plot.series.end()
                               ? plot.series.emplace_back(LineSeries{row.method, {}, false, true})
                               : *at;
      has_interval = has_interval || std::isfinite(row.ci_low);
      series.points.push_back(
          {point.x,
           {metric.scale * row.value, metric.scale * row.ci_low, metric.scale * row.ci_high}});
    }
  }
  plot.caption = {std::string(has_interval ? "RMS over the runs with its 95 % interval."
                                           : "One run a point, so no interval.") +
                  " D457's colour camera, 640 x 480."};
  return plot;
}

std::vector<std::string> axes() {
  std::vector<std::string> names;
  for (const StudyPoint& point : study_points(false)) {
    if (names.empty() || names.back() != point.axis) names.push_back(point.axis);
  }
  return names;
}

}  // namespace

std::vector<ShardJob> study_jobs(const StudiesConfig& config) {
  std::vector<ShardJob> jobs;
  for (int run = 0; run < (config.quick ? 1 : config.runs); ++run) {
    for (const StudyPoint& point : study_points(config.quick)) {
      std::vector<std::string> sets = study_sets(config.quick);
      sets.insert(sets.end(), point.sets.begin(), point.sets.end());
      std::string name = "study_" + point.name() + "_run" + std::to_string(run) + ".json";
      std::string key =
          std::string(COUSIN_VERSION) + "/" + std::to_string(config.seed) + "/" + name;
      for (const std::string& set : sets) key += "/" + set;
      for (char& c : name) {
        if (c == ' ' || c == ',') c = '_';
      }
      jobs.push_back({name, key, [point, sets, run, seed = config.seed] {
                        return run_point(point, sets, run, seed);
                      }});
    }
  }
  return jobs;
}

std::vector<ScoreRow> study_rows(const std::vector<ScoreRow>& rows, const StudiesConfig& config) {
  std::vector<ScoreRow> pooled;
  for (const StudyPoint& point : study_points(config.quick)) {
    for (const StudyMethod& method : point.methods) add_group(point, method, rows, config, pooled);
  }
  return pooled;
}

std::vector<LinePlot> study_plots(const std::vector<ScoreRow>& rows) {
  std::vector<LinePlot> plots;
  for (const std::string& axis : axes()) {
    if (study_label(axis).empty()) continue;
    for (const StudyMetric& metric : kMetrics) {
      if (*metric.shown == 0) continue;
      LinePlot plot = plot_of(rows, axis, metric);
      const bool has_line = std::any_of(plot.series.begin(), plot.series.end(),
                                        [](const LineSeries& s) { return s.points.size() > 1; });
      if (has_line) plots.push_back(std::move(plot));
    }
  }
  return plots;
}

std::vector<ErrorTimeCurve> study_times(const std::vector<ScoreRow>& rows) {
  ErrorTimeCurve curve;
  curve.title = "Projection error over seconds, by the number of photographs";
  curve.metric = "projection error, RMS";
  curve.unit = "px";
  for (const ScoreRow& row : rows) {
    if (is_study_row(row) && row.scene == "images" && row.metric == "projection.rms" &&
        row.value > 0 && row.wall_s > 0)
      curve.points.push_back(
          {row.method, row.case_name, row.wall_s, {row.value, row.ci_low, row.ci_high}});
  }
  if (curve.points.empty()) return {};
  return {curve};
}

}  // namespace cousin
