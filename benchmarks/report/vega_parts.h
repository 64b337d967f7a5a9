#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace cousin {

/// Parts that the plots share, as pieces of a Vega specification.
namespace vega_parts {

using Json = nlohmann::ordered_json;

/// Okabe & Ito's colours, the blue lightened to read on black as well as on white.
inline const Json kPalette = {"#2b83c6", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
inline constexpr const char* kGood = "#009e73";
inline constexpr const char* kBad = "#d55e00";
inline constexpr const char* kTotal = "#2b83c6";

inline Json field(const char* scale, const char* name) {
  return {{"scale", scale}, {"field", name}};
}
inline Json value(const Json& v) { return {{"value", v}}; }
inline Json ink() { return {{"signal", "ink"}}; }

inline Json axis(const char* scale, const char* orient, const std::string& title) {
  return {{"scale", scale},
          {"orient", orient},
          {"title", title},
          {"grid", true},
          {"tickCount", 6},
          {"labelOverlap", true},
          {"gridColor", {{"signal", "grid"}}},
          {"domainColor", {{"signal", "muted"}}},
          {"tickColor", {{"signal", "muted"}}},
          {"labelColor", ink()},
          {"titleColor", ink()},
          {"titleFontWeight", "normal"},
          {"titleFontSize", 12},
          {"labelFontSize", 11},
          {"titlePadding", 8}};
}

inline Json legend(const char* channel, const char* scale) {
  return {{channel, scale},      {"orient", "bottom"},     {"direction", "horizontal"},
          {"columns", 3},        {"symbolType", "circle"}, {"labelColor", ink()},
          {"labelFontSize", 11}, {"labelLimit", 180}};
}

inline Json specification(int width, int height) {
  return {{"$schema", "https://vega.github.io/schema/vega/v5.json"},
          {"width", width},
          {"height", height},
          {"padding", 6},
          {"autosize", "pad"},
          {"signals", Json::array({{{"name", "ink"}, {"value", "#1c2128"}},
                                   {{"name", "muted"}, {"value", "#8b949e"}},
                                   {{"name", "grid"}, {"value", "#e4e7eb"}}})},
          {"data", Json::array()},
          {"scales", Json::array()},
          {"axes", Json::array()},
          {"legends", Json::array()},
          {"marks", Json::array()}};
}

inline Json linear_scale(const char* name, const char* range, const Json& domain,
                         bool zero = false) {
  return {{"name", name},     {"type", "linear"}, {"range", range},
          {"domain", domain}, {"zero", zero},     {"nice", false}};
}

inline Json rule(const Json& encode, const char* data = nullptr) {
  Json mark = {{"type", "rule"}, {"encode", {{"enter", encode}}}};
  if (data != nullptr) mark["from"] = {{"data", data}};
  return mark;
}

inline std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " (" + unit + ")";
}

}  // namespace vega_parts
}  // namespace cousin
