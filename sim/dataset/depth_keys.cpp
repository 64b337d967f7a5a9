#include "sim/dataset/depth_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sim/dataset/picture_list.h"
#include "sim/dataset/text_fields.h"
#include "sim/dataset/units.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

/// Between metres a unit and units a metre programs differ: 1 is a millimetre to one and a metre to
/// another.
constexpr std::array<const char*, 5> kScaleKeys = {
    "depth_scale", "depth_factor", "depth_map_factor", "DepthMapFactor", "png_depth_scale"};
constexpr std::array<std::string_view, 12> kOtherDepthKeys = {
    "depth",        "depth_unit_m", "depth_unit",     "depth_units",
    "no_depth",     "max_depth",    "color_to_depth", "depth_to_color",
    "rgb_to_depth", "depth_to_rgb", "depth_format",   "depth_mode"};
/// A key that speaks of one of these may change what a depth or a place means.
constexpr std::array<const char*, 5> kTelling = {"depth", "disparity", "unit", "scal",
                                                 "extrinsics"};

void refuse_unread(const YamlValues& values) {
  for (const std::string& key : values.first_keys()) {
    if (std::find(kScaleKeys.begin(), kScaleKeys.end(), key) != kScaleKeys.end() ||
        std::find(kOtherDepthKeys.begin(), kOtherDepthKeys.end(), key) != kOtherDepthKeys.end())
      continue;
    const std::string lower = lower_case(key);
    if (std::any_of(kTelling.begin(), kTelling.end(),
                    [&](const char* word) { return lower.find(word) != std::string::npos; }))
      values.fail("the key \"" + cut_utf8(key, 60) +
                  "\" may change what depth means, and is not read; remove it, or say the same by "
                  "depth_unit_m, depth_to_color, aligned, no_depth or max_depth");
  }
}

double metres_of_scale(const YamlValues& values, const std::string& key) {
  const double scale = values.number(key);
  if (scale >= 1e-6 && scale < 0.1) return scale;
  if (scale >= 100 && scale <= 1e6) return 1 / scale;
  values.fail(key + " = " + exact_text(scale) +
              " is neither metres a unit, [1e-6, 0.1), nor units a metre, [100, 1e6]; write "
              "depth_unit_m, metres a unit, in its place");
}

void say_unit(const YamlValues& values, const std::string& key, double metres, DepthKeys& keys) {
  if (keys.unit_m && std::abs(*keys.unit_m - metres) > 1e-9 * metres)
    values.fail(key + " says " + exact_text(metres) + " m a unit, but " + keys.unit_key + " says " +
                exact_text(*keys.unit_m));
  keys.unit_m = metres;
  keys.unit_key = values.name() + ": " + key;
}

void read_unit(const YamlValues& values, DepthKeys& keys) {
  for (const char* key : kScaleKeys) {
    if (values.has(key)) say_unit(values, key, metres_of_scale(values, key), keys);
  }
  if (values.has("depth_unit_m")) {
    const double metres = values.number("depth_unit_m");
    if (!(metres >= 1e-6 && metres <= 1))
      values.fail("depth_unit_m = " + exact_text(metres) + " is outside [1e-6, 1] metres");
    say_unit(values, "depth_unit_m", metres, keys);
  }
  for (const std::string key : {"depth_unit", "depth_units"}) {
    if (!values.has(key)) continue;
    const std::string word = values.text(key);
    try {
      const SiUnit unit = si_unit(word);
      if (unit.si_unit != "m") throw std::invalid_argument("is not a length");
      say_unit(values, key, unit.factor, keys);
    } catch (const std::invalid_argument& error) {
      values.fail(key + " = " + cut_utf8(word, 60) + " " + error.what());
    }
  }
}

std::uint16_t sixteen_bits(const YamlValues& values, const std::string& key) {
  const double value = values.number(key);
  if (!(value >= 0 && value <= 65535) || value != std::floor(value))
    values.fail(key + " = " + exact_text(value) + " is not a whole number in [0, 65535]");
  return static_cast<std::uint16_t>(value);
}

bool truth_of(const YamlValues& values, const std::string& key) {
  const std::string word = values.text(key);
  if (word == "true" || word == "1" || word == "True") return true;
  if (word != "false" && word != "0" && word != "False")
    values.fail(key + " = " + cut_utf8(word, 60) + " is neither true nor false");
  return false;
}

}  // namespace

DepthKeys read_depth_keys(const YamlValues& values) {
  refuse_unread(values);
  DepthKeys keys;
  read_unit(values, keys);
  read_unit(values.below("depth"), keys);
  if (values.has("no_depth")) keys.none = sixteen_bits(values, "no_depth");
  if (values.has("max_depth")) keys.most = std::min(keys.most, sixteen_bits(values, "max_depth"));
  if (values.has("aligned")) keys.aligned = truth_of(values, "aligned");
  if (values.has("model") && values.text("model") == "visual_depth") keys.aligned = true;
  return keys;
}

}  // namespace cousin
