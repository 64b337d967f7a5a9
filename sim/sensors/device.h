#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/sensors/active_stereo.h"
#include "sim/sensors/phone.h"
#include "sim/sensors/range_rig.h"
#include "sim/sensors/rig.h"

namespace cousin {

/// A rig of any kind that there are presets of: a phone's video, colour and grey cameras on one
/// body, a stereo depth camera, one by time of flight or structured light.
using DeviceConfig = std::variant<PhoneConfig, RigConfig, ActiveStereoConfig, RangeRigConfig>;
Fields fields(DeviceConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const DeviceConfig& config);

/// A preset of any kind by its name, or of a file by its path, which ends with .toml: its tables
/// say which kind it is. @throws std::invalid_argument listing the names that exist;
/// std::runtime_error naming the file, line, key and limit.
DeviceConfig device_preset(const std::string& name);
std::vector<std::string> device_preset_names();

/// Kinds of images that a rig hands over.
struct Streams {
  bool color = false;
  bool raw = false;       ///< 16-bit linear
  bool infrared = false;  ///< of both imagers of a stereo depth camera
  bool depth = false;
  bool operator==(const Streams&) const = default;
};
/// What a rig has. Raw images only where its preset hands them over.
Streams streams_of(const DeviceConfig& config);
/// The names in a fixed order, "none" for none.
std::string to_string(const Streams& streams);
/// "all" of `there_are`, or a list such as "color,depth".
/// @throws std::invalid_argument naming the word that is no stream, or that `rig` does not have.
Streams streams_from_string(std::string_view text, const Streams& there_are,
                            const std::string& rig);

}  // namespace cousin
