#pragma once

#include <string>
#include <variant>
#include <vector>

#include "sim/sensors/rig.h"
#include "sim/sensors/structured_light.h"
#include "sim/sensors/time_of_flight.h"

namespace cousin {

/// A depth camera with a lamp or projector of its own, and a colour camera on the same body. Rig
/// frame = the depth camera, nominally. Presets are TOML with a source for each number: the keys
/// below at the top, a table [time_of_flight] or [structured_light] for the depth camera, and one
/// [rgb] as a rig's sensor.
struct RangeRigConfig {
  RigConfig body = {.sensors = {{.name = "rgb"}}};  ///< the colour camera, and how it is held
  std::variant<TimeOfFlightConfig, StructuredLightConfig> depth;
  // What a unit differs by from what it reports: sigmas, drawn once a unit.
  double focal_error = 0;               ///< relative, of the depth camera
  double color_rotation_error_rad = 0;  ///< of the colour camera about each axis
};
/// Keys of the depth camera below "time_of_flight." or "structured_light.", of the colour camera
/// below "rgb.".
Fields fields(RangeRigConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const RangeRigConfig& config);

Camera depth_camera(const RangeRigConfig& config);
double depth_unit_m(const RangeRigConfig& config);

/// One particular device.
struct RangeRigUnit {
  RangeRigConfig truth;   ///< with the depth camera's true focal length
  Camera depth_reported;  ///< what the device believes of the depth camera
  RigUnit color;
  Pose color_from_rig;  ///< true
  Pose color_from_rig_reported;
};
/// @throws std::invalid_argument if the configuration is invalid.
RangeRigUnit make_range_rig(const RangeRigConfig& config, const Rng& rng);

/// One depth image and what is known of it.
struct RangeDepth {
  Image<std::uint16_t> depth;  ///< Z16; 0 = none
  Image<float> noise_free_depth_m;
  Image<InvalidReason> reason;
};
/// @param fixed  fixes samples of the ambient light from frame to frame. @param exposure  of this
/// exposure.
RangeDepth sense_range(const RayScene& rays, const Scene& scene, const Pose& camera_from_world,
                       const RangeRigConfig& config, const Rng& fixed, const Rng& exposure);

/// A preset from sim/sensors/presets/<name>.toml, or of a file of one's own whose path, which ends
/// with .toml, is given in place of the name. @throws std::invalid_argument listing the names that
/// exist; std::runtime_error naming the file, line, key and limit.
RangeRigConfig range_rig_preset(const std::string& name);
std::vector<std::string> range_rig_preset_names();
/// The depth camera of such a preset alone; the names are those of its kind.
TimeOfFlightConfig time_of_flight_preset(const std::string& name);
std::vector<std::string> time_of_flight_preset_names();
StructuredLightConfig structured_light_preset(const std::string& name);
std::vector<std::string> structured_light_preset_names();

}  // namespace cousin
