#include "benchmarks/suites/seeds/trained_plots.h"

#include <algorithm>
#include <map>
#include <string>

#include "benchmarks/loop/score_seeds.h"

namespace cousin {
namespace {

struct Kind {
  const char* metric;
  const char* views;
};
constexpr Kind kKinds[] = {{"train.psnr_whole_small", "views trained on"},
                           {"held_out.psnr_whole_small", "views held out"}};

/// The photographs as a title says them: steps tell one training's points apart.
std::string title_of(const ScoreRow& row) {
  ScoreSettings photographs = row;
  photographs.steps = 0;
  return case_text(row.scene, photographs);
}

void add_point(const ScoreRow& row, LinePlot& plot) {
  auto series = std::find_if(plot.series.begin(), plot.series.end(),
                             [&](const LineSeries& s) { return s.name == row.method; });
  if (series == plot.series.end()) {
    plot.series.push_back({.name = row.method});
    series = plot.series.end() - 1;
  }
  series->points.push_back({row.wall_s, {row.value, row.ci_low, row.ci_high}});
}

}  // namespace

std::vector<LinePlot> trained_plots(const std::vector<ScoreRow>& rows) {
  std::vector<LinePlot> plots;
  for (const Kind& kind : kKinds) {
    std::map<std::string, LinePlot> of_captures;
    for (const ScoreRow& row : rows) {
      if (row.metric != kind.metric || !(row.wall_s > 0)) continue;
      // Where COLMAP's points are the start, its seconds are of poses, and there is one point each.
      if (is_posed_by_tracks(row)) continue;
      const std::string capture = title_of(row);
      LinePlot& plot = of_captures[capture];
      plot.section = "PSNR over time";
      plot.title = capture + ": PSNR over training time, " + kind.views;
      plot.caption = {
          "Whole photographs, green screen black, at a third of their size.",
          "Seconds of Gaussians include those that find where they begin.",
          "Points on the way are means of ten or twenty photographs, ends of Gaussians of all."};
      plot.x_label = "wall time of training (s)";
      plot.y_label = "PSNR (dB)";
      plot.log_x = true;
      add_point(row, plot);
    }
    for (auto& [capture, plot] : of_captures) {
      for (LineSeries& series : plot.series) {
        std::sort(series.points.begin(), series.points.end(),
                  [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
      }
      plots.push_back(std::move(plot));
    }
  }
  return plots;
}

}  // namespace cousin
