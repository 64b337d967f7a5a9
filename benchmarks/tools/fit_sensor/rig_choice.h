#pragma once

#include <optional>
#include <string>

#include "sim/sensors/active_stereo.h"
#include "sim/sensors/rig.h"

namespace cousin {

/// A preset that recordings can be fitted to: a depth camera or colour cameras.
struct RigChoice {
  std::string name;  ///< as given
  std::string toml;  ///< its text
  std::optional<ActiveStereoConfig> depth;
  std::optional<RigConfig> cameras;
};
/// @param name  a preset's, or the path of a TOML file
/// @throws std::invalid_argument listing the names that exist; std::runtime_error as the readers.
RigChoice rig_choice(const std::string& name);

/// The photosites whose gain and read noise raw colour frames tell: the keys' prefix in the preset
/// ("camera.photosites.") and their present numbers.
struct PhotositesChoice {
  std::string prefix;
  int bits = 8;
};
/// Nothing if the preset describes no photosites of a colour camera.
std::optional<PhotositesChoice> photosites_choice(const RigChoice& rig);

}  // namespace cousin
