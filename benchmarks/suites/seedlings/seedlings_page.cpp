#include "benchmarks/suites/seedlings/seedlings_page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "benchmarks/suites/seedlings/field_training.h"
#include "benchmarks/suites/seedlings/published_psnr.h"
#include "benchmarks/suites/seedlings/seedlings_jobs.h"
#include "benchmarks/suites/seedlings/seedlings_rows.h"

namespace cousin {
namespace {

constexpr const char* kTimeSection = "PSNR over time";
constexpr const char* kCoverageSection = "PSNR over view coverage";

/// Of the full set of photographs, over the samples.
bool is_of_all(const ScoreRow& row) {
  return row.run < 0 && row.views == 30 && row.view_set.empty();
}

bool is_mean_of(const ScoreRow& row, const std::string& light, const std::string& metric) {
  return row.suite == kSeedlingsSuite && row.scene == light && row.metric == metric &&
         is_of_all(row) && row.steps > 0 && row.wall_s > 0;
}

std::set<std::string> lights_of(const std::vector<ScoreRow>& rows) {
  std::set<std::string> lights;
  for (const ScoreRow& row : rows) {
    if (row.suite == kSeedlingsSuite) lights.insert(row.scene);
  }
  return lights;
}

/// Of longer trainings there are fewer samples, so their intervals differ in kind.
WithInterval interval_of(const ScoreRow& row) { return {row.value, row.ci_low, row.ci_high}; }

LineSeries published_series(const std::vector<ScoreRow>& rows, const std::string& light) {
  LineSeries series;
  series.name = "published: 3DGS (RTX 4090)";
  for (const ScoreRow& row : rows) {
    if (row.suite == kSeedlingsSuite && row.scene == light && row.method == kPublishedGaussians &&
        row.run < 0)
      series.points.push_back({row.wall_s, interval_of(row)});
  }
  return series;
}

LinePlot time_plot(const std::vector<ScoreRow>& rows, const std::string& light,
                   const std::string& metric, const std::string& what) {
  LinePlot plot;
  plot.section = kTimeSection;
  plot.title = light + ": PSNR of " + what + " over training time";
  plot.caption = {
      "Means over the samples with 95 % intervals where there are several; the longest "
      "trainings are of one."};
  plot.x_label = "wall time of training (s)";
  plot.y_label = "PSNR (dB)";
  plot.log_x = true;
  std::size_t color = 0;
  for (const char* method : {kReference, kOurs, kNgp}) {
    LineSeries series;
    series.name = method;
    series.color = color++;
    for (const ScoreRow& row : rows) {
      if (is_mean_of(row, light, metric) && row.method == method)
        series.points.push_back({row.wall_s, interval_of(row)});
    }
    if (!series.points.empty()) plot.series.push_back(std::move(series));
  }
  for (LineSeries& series : plot.series) {
    std::sort(series.points.begin(), series.points.end(),
              [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
  }
  if (metric == "train.psnr" && !plot.series.empty()) {
    LineSeries published = published_series(rows, light);
    published.color = color;
    if (!published.points.empty()) plot.series.push_back(std::move(published));
  }
  return plot;
}

/// "20 views", "30 views, one side".
std::string set_of(const ScoreRow& row) {
  return std::to_string(row.views) + " views" + (row.view_set.empty() ? "" : ", " + row.view_set);
}

/// The last snapshot of every set of photographs that all of them have.
int common_steps(const std::vector<ScoreRow>& rows) {
  std::map<std::string, std::set<int>> of_photographs;
  for (const ScoreRow& row : rows) {
    if (row.suite == kSeedlingsSuite && row.method == kReference && row.steps > 0 && row.run >= 0)
      of_photographs[photographs_of(row)].insert(static_cast<int>(row.steps));
  }
  int common = 0;
  for (const auto& [photographs, steps] : of_photographs) {
    for (const int step : steps) {
      const bool all_have = std::all_of(of_photographs.begin(), of_photographs.end(),
                                        [&](const auto& o) { return o.second.contains(step); });
      if (all_have) common = std::max(common, step);
    }
  }
  return common;
}

LinePlot coverage_plot(const std::vector<ScoreRow>& rows, const std::string& metric,
                       const std::string& what) {
  const int steps = common_steps(rows);
  LinePlot plot;
  plot.section = kCoverageSection;
  plot.title = "PSNR of " + what + " over view coverage";
  plot.caption = {"Each point is a sample under a light, by the reference's schedule after " +
                  std::to_string(steps) + " steps."};
  plot.x_label =
      "held-out pixels whose surface at least " + std::to_string(kEnoughViews) + " views see (%)";
  plot.y_label = "PSNR (dB)";
  std::map<std::string, LineSeries> by_set;
  for (const ScoreRow& covered : rows) {
    if (covered.suite != kSeedlingsSuite || covered.run < 0 ||
        covered.metric != "coverage.seen_by_" + std::to_string(kEnoughViews))
      continue;
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& r) {
      return r.suite == kSeedlingsSuite && r.method == kReference && r.metric == metric &&
             r.steps == steps && photographs_of(r) == photographs_of(covered);
    });
    if (row == rows.end()) continue;
    const std::string name = set_of(covered);
    LineSeries& series = by_set[name];
    series.name = name;
    series.is_joined = false;
    series.points.push_back({100 * covered.value, interval_of(*row)});
  }
  for (auto& [name, series] : by_set) {
    std::sort(series.points.begin(), series.points.end(),
              [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
    plot.series.push_back(std::move(series));
  }
  return plot;
}

/// PSNR of ours over the number of photographs that it was trained on.
LinePlot views_plot(const std::vector<ScoreRow>& rows) {
  LinePlot plot;
  plot.section = kCoverageSection;
  plot.title = "PSNR over the number of views trained on";
  plot.caption = {"The first tray under each light, ours after " + std::to_string(kMoreViewsSteps) +
                  " steps; each view at the exposure that fits it best. Every fifth of each "
                  "number's own places is held out, so that the held-out views differ."};
  plot.x_label = "views trained on";
  plot.y_label = "PSNR (dB)";
  for (const std::string& light : lights_of(rows)) {
    for (const auto& [metric, what] : {std::pair{"held_out.psnr_exposed", "held-out views"},
                                       std::pair{"train.psnr_exposed", "views trained on"}}) {
      LineSeries series;
      series.name = light + ", " + what;
      for (const ScoreRow& row : rows) {
        if (row.suite != kSeedlingsSuite || row.scene != light || row.method != kOurs ||
            row.metric != metric || row.run != 0 || row.steps != kMoreViewsSteps ||
            row.views == 0 || !row.view_set.empty())
          continue;
        series.points.push_back({static_cast<double>(row.views), interval_of(row)});
      }
      if (series.points.size() > 1) plot.series.push_back(std::move(series));
    }
  }
  for (LineSeries& series : plot.series) {
    std::sort(series.points.begin(), series.points.end(),
              [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
  }
  return plot;
}

}  // namespace

std::vector<LinePlot> seedlings_plots(const std::vector<ScoreRow>& rows) {
  std::vector<LinePlot> plots;
  const auto add = [&](LinePlot plot) {
    if (!plot.series.empty()) plots.push_back(std::move(plot));
  };
  for (const std::string& light : lights_of(rows)) {
    add(time_plot(rows, light, "held_out.psnr", "held-out views"));
    add(time_plot(rows, light, "held_out.psnr_exposed",
                  "held-out views, each at the exposure that fits it best"));
    add(time_plot(rows, light, "train.psnr", "views trained on"));
  }
  add(coverage_plot(rows, "held_out.psnr", "held-out views"));
  add(coverage_plot(rows, "train.psnr", "views trained on"));
  add(views_plot(rows));
  return plots;
}

namespace {

/// A number with its interval, as "37.2 [35.9, 38.5]".
std::string cell_of(const ScoreRow* row, int decimals) {
  std::string text = table_cell(row, 1, decimals);
  if (text.empty() || !std::isfinite(row->ci_low) || !std::isfinite(row->ci_high)) return text;
  return text + " [" + table_cell(row->ci_low, 1, decimals) + ", " +
         table_cell(row->ci_high, 1, decimals) + "]";
}

const ScoreRow* row_of(const std::vector<ScoreRow>& rows, const ScoreRow& of,
                       const std::string& metric) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& row) {
    return row.suite == of.suite && photographs_of(row) == photographs_of(of) &&
           row.steps == of.steps && row.method == of.method && row.metric == metric;
  });
  return found == rows.end() ? nullptr : &*found;
}

std::vector<std::string> line_of(const std::vector<ScoreRow>& rows, const ScoreRow& row,
                                 bool is_published) {
  const auto cell = [&](const char* metric, int decimals) {
    return cell_of(row_of(rows, row, metric), decimals);
  };
  return {row.method,
          row.steps > 0 ? std::to_string(row.steps) : "",
          std::to_string(row.n),
          cell(is_published ? "psnr" : "train.psnr", 1),
          cell("held_out.psnr", 1),
          cell("held_out.psnr_exposed", 1),
          cell("held_out.psnr_seedlings", 1),
          cell("held_out.ssim", 3),
          cell("held_out.flip", 3),
          table_cell(row_of(rows, row, "gaussians"), 1, 0),
          table_cell(row.wall_s, 1, 0),
          table_cell(row.cpu_s, 1, 0)};
}

ReportTable table_of_light(const std::vector<ScoreRow>& rows, const std::string& light) {
  ReportTable table{
      "Seedlings, " + light + ": three methods, PSNR in dB",
      "Means over samples, with 95 % intervals where there are several (n). Published: of 12 other "
      "trays, and taken to be of views trained on.",
      {"method", "steps", "n", "trained on", "held out", "held out, best exposure",
       "held out, plants", "SSIM, held out", "FLIP, held out", "Gaussians", "wall s", "CPU s"},
      {}};
  for (const char* method : {kPublishedGaussians, kReference, kOurs, kPublishedNgp, kNgp}) {
    const bool is_published = std::string_view(method).starts_with("published");
    std::vector<const ScoreRow*> of_method;
    for (const ScoreRow& row : rows) {
      const bool is_line = is_published ? row.metric == "psnr" && row.run < 0
                                        : row.metric == "train.psnr" && is_of_all(row);
      if (row.suite == kSeedlingsSuite && row.scene == light && row.method == method && is_line)
        of_method.push_back(&row);
    }
    std::sort(of_method.begin(), of_method.end(),
              [](const ScoreRow* a, const ScoreRow* b) { return a->steps < b->steps; });
    for (const ScoreRow* row : of_method) table.lines.push_back(line_of(rows, *row, is_published));
  }
  return table;
}

ReportTable coverage_table(const std::vector<ScoreRow>& rows) {
  const int steps = common_steps(rows);
  ReportTable table{"Seedlings: what missing views do",
                    "The reference's schedule after " + std::to_string(steps) +
                        " steps, one tray; covered: the true surface is seen by at least " +
                        std::to_string(kEnoughViews) + " of the views trained on.",
                    {"light", "trained on", "held-out pixels covered %", "PSNR trained on",
                     "held out", "of these covered", "not covered"},
                    {}};
  for (const ScoreRow& covered : rows) {
    if (covered.suite != kSeedlingsSuite || covered.run != 0 ||
        covered.metric != "coverage.seen_by_" + std::to_string(kEnoughViews))
      continue;
    ScoreRow of = covered;
    of.method = kReference;
    of.steps = steps;
    const auto cell = [&](const char* metric) {
      return table_cell(row_of(rows, of, metric), 1, 1);
    };
    table.lines.push_back({covered.scene, set_of(covered), table_cell(&covered, 100, 1),
                           cell("train.psnr"), cell("held_out.psnr"), cell("held_out.psnr_covered"),
                           cell("held_out.psnr_uncovered")});
  }
  return table;
}

}  // namespace

std::vector<ReportTable> seedlings_tables(const std::vector<ScoreRow>& rows) {
  std::vector<ReportTable> tables;
  for (const std::string& light : lights_of(rows)) tables.push_back(table_of_light(rows, light));
  if (!tables.empty()) tables.push_back(coverage_table(rows));
  std::erase_if(tables, [](const ReportTable& table) { return table.lines.empty(); });
  return tables;
}

std::vector<ErrorTimeCurve> seedlings_curves(const std::vector<ScoreRow>& rows) {
  std::vector<ErrorTimeCurve> curves;
  for (const std::string& light : lights_of(rows)) {
    ErrorTimeCurve curve{"Seedlings, " + light + ", held-out views",
                         "RMS error of a colour channel, of its range",
                         "1",
                         {}};
    for (const ScoreRow& row : rows) {
      if (!is_mean_of(row, light, "held_out.psnr")) continue;
      const auto error = [](double psnr_db) { return std::pow(10, -psnr_db / 20); };
      curve.points.push_back({row.method,
                              std::to_string(row.steps) + " steps",
                              row.wall_s,
                              {error(row.value), error(row.ci_high), error(row.ci_low)}});
    }
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace cousin
