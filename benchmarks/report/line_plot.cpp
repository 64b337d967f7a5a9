#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/report/plots.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/report/vega_parts.h"

namespace cousin {

using namespace vega_parts;

namespace {

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  void add(double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  /// With room about it; a logarithmic axis needs positive ends.
  Json domain(bool is_log) const {
    if (!(low <= high)) return {is_log ? 0.1 : 0.0, 1.0};
    if (is_log) return {low / 1.2, high * 1.2};
    const double room = high > low ? 0.06 * (high - low) : std::max(1e-12, 0.1 * std::abs(high));
    return {low - room, high + room};
  }
};

bool can_show(const PlotPoint& p, const LinePlot& plot) {
  return std::isfinite(p.x) && std::isfinite(p.y.value) && (!plot.log_x || p.x > 0) &&
         (!plot.log_y || p.y.value > 0);
}

Json scale_of(const char* name, const char* range, bool is_log, const Range& values) {
  return {{"name", name},   {"type", is_log ? "log" : "linear"},
          {"range", range}, {"domain", values.domain(is_log)},
          {"zero", false},  {"nice", false}};
}

Json lines_of(const char* data, const Json& dash) {
  return {{"type", "group"},
          {"from", {{"facet", {{"name", "series"}, {"data", data}, {"groupby", "name"}}}}},
          {"marks",
           {{{"type", "line"},
             {"from", {{"data", "series"}}},
             {"encode",
              {{"enter",
                {{"x", field("x", "x")},
                 {"y", field("y", "y")},
                 {"stroke", field("color", "name")},
                 {"strokeDash", value(dash)},
                 {"strokeWidth", value(1.5)}}}}}}}}};
}

}  // namespace

Plot line_plot(const LinePlot& plot) {
  Json points = Json::array(), laws = Json::array(), names = Json::array(), colors = Json::array();
  Range xs, ys;
  for (const LineSeries& series : plot.series) {
    const std::size_t color = series.color.value_or(names.size());
    names.push_back(series.name);
    colors.push_back(kPalette[color % kPalette.size()]);
    for (const PlotPoint& p : series.points) {
      if (!can_show(p, plot)) continue;
      Json point = {
          {"x", p.x},
          {"y", p.y.value},
          {"name", series.name},
          {"joined", series.is_joined},
          {"tip", series.name + ": " + shown_interval(p.y, 1) + " at " + shown_number(p.x)}};
      xs.add(p.x);
      ys.add(p.y.value);
      if (std::isfinite(p.y.low) && std::isfinite(p.y.high) && (!plot.log_y || p.y.low > 0)) {
        point["low"] = p.y.low;
        point["high"] = p.y.high;
        ys.add(p.y.low);
        ys.add(p.y.high);
      }
      (series.is_law ? laws : points).push_back(std::move(point));
    }
  }
  Json spec = specification(440, 280);
  spec["data"] = {{{"name", "points"}, {"values", points}},
                  {{"name", "laws"}, {"values", laws}},
                  {{"name", "bars"},
                   {"source", "points"},
                   {"transform", {{{"type", "filter"}, {"expr", "isValid(datum.low)"}}}}},
                  {{"name", "joined"},
                   {"source", "points"},
                   {"transform", {{{"type", "filter"}, {"expr", "datum.joined"}}}}}};
  spec["scales"] = {scale_of("x", "width", plot.log_x, xs),
                    scale_of("y", "height", plot.log_y, ys),
                    {{"name", "color"}, {"type", "ordinal"}, {"domain", names}, {"range", colors}}};
  spec["axes"] = {axis("x", "bottom", plot.x_label), axis("y", "left", plot.y_label)};
  spec["legends"].push_back(legend("fill", "color"));
  spec["marks"].push_back(lines_of("laws", {5, 4}));
  spec["marks"].push_back(lines_of("joined", {1, 0}));
  spec["marks"].push_back(rule({{"x", field("x", "x")},
                                {"y", field("y", "low")},
                                {"y2", field("y", "high")},
                                {"stroke", field("color", "name")},
                                {"strokeOpacity", value(0.6)}},
                               "bars"));
  spec["marks"].push_back({{"type", "symbol"},
                           {"from", {{"data", "points"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "x")},
                               {"y", field("y", "y")},
                               {"size", value(36)},
                               {"fill", field("color", "name")},
                               {"tooltip", {{"field", "tip"}}}}}}}});
  return {plot.title, plot.caption, std::move(spec)};
}

}  // namespace cousin
