#include "sim/sensors/device.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "sim/sensors/preset_text.h"

namespace cousin {
namespace {

struct Kind {
  std::string_view name;
  bool Streams::*member;
};
constexpr std::array<Kind, 4> kKinds = {{{"color", &Streams::color},
                                         {"raw", &Streams::raw},
                                         {"infrared", &Streams::infrared},
                                         {"depth", &Streams::depth}}};

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Streams own_streams(const PhoneConfig&) { return {.color = true}; }
Streams own_streams(const RigConfig& rig) {
  const bool raw = std::any_of(rig.sensors.begin(), rig.sensors.end(),
                               [](const RigSensor& s) { return s.camera.develop.raw; });
  return {.color = true, .raw = raw};
}
Streams own_streams(const ActiveStereoConfig& device) {
  return {.color = true, .raw = device.color.develop.raw, .infrared = true, .depth = true};
}
Streams own_streams(const RangeRigConfig& device) {
  return {.color = true, .raw = device.body.sensors.front().camera.develop.raw, .depth = true};
}

/// A preset in a file of the user's own.
DeviceConfig device_in_file(const std::string& path) {
  const std::vector<std::string> tables = toml_tables(preset_toml(path, {}), path);
  if (holds(tables, "rig")) return rig_preset(path);
  if (holds(tables, "time_of_flight") || holds(tables, "structured_light"))
    return range_rig_preset(path);
  if (holds(tables, "match")) return active_stereo_preset(path);
  return phone_preset(path);
}

}  // namespace

Fields fields(DeviceConfig& config) {
  return std::visit([](auto& device) { return fields(device); }, config);
}

void validate(const DeviceConfig& config) {
  std::visit([](const auto& device) { validate(device); }, config);
}

std::vector<std::string> device_preset_names() {
  std::vector<std::string> names = phone_preset_names();
  for (const auto& more :
       {rig_preset_names(), active_stereo_preset_names(), range_rig_preset_names()})
    names.insert(names.end(), more.begin(), more.end());
  return names;
}

DeviceConfig device_preset(const std::string& name) {
  if (is_preset_file(name)) return device_in_file(name);
  if (holds(phone_preset_names(), name)) return phone_preset(name);
  if (holds(rig_preset_names(), name)) return rig_preset(name);
  if (holds(active_stereo_preset_names(), name)) return active_stereo_preset(name);
  if (holds(range_rig_preset_names(), name)) return range_rig_preset(name);
  std::string known;
  for (const std::string& each : device_preset_names()) known += (known.empty() ? "" : ", ") + each;
  throw std::invalid_argument("rig \"" + name + "\" does not exist; there are " + known +
                              ", or the path of a file that ends with .toml");
}

Streams streams_of(const DeviceConfig& config) {
  return std::visit([](const auto& device) { return own_streams(device); }, config);
}

std::string to_string(const Streams& streams) {
  std::string text;
  for (const Kind& kind : kKinds) {
    if (streams.*kind.member) text += (text.empty() ? "" : ",") + std::string(kind.name);
  }
  return text.empty() ? "none" : text;
}

Streams streams_from_string(std::string_view text, const Streams& there_are,
                            const std::string& rig) {
  if (text == "all") return there_are;
  Streams streams;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string_view word = text.substr(from, comma - from);
    const auto kind = std::find_if(kKinds.begin(), kKinds.end(),
                                   [&](const Kind& each) { return each.name == word; });
    const std::string where = "streams \"" + std::string(text) + "\": ";
    if (kind == kKinds.end()) {
      throw std::invalid_argument(where + "\"" + std::string(word) +
                                  "\" is not one of color, raw, infrared, depth, all");
    }
    if (!(there_are.*kind->member)) {
      throw std::invalid_argument(where + "rig " + rig + " has no " + std::string(word) +
                                  "; it has " + to_string(there_are));
    }
    streams.*kind->member = true;
    from = comma + 1;
  }
  return streams;
}

}  // namespace cousin
