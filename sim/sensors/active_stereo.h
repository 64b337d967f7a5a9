#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/config/fields.h"
#include "sim/imaging/stereo_matching.h"
#include "sim/render/infrared_pass.h"
#include "sim/sensors/camera_config.h"
#include "sim/sensors/depth_model.h"
#include "sim/sensors/dot_projector.h"
#include "sim/sensors/infrared_imager.h"
#include "sim/sensors/invalid_reason.h"
#include "sim/types/capture.h"

namespace cousin {

/// A stereo depth camera: two infrared imagers, with or without a dot projector, and a colour
/// camera. Presets are TOML with a source for each number. Rig frame = the ideal left imager: the
/// right imager, projector and colour camera lie on its x axis.
struct ActiveStereoConfig {
  // Depth modes: columns, rows and focal length of each.
  std::vector<double> mode_columns = {640};
  std::vector<double> mode_rows = {480};
  std::vector<double> mode_focal_px = {384};
  int columns = 640;  ///< of the mode in use
  double baseline_m = 0.095;
  double depth_unit_m = 0.001;
  double largest_depth_m = 20;  ///< beyond, the device gives none
  double disparity_step_px = 1.0 / 32;
  bool has_projector = true;
  double projector_x_m = 0.03;
  /// The infrared images handed over are taken without the projector's dots, beside those that
  /// depth is matched from: devices switch it off every other frame for that.
  bool infrared_without_dots = false;
  DotProjectorConfig projector;
  InfraredConfig infrared;
  InfraredImagerConfig imager;
  StereoMatchConfig match;
  DepthModelConfig model;  ///< the fast model's numbers, fitted to this configuration
  // Colour camera.
  int color_columns = 640, color_rows = 480;
  double color_focal_px = 390;
  std::vector<double> color_distortion;  ///< opencv5
  double color_x_m = 0.059;
  CameraSensorConfig color;  ///< its optics, photosites and processing; size and lens as above
  // How the device is held, and its clocks: the depth imagers' is the rig's.
  double sync_error_s = 0;         ///< sigma of the colour image's start, drawn for each frame
  double hand_speed_m_per_s = 0;   ///< sigma of the body's velocity, each axis
  double hand_rate_rad_per_s = 0;  ///< sigma of its turning rate, each axis
  // What a unit differs by from what it reports: sigmas, drawn once a unit.
  double focal_error = 0.0005;               ///< relative, of the imagers
  double baseline_error = 0.0005;            ///< relative
  double yaw_error_rad = 0.00005;            ///< of the right imager: a disparity offset of f * yaw
  double color_focal_error = 0.001;          ///< relative
  double color_rotation_error_rad = 0.0005;  ///< about each axis
};
Fields fields(ActiveStereoConfig& config);
/// Checks every number, that the modes' lists are of one length, and that `columns` is a mode.
/// @throws std::invalid_argument naming field, value and limit.
void validate(const ActiveStereoConfig& config);

/// The nominal rectified camera of the mode in use: pinhole, principal point in the middle.
Camera depth_camera(const ActiveStereoConfig& config);
Camera color_camera(const ActiveStereoConfig& config);
/// The colour camera with its size and lens.
CameraSensorConfig color_sensor(const ActiveStereoConfig& config);
/// Depth below which nothing is matched: f B / (shift + range).
double least_depth_m(const ActiveStereoConfig& config);

/// One particular device: what it is and what it believes to be.
struct ActiveStereoUnit {
  Camera imager;          ///< true, of both
  Pose right_from_rig;    ///< true
  double baseline_m = 0;  ///< true
  Camera reported;        ///< of the left imager
  Camera color;           ///< true
  Pose color_from_rig;    ///< true
  Camera color_reported;
  Pose color_from_rig_reported;
  std::optional<Projector> projector;  ///< pose in the rig
  Image<float> response_left, response_right;
};
/// @throws std::invalid_argument if the configuration is invalid.
ActiveStereoUnit make_active_stereo(const ActiveStereoConfig& config, Rng rng);

/// What the rig looks at, without sensor noise: a static scene needs it once.
struct InfraredPair {
  InfraredImage left, right;
  Image<float> depth_m, right_depth_m;  ///< true, along each imager's axis; NaN = no surface
};
/// @param rng  fixes samples and speckle.
InfraredPair render_infrared_pair(const RayScene& rays, const Scene& scene,
                                  const Pose& rig_from_world, const ActiveStereoConfig& config,
                                  const ActiveStereoUnit& unit, Rng rng);

/// One depth image and what is known of it.
struct StereoDepth {
  Image<std::uint16_t> left_codes, right_codes;
  Image<float> disparity_px;        ///< in steps of disparity_step_px; NaN = none
  Image<std::uint16_t> depth;       ///< Z16 of the left imager; 0 = none
  Image<float> noise_free_depth_m;  ///< the same pixels, true
  Image<InvalidReason> reason;
};
/// Both imagers' codes of one exposure, which the left image decides. @param rng  of this exposure.
struct InfraredCodes {
  Image<std::uint16_t> left, right;
};
InfraredCodes expose_pair(const InfraredPair& pair, const ActiveStereoConfig& config,
                          const ActiveStereoUnit& unit, const Rng& rng);
/// Matching, quantisation and range.
StereoDepth match_pair(const InfraredPair& pair, InfraredCodes codes,
                       const ActiveStereoConfig& config, const ActiveStereoUnit& unit);
/// Both: noise, matching, quantisation and range. @param rng  of this exposure.
StereoDepth sense_depth(const InfraredPair& pair, const ActiveStereoConfig& config,
                        const ActiveStereoUnit& unit, Rng rng);

/// Z16 from disparities by the reported focal length and baseline; 0 where there is none, beyond
/// the largest depth or above 65535 units.
Image<std::uint16_t> depth_of_disparity(const Image<float>& disparity_px,
                                        const ActiveStereoConfig& config);

/// Depth drawn into the colour image by the reported calibration.
Image<std::uint16_t> register_to_color(const Image<std::uint16_t>& depth,
                                       const ActiveStereoConfig& config,
                                       const ActiveStereoUnit& unit);

/// True view of the left imager.
TrueView left_view(const ActiveStereoUnit& unit, const Pose& rig_from_world);
TrueView right_view(const ActiveStereoUnit& unit, const Pose& rig_from_world);

/// A preset from sim/sensors/presets/<name>.toml, or of a file of one's own whose path, which ends
/// with .toml, is given in place of the name. @throws std::invalid_argument listing the names that
/// exist; std::runtime_error naming the file, line, key and limit.
ActiveStereoConfig active_stereo_preset(const std::string& name);
std::vector<std::string> active_stereo_preset_names();

}  // namespace cousin
