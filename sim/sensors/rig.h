#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/sensors/camera_sensor.h"
#include "sim/truth/scene.h"

namespace cousin {

/// What backs a preset: theory, an independent program, or a real device.
enum class Evidence { verified, cross_checked, validated };
std::string_view to_string(Evidence evidence);  ///< "verified", "cross-checked", "validated"
Evidence evidence_from_string(std::string_view text);

/// One camera of a rig.
struct RigSensor {
  std::string name;  ///< of 1 to 64 of a-z 0-9 _; also its folder in a dataset
  CameraSensorConfig camera;
  std::vector<double> centre_in_rig_m = {0, 0, 0};
  std::vector<double> rig_from_sensor_rad = {0, 0, 0};  ///< rotation vector: axis times angle
  double trigger_delay_s = 0;                           ///< of its first row after the rig's time
};

Pose sensor_from_rig(const RigSensor& sensor);

/// Colour and grey cameras on one body.
struct RigConfig {
  std::string title;  ///< for lists
  Evidence evidence = Evidence::verified;
  std::string evidence_by;         ///< which theory, program or device
  double sync_error_s = 0;         ///< sigma of each sensor's start, drawn for each frame
  double hand_speed_m_per_s = 0;   ///< sigma of the body's velocity, each axis
  double hand_rate_rad_per_s = 0;  ///< sigma of its turning rate, each axis
  std::vector<RigSensor> sensors;
};
/// The keys above, and each sensor's below its name.
Fields fields(RigConfig& config);
/// @throws std::invalid_argument naming sensor, key, value and limit.
void validate(const RigConfig& config);

/// A rig from TOML: [rig] with the keys above; [camera] with all keys of CameraSensorConfig, which
/// every sensor starts from; then for each sensor a table by its name with centre_in_rig_m,
/// rig_from_sensor_rad and trigger_delay_s, and keys of the camera that differ.
/// @throws std::runtime_error naming file, line, key and limit.
RigConfig rig_from_toml(std::string_view text, const std::string& name);

/// One particular rig.
struct RigUnit {
  std::vector<CameraUnit> sensors;
};
RigUnit make_rig(const RigConfig& config, const Rng& rng);

/// The true lens and motion of each sensor in frame `frame` of the scene's views. The body's motion
/// is the hand's after the scene's own, which lasts as long as the longest readout of the rig (none
/// if all shutters are global). Each sensor starts at its trigger delay plus a synchronisation
/// error; autofocus is on the distance to the view's focus. A frame is a pure function of `rng`.
/// @throws std::invalid_argument if the scene has no such view.
std::vector<TrueView> true_views(const RigConfig& config, const RigUnit& unit, const Scene& scene,
                                 int frame, const Rng& rng);

/// What all sensors hand over in a frame, one radiance image and one of `true_views` each.
/// @throws std::invalid_argument if there is not one of each for every sensor.
std::vector<SensorFrame> sense(const std::vector<Image<Rgbf>>& radiances, const RigConfig& config,
                               const RigUnit& unit, const std::vector<TrueView>& views,
                               const Rng& rng);

/// What the rig says of itself.
std::vector<SensorReport> report_of(const RigConfig& config, const RigUnit& unit);

/// A preset from sim/sensors/presets/<name>.toml, or of a file of one's own whose path, which ends
/// with .toml, is given in place of the name. @throws std::invalid_argument listing the names that
/// exist; std::runtime_error naming the file, line, key and limit.
RigConfig rig_preset(const std::string& name);
std::vector<std::string> rig_preset_names();

}  // namespace cousin
