#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "benchmarks/suites/calibration/studies.h"
#include "benchmarks/suites/calibration/study_points.h"
#include "benchmarks/suites/calibration/study_run.h"

namespace cousin {
namespace {

constexpr const char* kSuite = "calibration";

bool is_study_row(const ScoreRow& row) {
  return row.suite == kSuite && !row.case_name.empty() &&
         row.case_name.find(" run ") == std::string::npos;
}

/// Where lines cross that of the device's own lens, in words.
std::vector<std::string> crossing_lines(const std::vector<ScoreRow>& rows, const std::string& axis,
                                        const StudyMetric& metric) {
  std::vector<std::string> lines;
  for (const ScoreRow& row : rows) {
    const bool is_drift = row.metric == std::string(metric.name) + ".crossing";
    const bool is_count = row.metric == std::string(metric.name) + ".fewest photographs";
    if (row.scene != axis || (!is_drift && !is_count)) continue;
    char text[160];
    if (!std::isfinite(row.value)) {
      std::snprintf(text, sizeof text, "%s: never beats the device's own lens here.",
                    row.method.c_str());
    } else if (is_count) {
      std::snprintf(text, sizeof text, "%s: beats the device's own lens from %g photographs on.",
                    row.method.c_str(), row.value);
    } else {
      std::snprintf(text, sizeof text, "%s: beats the device's own lens beyond %.3g %s.",
                    row.method.c_str(), row.value, row.unit.c_str());
    }
    lines.emplace_back(text);
  }
  return lines;
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
  for (const std::string& line : crossing_lines(rows, axis, metric)) plot.caption.push_back(line);
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

std::vector<LinePlot> study_plots(const std::vector<ScoreRow>& rows) {
  std::vector<LinePlot> plots = cause_plots(rows);
  for (LinePlot& plot : position_plots(rows)) plots.push_back(std::move(plot));
  for (const std::string& axis : axes()) {
    if (study_label(axis).empty()) continue;
    for (const StudyMetric& metric : study_metrics()) {
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
