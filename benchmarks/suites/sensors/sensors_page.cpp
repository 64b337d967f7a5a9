#include "benchmarks/suites/sensors/sensors_page.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace cousin {
namespace {

/// The number that stands behind `words` in a case's name.
std::optional<double> number_after(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  if (at == std::string::npos) return std::nullopt;
  const char* begin = text.c_str() + at + words.size();
  char* end = nullptr;
  const double value = std::strtod(begin, &end);
  return end == begin ? std::nullopt : std::optional(value);
}

bool is_plain_wall(const std::string& name) {
  return name.find(", wall at ") != std::string::npos && name.find("fast model") == name.npos &&
         name.find(", light") == name.npos && name.find(", turned") == name.npos;
}

/// Where a row stands on a plot's axis; nothing if it is not on it.
using Axis = std::function<std::optional<double>(const std::string& case_name)>;

std::optional<double> by_distance(const std::string& name) {
  return is_plain_wall(name) ? number_after(name, "wall at ") : std::nullopt;
}
std::optional<double> by_light(const std::string& name) {
  return name.find("fast model") == name.npos ? number_after(name, ", light ") : std::nullopt;
}
std::optional<double> by_incidence(const std::string& name) {
  return name.find("fast model") == name.npos ? number_after(name, ", turned ") : std::nullopt;
}

struct Rows {
  const std::vector<ScoreRow>& all;

  /// A series a sensor of one metric; `factor` times the rows' SI.
  std::map<std::string, LineSeries> series(const std::string& metric, const Axis& axis,
                                           double factor) const {
    std::map<std::string, LineSeries> found;
    for (const ScoreRow& row : all) {
      if (row.suite != "sensors" || row.metric != metric || !std::isfinite(row.value)) continue;
      const auto x = axis(row.case_name);
      if (!x) continue;
      LineSeries& s = found[row.scene];
      s.name = row.scene;
      s.points.push_back({*x, {factor * row.value, factor * row.ci_low, factor * row.ci_high}});
    }
    for (auto& [name, s] : found) {
      std::stable_sort(s.points.begin(), s.points.end(),
                       [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
    }
    return found;
  }

  double value(const std::string& sensor, const std::string& metric) const {
    for (const ScoreRow& row : all) {
      if (row.suite == "sensors" && row.scene == sensor && row.metric == metric) return row.value;
    }
    return std::nan("");
  }
};

/// All sensors on one plot.
void add_together(std::vector<LinePlot>& plots, const Rows& rows, const std::string& metric,
                  const Axis& axis, double factor, LinePlot plot) {
  for (auto& [name, series] : rows.series(metric, axis, factor))
    plot.series.push_back(std::move(series));
  if (!plot.series.empty()) plots.push_back(std::move(plot));
}

void add_photon_transfer(std::vector<LinePlot>& plots, const Rows& rows) {
  const Axis axis = [](const std::string& name) {
    return number_after(name, "photon transfer at ");
  };
  for (auto& [sensor, measured] : rows.series("variance", axis, 1)) {
    // Rows state the slope and what it is off the model's; so the model's.
    const double k = rows.value(sensor, "slope") / (1 + rows.value(sensor, "slope.relative_error"));
    const double dark =
        rows.value(sensor, "intercept") / (1 + rows.value(sensor, "intercept.relative_error"));
    LineSeries law{"K mean + dark variance, by the model", {}, true};
    for (const PlotPoint& p : measured.points) law.points.push_back({p.x, {k * p.x + dark}});
    measured.name = "measured";
    plots.push_back({"Photon transfer, " + sensor,
                     {"Half the variance of the difference of two flat frames [EMVA 1288]."},
                     "mean above black (DN)",
                     "temporal variance (DN²)",
                     true,
                     true,
                     {std::move(measured), std::move(law)}});
  }
}

void add_depth_noise(std::vector<LinePlot>& plots, const Rows& rows) {
  for (auto& [sensor, measured] : rows.series("sigma_z", by_distance, 1e3)) {
    const PlotPoint nearest = measured.points.front();
    LineSeries law{"Z² through the nearest", {}, true};
    for (const PlotPoint& p : measured.points)
      law.points.push_back({p.x, {nearest.y.value * std::pow(p.x / nearest.x, 2)}});
    measured.name = "measured";
    plots.push_back({"Depth noise over distance, " + sensor,
                     {"RMS of one frame's depth about its mean over a flat wall."},
                     "distance (m)",
                     "σ of depth (mm)",
                     true,
                     true,
                     {std::move(measured), std::move(law)}});
  }
  const auto spatial = rows.series("spatial_d", by_distance, 1);
  const auto temporal = rows.series("temporal_d", by_distance, 1);
  for (const auto& [sensor, s] : spatial) {
    LinePlot plot{"Spatial and temporal noise, " + sensor,
                  {"Spatial noise stays from frame to frame; averaging takes the temporal alone."},
                  "distance (m)",
                  "RMS of disparity (px)",
                  true,
                  false,
                  {}};
    plot.series.push_back({"spatial", s.points, false});
    if (temporal.contains(sensor))
      plot.series.push_back({"temporal", temporal.at(sensor).points, false});
    plots.push_back(std::move(plot));
  }
}

}  // namespace

std::vector<LinePlot> sensors_plots(const std::vector<ScoreRow>& all) {
  const Rows rows{all};
  std::vector<LinePlot> plots;
  add_photon_transfer(plots, rows);
  add_depth_noise(plots, rows);
  const auto fill = [](const char* over, const char* x_label, bool log_x) {
    return LinePlot{std::string("Fill over ") + over,
                    {"Share of the wall's pixels with a depth."},
                    x_label,
                    "fill (%)",
                    log_x,
                    false,
                    {}};
  };
  add_together(plots, rows, "fill", by_distance, 100, fill("distance", "distance (m)", true));
  add_together(plots, rows, "fill", by_light, 100,
               fill("light", "ambient infrared (share of full sunlight)", false));
  add_together(plots, rows, "fill", by_incidence, 100, fill("incidence", "incidence (°)", false));
  add_together(plots, rows, "ripple_d", by_incidence, 1,
               {"Sub-pixel ripple",
                {"Amplitude of the disparity's error that goes with its fraction."},
                "incidence (°)",
                "ripple (px)",
                false,
                false,
                {}});
  return plots;
}

}  // namespace cousin
