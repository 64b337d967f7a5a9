#pragma once

#include <cstdint>
#include <string>

#include "sim/sensors/camera_config.h"
#include "sim/truth/truth_images.h"
#include "sim/types/capture.h"
#include "sim/types/rng.h"

namespace cousin {

/// One particular camera: its true lens and the streams that its fixed pattern is drawn from. The
/// maps are made row by row where they are needed: at 24 megapixels they would take 200 MB.
struct CameraUnit {
  LensUnit lens;
  Rng prnu{0}, dsnu{0}, column_dsnu{0}, row_dsnu{0};
};
/// @throws std::invalid_argument if the configuration is invalid or a drawn lens folds inside the
/// image.
CameraUnit make_camera_unit(const CameraSensorConfig& config, const Rng& rng);

/// What EMVA 1288 calls the spatial nonuniformity of a unit, as images.
Image<float> prnu_map(const CameraSensorConfig& config, const CameraUnit& unit);  ///< mean 1
Image<float> dsnu_map(const CameraSensorConfig& config,
                      const CameraUnit& unit);  ///< electrons; columns and rows in it

/// The true lens when autofocus looks for a distance; without autofocus, the unit's own.
struct FocusedLens {
  Camera camera;
  double focus_m = 0;  ///< depth that is sharp; infinity if focused there
};
FocusedLens focused_lens(const CameraSensorConfig& config, const CameraUnit& unit,
                         double distance_m, const Rng& rng);
/// What the device reports of a lens that truly is `now`.
Camera reported_camera(const CameraSensorConfig& config, const CameraUnit& unit, const Camera& now,
                       const Rng& rng);

/// Electrons that unit radiance gives in green on the optical axis: the configured number or
/// automatic exposure.
double electrons_per_radiance(const CameraSensorConfig& config, const Image<Rgbf>& radiance);

/// Radiance to raw codes, a photosite a pixel: lateral colour, vignetting, blur, the sensor's
/// colours, mosaic, then shot noise, PRNU, dark current, DSNU, row and read noise, black level,
/// clipping, rounding. Row y draws from rng.fork(y): the same bytes on any number of threads.
/// @throws std::invalid_argument if the size differs from the preset's or a radiance is not finite.
Image<std::uint16_t> expose(const Image<Rgbf>& radiance, const CameraSensorConfig& config,
                            const CameraUnit& unit, const Camera& camera, const Rng& rng);

/// Raw codes to linear sRGB: black level, white balance with gains of at least 1, demosaicing,
/// colour matrix. 1 is where the colour of gain 1 saturates; values are not clipped.
Image<Rgbf> develop_linear(const Image<std::uint16_t>& raw, const CameraSensorConfig& config);
/// Then clipping to [0, 1], the tone curve, 8 bits, JPEG if asked.
Image<Rgb8> develop(const Image<std::uint16_t>& raw, const CameraSensorConfig& config);

/// Radiance to what the camera hands over.
SensorFrame sense(const Image<Rgbf>& radiance, const CameraSensorConfig& config,
                  const CameraUnit& unit, const TrueView& view, const Rng& rng);

/// What the rig says of the sensor.
SensorReport report_of(const CameraSensorConfig& config, const CameraUnit& unit,
                       const std::string& name, const Pose& sensor_from_rig);

/// Temporal variance of a green photosite's code at a radiance >= 0 on the optical axis [EMVA 1288:
/// sigma_y^2 = K^2 sigma_d^2 + 1/12 + K (mu_y - mu_dark)]; above full well it stays at its value
/// there.
double code_variance(const PhotositesConfig& config, double electrons);

}  // namespace cousin
