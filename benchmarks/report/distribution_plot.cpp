#include <algorithm>
#include <cmath>
#include <limits>

#include "benchmarks/report/plots.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/report/vega_parts.h"

namespace cousin {

using namespace vega_parts;

namespace {

/// A width of 1, 2 or 5 times a power of ten that cuts `range` into 25 to 60 bins.
double round_step(double range) {
  const double raw = std::max(range, 1e-12) / 60;
  const double decade = std::pow(10, std::floor(std::log10(raw)));
  for (const double round : {1.0, 2.0, 5.0}) {
    if (round * decade >= raw) return round * decade;
  }
  return 10 * decade;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double deviation_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double squares = 0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / std::max(1.0, static_cast<double>(values.size()) - 1));
}

/// Bins of one width, from `first` steps on.
struct DistributionBins {
  double step = 0;
  long first = 0;
  std::size_t count = 0;
};

DistributionBins distribution_bins(const Distribution& distribution, double factor) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const DistributionGroup& group : distribution.groups) {
    for (const double v : group.values) {
      low = std::min(low, factor * v);
      high = std::max(high, factor * v);
    }
  }
  const double step = round_step(high - low);
  const auto first = static_cast<long>(std::floor(low / step));
  const auto count =
      static_cast<std::size_t>(static_cast<long>(std::floor(high / step)) - first + 1);
  return {step, first, count};
}

/// A bar a bin that holds something, and a mean a group.
struct DistributionParts {
  Json bars = Json::array();
  Json means = Json::array();
  Json names = Json::array();
  std::vector<std::string> kinds;
  double most = 0;
};

/// Adds the shares of a group. @return the largest
double add_distribution_bars(Json& bars, const DistributionGroup& group, const std::string& name,
                             const DistributionBins& bins, const ShownUnit& unit) {
  const auto [step, first, count] = bins;
  double most = 0;
  std::vector<double> share(count, 0);
  for (const double v : group.values) {
    const auto bin = static_cast<std::size_t>(
        std::clamp(static_cast<long>(std::floor(unit.factor * v / step)) - first, 0L,
                   static_cast<long>(count) - 1));
    share[bin] += 100.0 / static_cast<double>(group.values.size());
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (share[i] == 0) continue;
    most = std::max(most, share[i]);
    const double from = static_cast<double>(first + static_cast<long>(i)) * step;
    bars.push_back({{"name", name},
                    {"kind", group.kind},
                    {"from", from},
                    {"to", from + step},
                    {"share", share[i]},
                    {"tip", shown_number(share[i]) + " % between " + shown_number(from) + " and " +
                                shown_number(from + step) + " " + unit.name}});
  }
  return most;
}

DistributionParts distribution_parts(const Distribution& distribution, const DistributionBins& bins,
                                     const ShownUnit& unit) {
  DistributionParts parts;
  for (const DistributionGroup& group : distribution.groups) {
    if (group.values.empty()) continue;
    const double mean = unit.factor * mean_of(group.values);
    const double deviation = unit.factor * deviation_of(group.values);
    const std::string name = group.name + ", n = " + std::to_string(group.values.size());
    parts.names.push_back(name);
    if (std::find(parts.kinds.begin(), parts.kinds.end(), group.kind) == parts.kinds.end())
      parts.kinds.push_back(group.kind);
    parts.means.push_back(
        {{"name", name},
         {"x", mean},
         {"text", shown_number(mean) + " ± " + shown_number(deviation) + " " + unit.name + " (" +
                      shown_number(100 * deviation / mean) + " %)"}});
    parts.most = std::max(parts.most, add_distribution_bars(parts.bars, group, name, bins, unit));
  }
  return parts;
}

// A band a group, one below the other over the same axis.
constexpr int kGroupBand_px = 84;
constexpr int kGroupBars_px = 54;

void add_share_marks(Json& spec, const Json& floor_of_band) {
  Json top_of_bar = floor_of_band;
  top_of_bar["offset"] = {{"scale", "share"}, {"field", "share"}};
  spec["marks"].push_back({{"type", "rect"},
                           {"from", {{"data", "bars"}}},
                           {"encode",
                            {{"enter",
                              {{"x", field("x", "from")},
                               {"x2", {{"scale", "x"}, {"field", "to"}, {"offset", -1}}},
                               {"y", top_of_bar},
                               {"y2", floor_of_band},
                               {"fill", field("color", "kind")},
                               {"fillOpacity", value(0.85)},
                               {"tooltip", {{"field", "tip"}}}}}}}});
}

void add_mean_marks(Json& spec, const Json& floor_of_band) {
  Json above_bars = floor_of_band;
  above_bars["offset"] = -kGroupBars_px - 4;
  spec["marks"].push_back({{"type", "rule"},
                           {"from", {{"data", "means"}}},
                           {"encode",
                            {{"update",
                              {{"x", field("x", "x")},
                               {"y", above_bars},
                               {"y2", floor_of_band},
                               {"stroke", ink()},
                               {"strokeDash", value({4, 3})}}}}}});
  spec["marks"].push_back({{"type", "rule"},
                           {"from", {{"data", "means"}}},
                           {"encode",
                            {{"update",
                              {{"x", value(0)},
                               {"x2", {{"signal", "width"}}},
                               {"y", floor_of_band},
                               {"stroke", {{"signal", "muted"}}}}}}}});
  const auto label = [&](const char* text, const Json& x, const char* align) {
    Json y = floor_of_band;
    y["offset"] = -kGroupBars_px - 12;
    spec["marks"].push_back({{"type", "text"},
                             {"from", {{"data", "means"}}},
                             {"encode",
                              {{"update",
                                {{"x", x},
                                 {"y", y},
                                 {"text", {{"field", text}}},
                                 {"align", value(align)},
                                 {"fontSize", value(11)},
                                 {"fill", ink()}}}}}});
  };
  label("name", value(2), "left");
  label("text", {{"signal", "width - 2"}}, "right");
}

}  // namespace

Plot distribution_plot(const Distribution& distribution) {
  const ShownUnit unit = shown_unit(distribution.unit, distribution.quantity);
  const DistributionBins bins = distribution_bins(distribution, unit.factor);
  const auto [step, first, count] = bins;
  const DistributionParts parts = distribution_parts(distribution, bins, unit);
  Json spec = specification(560, kGroupBand_px * static_cast<int>(parts.names.size()));
  spec["data"] = {{{"name", "bars"}, {"values", parts.bars}},
                  {{"name", "means"}, {"values", parts.means}}};
  spec["scales"] = {
      linear_scale("x", "width",
                   {static_cast<double>(first) * step,
                    static_cast<double>(first + static_cast<long>(count)) * step}),
      {{"name", "band"}, {"type", "band"}, {"range", "height"}, {"domain", parts.names}},
      {{"name", "share"},
       {"type", "linear"},
       {"range", {0, -kGroupBars_px}},
       {"domain", {0, parts.most}},
       {"nice", false}},
      {{"name", "color"}, {"type", "ordinal"}, {"domain", parts.kinds}, {"range", kPalette}}};
  spec["axes"] = {axis("x", "bottom", with_unit(distribution.quantity, unit.name))};
  spec["legends"].push_back(legend("fill", "color"));
  const Json floor_of_band = {{"scale", "band"}, {"field", "name"}, {"band", 1}};
  add_share_marks(spec, floor_of_band);
  add_mean_marks(spec, floor_of_band);
  return {distribution.title,
          {"Share of the specimens in each bin of " + shown_number(step) + " " + unit.name +
           ". The dashed line is the mean; beside it mean ± standard deviation, and that over the "
           "mean."},
          std::move(spec)};
}

}  // namespace cousin
