#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "benchmarks/suites/calibration/fruit_positions.h"
#include "benchmarks/suites/calibration/studies.h"

namespace cousin {
namespace {

/// The scenes of rows that the plots are of.
constexpr const char* kCauses = "causes of a wrong calibration";
constexpr const char* kPositions = "positions of fruits";

/// Name of a cause without its amount: "paper bent 0.002 m" and "print sheared 0.002" end with a
/// number that may have a unit.
std::string cause_of(std::string name) {
  const std::size_t last = name.find_last_of(' ');
  if (last == std::string::npos) return name;
  const bool has_unit = name[last + 1] < '0' || name[last + 1] > '9';
  name.resize(last);
  return has_unit ? name.substr(0, name.find_last_of(' ')) : name;
}

}  // namespace

std::vector<LinePlot> cause_plots(const std::vector<ScoreRow>& rows) {
  std::map<std::string, double> centre_px;
  for (const ScoreRow& row : rows) {
    if (row.scene == kCauses && row.metric == "principal point, RMS distance")
      centre_px[row.case_name] = row.value;
  }
  LinePlot plot;
  plot.title = "How far causes lead p1 and the principal point astray";
  plot.section = "The Strawberries calibration";
  plot.caption = {
      "RMS of virtual copies of the paper's calibration, a line a cause, amounts along it.",
      "The paper's own p1 and principal point stand alone at the upper right."};
  plot.x_label = "principal point off by (px)";
  plot.y_label = "p1 off by";
  plot.log_x = plot.log_y = true;
  for (const ScoreRow& row : rows) {
    if (row.scene != kCauses || row.metric != "p1, RMS error" || !(row.value > 0)) continue;
    const double x = centre_px[row.case_name];
    if (!(x > 0)) continue;
    const std::string name = cause_of(row.case_name);
    if (plot.series.empty() || plot.series.back().name != name)
      plot.series.push_back({name, {}, false, true});
    plot.series.back().points.push_back({x, {row.value}});
  }
  if (plot.series.empty()) return {};
  for (LineSeries& series : plot.series) {
    std::sort(series.points.begin(), series.points.end(),
              [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
  }
  // Against the D457's maker: p1 -.001, principal point in the middle.
  plot.series.push_back(
      {"the paper's", {{std::hypot(309.722 - 319.5, 266.262 - 239.5), {0.016}}}, false, false});
  return {plot};
}

std::vector<LinePlot> position_plots(const std::vector<ScoreRow>& rows) {
  struct Line {
    const char *name, *unit_name, *method;
  };
  constexpr std::array<Line, 7> kLines = {
      {{"published", "published", "the Strawberries paper"},
       {"as the paper, unit as made", "unit as made", "as the paper"},
       {"as the paper, unit off by 0.45 px", "unit off by 0.45 px", "as the paper"},
       {"held under the box, unit as made", "unit as made", kHeldUnderBox},
       {"held under the box, unit off by 0.45 px", "unit off by 0.45 px", kHeldUnderBox},
       {"stereo noise alone", "unit as made", "share of the stereo noise"},
       {"tape alone", "unit as made", "share of the tape"}}};
  constexpr std::array<std::pair<const char*, double>, 3> kBins = {
      {{", 0.3 to 0.4 m", 35}, {", 0.4 to 0.5 m", 45}, {", 0.5 to 0.6 m", 55}}};
  std::vector<LinePlot> plots;
  for (const char* coordinate : {"x", "y", "z", "range"}) {
    LinePlot plot;
    plot.title = std::string("Positions of fruits: error of ") + coordinate;
    plot.section = "The Strawberries positions";
    plot.caption = {"RMSE over the points of each 10 cm, with its 95 % interval where it is ours."};
    plot.x_label = "distance (cm)";
    plot.y_label = std::string("RMSE of ") + coordinate + " (mm)";
    for (const Line& line : kLines) {
      LineSeries series{line.name, {}, false, true};
      for (const auto& [bin, x_cm] : kBins) {
        for (const ScoreRow& row : rows) {
          if (row.scene == kPositions && row.method == line.method &&
              row.case_name == std::string(line.unit_name) + bin &&
              row.metric == std::string(coordinate) + ".rmse")
            series.points.push_back({x_cm, {1e3 * row.value, 1e3 * row.ci_low, 1e3 * row.ci_high}});
        }
      }
      if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    if (plot.series.size() > 1) plots.push_back(std::move(plot));
  }
  return plots;
}

}  // namespace cousin
