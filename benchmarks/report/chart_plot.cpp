#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/report/html.h"
#include "benchmarks/report/plots.h"
#include "benchmarks/report/vega_parts.h"

namespace cousin {

using namespace vega_parts;

namespace {

bool has_place(const Chart& chart, const ChartPoint& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && (!chart.log_x || p.x > 0) &&
         (!chart.log_y || p.y > 0);
}

/// Least and most of an axis, with room about them.
struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  Json domain(bool is_log) const {
    if (is_log) return {low / 1.12, high * 1.12};
    const double room = high > low ? 0.05 * (high - low) : std::max(std::abs(high), 1.0) * 0.05;
    return {low - room, high + room};
  }
};

Json scale(const char* name, const char* range, const Range& values, bool is_log) {
  return {{"name", name},   {"type", is_log ? "log" : "linear"},
          {"range", range}, {"domain", values.domain(is_log)},
          {"nice", false},  {"zero", false}};
}

}  // namespace

bool has_points(const Chart& chart) {
  return std::any_of(chart.series.begin(), chart.series.end(), [&](const ChartSeries& s) {
    return std::any_of(s.points.begin(), s.points.end(),
                       [&](const ChartPoint& p) { return has_place(chart, p); });
  });
}

Plot chart_plot(const Chart& chart) {
  Json points = Json::array(), lines = Json::array(), names = Json::array();
  Range x, y;
  for (const ChartSeries& series : chart.series) {
    names.push_back(series.name);
    for (const ChartPoint& p : series.points) {
      if (!has_place(chart, p)) continue;
      x.add(p.x);
      y.add(p.y);
      Json point = {{"x", p.x}, {"y", p.y}, {"series", series.name}};
      if (std::isfinite(p.low) && std::isfinite(p.high) && (!chart.log_y || p.low > 0)) {
        y.add(p.low);
        y.add(p.high);
        point["low"] = p.low;
        point["high"] = p.high;
      }
      point["tip"] =
          series.name + ": " + shown_number(p.x) + ", " + shown_interval({p.y, p.low, p.high}, 1);
      (series.is_line ? lines : points).push_back(std::move(point));
    }
  }
  Json spec = specification(520, 300);
  spec["data"] = {{{"name", "points"}, {"values", points}},
                  {{"name", "lines"}, {"values", lines}},
                  {{"name", "bars"},
                   {"source", "points"},
                   {"transform", {{{"type", "filter"}, {"expr", "isValid(datum.low)"}}}}}};
  spec["scales"] = {
      scale("x", "width", x, chart.log_x),
      scale("y", "height", y, chart.log_y),
      {{"name", "color"}, {"type", "ordinal"}, {"domain", names}, {"range", kPalette}}};
  spec["axes"] = {axis("x", "bottom", chart.x_title), axis("y", "left", chart.y_title)};
  spec["legends"].push_back(legend("fill", "color"));
  spec["marks"].push_back(
      {{"type", "group"},
       {"from", {{"facet", {{"name", "each"}, {"data", "lines"}, {"groupby", "series"}}}}},
       {"marks",
        {{{"type", "line"},
          {"from", {{"data", "each"}}},
          {"encode",
           {{"enter",
             {{"x", field("x", "x")},
              {"y", field("y", "y")},
              {"stroke", field("color", "series")},
              {"strokeWidth", value(1.5)}}}}}}}}});
  spec["marks"].push_back(rule({{"x", field("x", "x")},
                                {"y", field("y", "low")},
                                {"y2", field("y", "high")},
                                {"stroke", field("color", "series")}},
                               "bars"));
  spec["marks"].push_back({{"type", "symbol"},
                           {"from", {{"data", "points"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "x")},
                               {"y", field("y", "y")},
                               {"size", value(45)},
                               {"fill", field("color", "series")},
                               {"tooltip", {{"field", "tip"}}}}}}}});
  return {chart.title, chart.caption, std::move(spec)};
}

}  // namespace cousin
