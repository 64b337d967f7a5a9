#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/report/plots.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/report/vega_parts.h"

namespace cousin {

using namespace vega_parts;

namespace {

/// The points that a logarithmic axis has a place for.
Json error_time_points(const ErrorTimeCurve& curve, const ShownUnit& unit) {
  const std::vector<bool> front = pareto_front(curve.points);
  Json points = Json::array();
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const ErrorTimePoint& p = curve.points[i];
    if (!(p.error.value > 0)) continue;
    Json point = {
        {"s", p.wall_s},
        {"e", unit.factor * p.error.value},
        {"method", p.method},
        {"setting", p.setting},
        {"front", static_cast<bool>(front[i])},
        {"tip", p.method + ", " + p.setting + ": " + shown_interval(p.error, unit.factor) + " " +
                    unit.name + " in " + shown_number(p.wall_s) + " s"}};
    if (p.error.low > 0 && std::isfinite(p.error.high)) {
      point["low"] = unit.factor * p.error.low;
      point["high"] = unit.factor * p.error.high;
    }
    points.push_back(std::move(point));
  }
  return points;
}

std::vector<std::string> methods_of_curve(const ErrorTimeCurve& curve) {
  std::vector<std::string> methods;
  for (const ErrorTimePoint& p : curve.points) {
    if (std::find(methods.begin(), methods.end(), p.method) == methods.end())
      methods.push_back(p.method);
  }
  return methods;
}

Json error_time_data(const Json& points) {
  return {{{"name", "points"}, {"values", points}},
          {{"name", "bars"},
           {"source", "points"},
           {"transform", {{{"type", "filter"}, {"expr", "isValid(datum.low)"}}}}},
          {{"name", "front"},
           {"source", "points"},
           {"transform",
            {{{"type", "filter"}, {"expr", "datum.front"}},
             {{"type", "collect"}, {"sort", {{"field", "s"}}}}}}},
          {{"name", "sorted"},
           {"source", "points"},
           {"transform", {{{"type", "collect"}, {"sort", {{"field", "s"}}}}}}}};
}

Json error_time_scales(const Json& points, const std::vector<std::string>& methods) {
  // The axis leaves room left and right of the points: half of the smallest time to twice the
  // largest.
  double fastest = std::numeric_limits<double>::infinity();
  double slowest = 0;
  double least = fastest;
  double most = 0;
  for (const Json& p : points) {
    fastest = std::min(fastest, p["s"].get<double>());
    slowest = std::max(slowest, p["s"].get<double>());
    least = std::min(least, p.value("low", p["e"].get<double>()));
    most = std::max(most, p.value("high", p["e"].get<double>()));
  }
  return {{{"name", "x"},
           {"type", "log"},
           {"range", "width"},
           {"domain", {fastest / 1.4, slowest * 1.8}},
           {"nice", false}},
          {{"name", "y"},
           {"type", "log"},
           {"range", "height"},
           {"domain", {least / 1.2, most * 1.2}},
           {"nice", false}},
          {{"name", "color"}, {"type", "ordinal"}, {"domain", methods}, {"range", kPalette}}};
}

Json error_time_axes(const std::string& error) {
  Json axes = {axis("x", "bottom", "wall time (s)"), axis("y", "left", error)};
  // 1, 2 and 5 of each decade are labelled.
  for (Json& a : axes) {
    a["encode"] = {
        {"labels",
         {{"update",
           {{"text",
             {{"signal",
               "indexof([1,2,5], round(datum.value / pow(10, floor(log(datum.value)/LN10 + "
               "1e-9)))) >= 0 ? format(datum.value, '~r') : ''"}}}}}}}};
  }
  return axes;
}

/// The Pareto front's steps, and a line through the points of each method.
void add_error_time_lines(Json& spec) {
  spec["marks"].push_back({{"type", "line"},
                           {"from", {{"data", "front"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "s")},
                               {"y", field("y", "e")},
                               {"interpolate", value("step-after")},
                               {"stroke", {{"signal", "muted"}}},
                               {"strokeDash", value({5, 4})},
                               {"strokeWidth", value(1.5)}}}}}});
  spec["marks"].push_back(
      {{"type", "group"},
       {"from", {{"facet", {{"name", "series"}, {"data", "sorted"}, {"groupby", "method"}}}}},
       {"marks",
        {{{"type", "line"},
          {"from", {{"data", "series"}}},
          {"encode",
           {{"enter",
             {{"x", field("x", "s")},
              {"y", field("y", "e")},
              {"stroke", field("color", "method")},
              {"strokeWidth", value(1.5)}}}}}}}}});
}

void add_error_time_symbols(Json& spec) {
  spec["marks"].push_back(rule({{"x", field("x", "s")},
                                {"y", field("y", "low")},
                                {"y2", field("y", "high")},
                                {"stroke", field("color", "method")},
                                {"strokeOpacity", value(0.6)}},
                               "bars"));
  spec["marks"].push_back({{"type", "symbol"},
                           {"from", {{"data", "points"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "s")},
                               {"y", field("y", "e")},
                               {"size", value(60)},
                               {"fill", field("color", "method")},
                               {"tooltip", {{"field", "tip"}}}}},
                             {"update",
                              {{"stroke", {{"test", "datum.front"}, {"signal", "ink"}}},
                               {"strokeWidth", value(1.5)}}}}}});
  spec["marks"].back()["encode"]["update"]["stroke"] =
      Json::array({{{"test", "datum.front"}, {"signal", "ink"}}, {{"value", "transparent"}}});
  spec["marks"].push_back({{"type", "text"},
                           {"from", {{"data", "points"}}},
                           {"encode",
                            {{"update",
                              {{"x", {{"scale", "x"}, {"field", "s"}, {"offset", 7}}},
                               {"y", {{"scale", "y"}, {"field", "e"}, {"offset", -7}}},
                               {"text", {{"field", "setting"}}},
                               {"fontSize", value(10)},
                               {"fill", ink()}}}}}});
}

/// Levels of the error, and the stages in their order.
struct WaterfallBars {
  Json bars = Json::array();
  Json order = Json::array();
};

WaterfallBars waterfall_bars(const Attribution& attribution, const ShownUnit& unit) {
  WaterfallBars result;
  const auto add = [&](const std::string& stage, double from, double to, const char* color,
                       const std::string& label, const WithInterval& interval) {
    Json bar = {{"stage", stage}, {"from", from}, {"to", to}, {"color", color}, {"label", label}};
    if (std::isfinite(interval.low) && std::isfinite(interval.high)) {
      bar["low"] = unit.factor * interval.low;
      bar["high"] = unit.factor * interval.high;
    }
    result.bars.push_back(std::move(bar));
    result.order.push_back(stage);
  };
  const auto& steps = attribution.steps;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double level = unit.factor * steps[i].error.value;
    if (i == 0) {
      add(steps[0].stage, 0, level, kTotal, shown_number(level), steps[0].error);
      continue;
    }
    const double before = unit.factor * steps[i - 1].error.value;
    add("true " + steps[i].stage, before, level, level <= before ? kGood : kBad,
        (level > before ? "+" : "−") + shown_number(std::abs(level - before)), steps[i].error);
  }
  if (steps.size() > 1) {
    const double rest = unit.factor * steps.back().error.value;
    add("what remains", 0, rest, kTotal, shown_number(rest), steps.back().error);
  }
  return result;
}

void add_waterfall_marks(Json& spec) {
  spec["marks"].push_back({{"type", "rect"},
                           {"from", {{"data", "bars"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "stage")},
                               {"width", {{"scale", "x"}, {"band", 1}}},
                               {"y", field("y", "from")},
                               {"y2", field("y", "to")},
                               {"fill", {{"field", "color"}}},
                               {"fillOpacity", value(0.85)}}}}}});
  spec["marks"].push_back({{"type", "rule"},
                           {"from", {{"data", "intervals"}}},
                           {"encode",
                            {{"update",
                              {{"x", {{"scale", "x"}, {"field", "stage"}, {"band", 0.5}}},
                               {"y", field("y", "low")},
                               {"y2", field("y", "high")},
                               {"stroke", ink()}}}}}});
  spec["marks"].push_back(
      {{"type", "text"},
       {"from", {{"data", "bars"}}},
       {"encode",
        {{"update",
          {{"x", {{"scale", "x"}, {"field", "stage"}, {"band", 0.5}}},
           {"y",
            {{"scale", "y"},
             {"signal", "max(datum.from, datum.to, isValid(datum.high) ? datum.high : 0)"},
             {"offset", -5}}},
           {"align", value("center")},
           {"text", {{"field", "label"}}},
           {"fontSize", value(11)},
           {"fill", ink()}}}}}});
}

}  // namespace

Plot error_time_plot(const ErrorTimeCurve& curve) {
  const ShownUnit unit = shown_unit(curve.unit, curve.metric);
  const Json points = error_time_points(curve, unit);
  Json spec = specification(560, 300);
  spec["data"] = error_time_data(points);
  spec["scales"] = error_time_scales(points, methods_of_curve(curve));
  spec["axes"] = error_time_axes(with_unit(curve.metric, unit.name));
  spec["legends"].push_back(legend("fill", "color"));
  add_error_time_lines(spec);
  add_error_time_symbols(spec);
  return {curve.title,
          {"Each point is one setting of a method; bars are 95 % intervals. Ringed points and the "
           "dashed line are the "
           "Pareto front: no other setting is both faster and better."},
          std::move(spec)};
}

Plot waterfall_plot(const Attribution& attribution) {
  const ShownUnit unit = shown_unit(attribution.unit, attribution.metric);
  const auto [bars, order] = waterfall_bars(attribution, unit);
  Json spec = specification(std::max(320, 78 * static_cast<int>(order.size())), 260);
  spec["data"] = {{{"name", "bars"}, {"values", bars}},
                  {{"name", "intervals"},
                   {"source", "bars"},
                   {"transform", {{{"type", "filter"}, {"expr", "isValid(datum.low)"}}}}}};
  spec["scales"] = {
      {{"name", "x"}, {"type", "band"}, {"range", "width"}, {"domain", order}, {"padding", 0.25}},
      linear_scale("y", "height",
                   {{"fields",
                     {{{"data", "bars"}, {"field", "from"}},
                      {{"data", "bars"}, {"field", "to"}},
                      {{"data", "intervals"}, {"field", "high"}}}}},
                   true)};
  spec["scales"][1]["nice"] = true;
  spec["axes"] = {axis("x", "bottom", "truth put in place of, one after another"),
                  axis("y", "left", with_unit(attribution.metric, unit.name))};
  spec["axes"][0]["grid"] = false;
  spec["axes"][0]["labelOverlap"] = false;
  spec["axes"][0]["labelLimit"] = 76;
  add_waterfall_marks(spec);
  return {attribution.title,
          {"The first bar is the pipeline as it is. Each next one has truth in that seam and in "
           "all before it, and shows "
           "how much error goes away; what remains belongs to the last stage. Lines are 95 % "
           "intervals of the level."},
          std::move(spec)};
}

Plot timing_plot(const std::vector<StageTiming>& timings) {
  Json bars = Json::array();
  Json order = Json::array();
  double total = 0;
  for (const StageTiming& t : timings) {
    bars.push_back({{"stage", t.stage}, {"kind", "wall"}, {"s", t.wall_s}});
    bars.push_back({{"stage", t.stage}, {"kind", "CPU"}, {"s", t.cpu_s}});
    order.push_back(t.stage);
    total += t.wall_s;
  }
  Json spec = specification(560, std::max(80, 30 * static_cast<int>(order.size())));
  spec["data"].push_back({{"name", "bars"}, {"values", bars}});
  spec["scales"] = {
      linear_scale("x", "width", {{"data", "bars"}, {"field", "s"}}, true),
      {{"name", "y"}, {"type", "band"}, {"range", "height"}, {"domain", order}, {"padding", 0.2}},
      {{"name", "color"}, {"type", "ordinal"}, {"domain", {"wall", "CPU"}}, {"range", kPalette}}};
  spec["scales"][0]["nice"] = true;
  spec["axes"] = {axis("x", "bottom", "seconds"), axis("y", "left", "")};
  spec["axes"][1]["grid"] = false;
  spec["axes"][1].erase("title");
  spec["axes"][1]["labelLimit"] = 220;
  spec["legends"].push_back(legend("fill", "color"));
  const Json half = {{"signal", "bandwidth('y') / 2"}};
  const Json y = {{"scale", "y"},
                  {"field", "stage"},
                  {"offset", {{"signal", "datum.kind == 'CPU' ? bandwidth('y') / 2 : 0"}}}};
  spec["marks"].push_back({{"type", "rect"},
                           {"from", {{"data", "bars"}}},
                           {"encode",
                            {{"enter",
                              {{"x", {{"scale", "x"}, {"value", 0}}},
                               {"x2", field("x", "s")},
                               {"y", y},
                               {"height", half},
                               {"fill", field("color", "kind")}}}}}});
  spec["marks"].push_back(
      {{"type", "text"},
       {"from", {{"data", "bars"}}},
       {"encode",
        {{"update",
          {{"x", {{"scale", "x"}, {"field", "s"}, {"offset", 4}}},
           {"y",
            {{"scale", "y"},
             {"field", "stage"},
             {"offset", {{"signal", "bandwidth('y') * (datum.kind == 'CPU' ? 0.75 : 0.25)"}}}}},
           {"baseline", value("middle")},
           {"text", {{"signal", "format(datum.s, '.3~r')"}}},
           {"fontSize", value(10)},
           {"fill", ink()}}}}}});
  return {
      "Time of each stage", {"Total " + shown_number(total) + " s of wall time."}, std::move(spec)};
}

}  // namespace cousin
