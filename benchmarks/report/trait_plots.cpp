#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "benchmarks/report/plots.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/report/vega_parts.h"
#include "benchmarks/score/distributions.h"

namespace cousin {
namespace {

using namespace vega_parts;

/// Solved specimens of each trait, in the order of first appearance.
struct TraitRows {
  std::string trait;
  ShownUnit unit;
  std::vector<const SpecimenRow*> rows;
  int not_solved = 0;
};

std::vector<TraitRows> by_trait(const std::vector<SpecimenRow>& rows) {
  std::vector<TraitRows> traits;
  for (const SpecimenRow& row : rows) {
    auto found = std::find_if(traits.begin(), traits.end(),
                              [&](const TraitRows& t) { return t.trait == row.trait; });
    if (found == traits.end())
      found = traits.insert(traits.end(), {row.trait, shown_unit(row.unit), {}, 0});
    if (row.status == ScoreStatus::ok && std::isfinite(row.measured) && std::isfinite(row.truth)) {
      found->rows.push_back(&row);
    } else {
      ++found->not_solved;
    }
  }
  std::erase_if(traits, [](const TraitRows& t) { return t.rows.empty(); });
  return traits;
}

std::vector<std::string> distinct(const std::vector<const SpecimenRow*>& rows,
                                  std::string SpecimenRow::*member) {
  std::vector<std::string> names;
  for (const SpecimenRow* row : rows) {
    if (std::find(names.begin(), names.end(), row->*member) == names.end())
      names.push_back(row->*member);
  }
  return names;
}

/// "ours: RMSE 0.12 [0.10, 0.14] mm, bias 0.01 [...] mm, slope ..., n = 50 in 5 runs", one line a
/// method.
std::vector<std::string> describe(const TraitRows& trait) {
  std::vector<std::string> lines;
  for (const std::string& method : distinct(trait.rows, &SpecimenRow::method)) {
    std::vector<TraitPair> pairs;
    for (const SpecimenRow* row : trait.rows) {
      if (row->method == method) pairs.push_back({row->truth, row->measured, row->sigma, row->run});
    }
    const TraitStatistics s = trait_statistics(pairs, Rng(0).fork("report"));
    const std::string unit = trait.unit.name.empty() ? "" : " " + trait.unit.name;
    lines.push_back((method.empty() ? "" : method + ": ") + "RMSE " +
                    shown_interval(s.rmse, trait.unit.factor) + unit + ", bias " +
                    shown_interval(s.bias, trait.unit.factor) + unit + ", slope " +
                    shown_interval(s.slope, 1) + ", n = " + std::to_string(s.n) + " in " +
                    std::to_string(s.runs) + (s.runs == 1 ? " run" : " runs") +
                    (s.by_run ? "" : " (interval over specimens)"));
  }
  if (trait.not_solved > 0) lines.push_back(std::to_string(trait.not_solved) + " not solved");
  return lines;
}

struct ScatterPoints {
  Json points = Json::array();
  Json domain;  ///< of both axes
};

ScatterPoints scatter_points(const TraitRows& trait) {
  Json points = Json::array();
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const SpecimenRow* row : trait.rows) {
    const double t = trait.unit.factor * row->truth;
    const double m = trait.unit.factor * row->measured;
    Json point = {{"t", t}, {"m", m}, {"method", row->method}, {"cultivar", row->cultivar}};
    point["tip"] = row->cultivar + " " + row->run + " #" + std::to_string(row->instance) +
                   ": true " + shown_number(t) + ", measured " + shown_number(m) + " " +
                   trait.unit.name;
    if (row->sigma > 0 && std::isfinite(row->sigma)) {
      point["low"] = m - kSigmas95 * trait.unit.factor * row->sigma;
      point["high"] = m + kSigmas95 * trait.unit.factor * row->sigma;
    }
    points.push_back(std::move(point));
    low = std::min({low, t, m});
    high = std::max({high, t, m});
  }
  const double margin = std::max(0.06 * (high - low), 1e-3 * std::abs(high));
  return {std::move(points), {low - margin, high + margin}};
}

void add_cultivar_shapes(Json& spec, const std::vector<std::string>& cultivars) {
  spec["scales"].push_back(
      {{"name", "shape"},
       {"type", "ordinal"},
       {"domain", cultivars},
       {"range", {"circle", "square", "triangle-up", "diamond", "cross", "triangle-down"}}});
  if (cultivars.size() > 1) {
    Json shapes = legend("shape", "shape");
    shapes.erase("symbolType");
    shapes["symbolStrokeColor"] = ink();
    spec["legends"].push_back(shapes);
  }
}

void add_scatter_marks(Json& spec, const Json& domain) {
  spec["marks"].push_back(rule({{"x", {{"scale", "x"}, {"value", domain[0]}}},
                                {"y", {{"scale", "y"}, {"value", domain[0]}}},
                                {"x2", {{"scale", "x"}, {"value", domain[1]}}},
                                {"y2", {{"scale", "y"}, {"value", domain[1]}}},
                                {"stroke", {{"signal", "muted"}}},
                                {"strokeDash", value({5, 4})}}));
  Json bars = rule({{"x", field("x", "t")},
                    {"y", field("y", "low")},
                    {"y2", field("y", "high")},
                    {"stroke", field("color", "method")},
                    {"strokeOpacity", value(0.45)}},
                   "bars");
  bars["clip"] = true;
  spec["marks"].push_back(bars);
  spec["marks"].push_back({{"type", "symbol"},
                           {"from", {{"data", "points"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "t")},
                               {"y", field("y", "m")},
                               {"size", value(36)},
                               {"shape", field("shape", "cultivar")},
                               {"fill", field("color", "method")},
                               {"fillOpacity", value(0.75)},
                               {"tooltip", {{"field", "tip"}}}}}}}});
}

/// Errors of a trait in bins of a round width, about 24 over the range, the same for all methods.
struct ErrorBins {
  double step = 0;
  int half_bins = 0;
  std::map<std::pair<std::string, int>, int> counts;
};

ErrorBins error_bins(const TraitRows& trait) {
  double reach = 0;
  for (const SpecimenRow* row : trait.rows) {
    reach = std::max(reach, trait.unit.factor * std::abs(row->measured - row->truth));
  }
  const double raw = std::max(reach, 1e-12) / 12;
  const double decade = std::pow(10, std::floor(std::log10(raw)));
  double step = 10 * decade;
  for (const double round : {5.0, 2.0, 1.0}) {
    if (round * decade >= raw) step = round * decade;
  }
  const auto half_bins = static_cast<int>(std::ceil(reach / step * (1 + 1e-12)));
  std::map<std::pair<std::string, int>, int> counts;
  for (const SpecimenRow* row : trait.rows) {
    const double error = trait.unit.factor * (row->measured - row->truth);
    ++counts[{row->method, std::clamp(static_cast<int>(std::floor(error / step)), -half_bins,
                                      std::max(half_bins - 1, 0))}];
  }
  return {step, half_bins, std::move(counts)};
}

Json error_bars(const TraitRows& trait, const ErrorBins& errors,
                const std::vector<std::string>& methods) {
  const double step = errors.step;
  Json bins = Json::array();
  for (const auto& [key, count] : errors.counts) {
    // Bars of several methods stand side by side in a bin.
    const auto slot =
        static_cast<double>(std::find(methods.begin(), methods.end(), key.first) - methods.begin());
    const double width = step / static_cast<double>(methods.size());
    bins.push_back({{"from", key.second * step + slot * width},
                    {"to", key.second * step + (slot + 1) * width},
                    {"count", count},
                    {"method", key.first},
                    {"tip", key.first + ": " + std::to_string(count) + " between " +
                                shown_number(key.second * step) + " and " +
                                shown_number((key.second + 1) * step) + " " + trait.unit.name}});
  }
  return bins;
}

void add_histogram_marks(Json& spec) {
  spec["marks"].push_back({{"type", "rect"},
                           {"from", {{"data", "bins"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "from")},
                               {"x2", {{"scale", "x"}, {"field", "to"}, {"offset", -1}}},
                               {"y", field("y", "count")},
                               {"y2", {{"scale", "y"}, {"value", 0}}},
                               {"fill", field("color", "method")},
                               {"fillOpacity", value(0.8)},
                               {"tooltip", {{"field", "tip"}}}}}}}});
  spec["marks"].push_back(rule({{"x", {{"scale", "x"}, {"value", 0}}},
                                {"y", value(0)},
                                {"y2", {{"signal", "height"}}},
                                {"stroke", {{"signal", "muted"}}},
                                {"strokeDash", value({5, 4})}}));
}

}  // namespace

std::vector<Plot> scatter_plots(const std::vector<SpecimenRow>& rows) {
  std::vector<Plot> plots;
  for (const TraitRows& trait : by_trait(rows)) {
    const auto [points, domain] = scatter_points(trait);
    Json spec = specification(300, 300);
    spec["data"].push_back({{"name", "points"}, {"values", points}});
    spec["data"].push_back({{"name", "bars"},
                            {"source", "points"},
                            {"transform", {{{"type", "filter"}, {"expr", "isValid(datum.low)"}}}}});
    spec["scales"] = {linear_scale("x", "width", domain),
                      linear_scale("y", "height", domain),
                      {{"name", "color"},
                       {"type", "ordinal"},
                       {"domain", distinct(trait.rows, &SpecimenRow::method)},
                       {"range", kPalette}}};
    spec["axes"] = {axis("x", "bottom", with_unit("true " + trait.trait, trait.unit.name)),
                    axis("y", "left", with_unit("measured " + trait.trait, trait.unit.name))};
    spec["legends"].push_back(legend("fill", "color"));
    add_cultivar_shapes(spec, distinct(trait.rows, &SpecimenRow::cultivar));
    add_scatter_marks(spec, domain);
    plots.push_back({trait.trait, describe(trait), std::move(spec)});
  }
  return plots;
}

std::vector<Plot> error_histograms(const std::vector<SpecimenRow>& rows) {
  std::vector<Plot> plots;
  for (const TraitRows& trait : by_trait(rows)) {
    const ErrorBins errors = error_bins(trait);
    const std::vector<std::string> methods = distinct(trait.rows, &SpecimenRow::method);
    const double edge = std::max(errors.half_bins, 1) * errors.step;
    Json spec = specification(300, 160);
    spec["data"].push_back({{"name", "bins"}, {"values", error_bars(trait, errors, methods)}});
    spec["scales"] = {
        linear_scale("x", "width", {-edge, edge}),
        linear_scale("y", "height", {{"data", "bins"}, {"field", "count"}}, true),
        {{"name", "color"}, {"type", "ordinal"}, {"domain", methods}, {"range", kPalette}}};
    spec["scales"][1]["nice"] = true;
    spec["axes"] = {
        axis("x", "bottom", with_unit("measured − true " + trait.trait, trait.unit.name)),
        axis("y", "left", "specimens")};
    spec["axes"][1]["format"] = "d";
    spec["axes"][1]["tickMinStep"] = 1;
    spec["legends"].push_back(legend("fill", "color"));
    add_histogram_marks(spec);
    plots.push_back({trait.trait, {}, std::move(spec)});
  }
  return plots;
}

}  // namespace cousin
