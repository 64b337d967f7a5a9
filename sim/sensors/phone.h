#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/config/fields.h"
#include "sim/sensors/lens_unit.h"
#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"
#include "sim/types/capture.h"
#include "sim/types/rng.h"

namespace cousin {

/// A phone's colour camera [EMVA 1288 linear model; sensors.md A4-A6]. Presets are TOML with a
/// source for each number.
struct PhoneConfig {
  LensModel lens = LensModel::opencv5;
  int width_px = 1280;
  int height_px = 720;
  double focal_px_per_width =
      0.84375;  ///< focused at infinity, over the image width (1080 px at 1280)
  std::vector<double> distortion = {0.05, -0.08, 0.0004, -0.0003, 0.02};
  double principal_offset_px_per_width =
      0.004;  ///< sigma of the true principal point about the centre
  // Focus: the lens moves out by the thin-lens law, so the focal length in pixels grows as f (1 +
  // f_m / (Z - f_m)).
  bool autofocus = true;
  double focal_m = 0.0042;    ///< physical focal length
  double focus_error = 0.01;  ///< relative sigma of the focused distance
  // What the device reports differs from the truth by these (sigma, drawn once a device unless
  // said).
  double report_focal_error = 0.002;  ///< relative
  double report_focus_error =
      0.05;  ///< relative, of the focused distance it reports; drawn for each image
  double report_centre_error_px_per_width = 0.001;
  double report_distortion_error = 0.05;  ///< relative, each coefficient
  // Light to electrons to numbers.
  double electrons_at_unit_radiance =
      6000;  ///< at the exposure used; 0 = auto: the 99.5 % brightest at 80 % of full well
  double full_well_e = 7000;
  double read_noise_e = 2.0;
  double prnu = 0.01;
  double dsnu_e = 0.5;
  int bits = 10;  ///< 8..16; the largest code is full well
  double exposure_s = 0.008;
  double readout_s = 0.015;           ///< rolling shutter; 0 = global
  double hand_speed_m_per_s = 0.02;   ///< sigma of the hand's velocity while a frame is read
  double hand_rate_rad_per_s = 0.02;  ///< sigma of its angular rate
  double blur_sigma_px = 0.5;         ///< Gaussian part of the lens and pixel response; 0 = none
  double vignetting_a = -0.3, vignetting_b = 0.05,
         vignetting_c = 0;  ///< gain = 1 + a r^2 + b r^4 + c r^6, r over the half diagonal
  int jpeg_quality = 0;     ///< 1..100; 0 = no JPEG
};
Fields fields(PhoneConfig& config);
void validate(const PhoneConfig& config);

/// One particular phone: true lens and fixed-pattern maps drawn from the preset.
struct PhoneUnit {
  Camera camera_at_infinity;    ///< true
  Camera reported_at_infinity;  ///< what it reports for every image, scaled by its reported focus
  Image<Rgbf> prnu_gain;        ///< relative response of each pixel's three photosites, mean 1
  Image<Rgbf> dsnu_e;           ///< offset in electrons, mean 0
};
/// @throws std::invalid_argument if the configuration is invalid or a drawn lens folds inside the
/// image.
PhoneUnit make_phone(const PhoneConfig& config, Rng rng);

/// The true lens and motion of frame `frame` of the scene's views: autofocus on the distance to the
/// view's focus, hand motion during readout added to the scene's own. Distortion coefficients and
/// principal point keep their values at infinity. Motion within the exposure of a row is not
/// modelled (0.2 px for the presets).
/// @throws std::invalid_argument if the scene has no such view.
TrueView true_view(const PhoneConfig& config, const PhoneUnit& unit, const Scene& scene, int frame,
                   Rng rng);

/// Electrons that unit radiance gives on the optical axis: the configured number or, where it is 0,
/// automatic exposure, which brings the 99.5 % quantile of the brightest channel to 80 % of full
/// well.
double electrons_per_radiance(const PhoneConfig& config, const Image<Rgbf>& radiance);

/// Codes of the three photosites of a pixel, black level 0, 2^bits - 1 = full well. Three sensels a
/// pixel: video is scaled down from more pixels than it has, so no mosaic is modelled.
struct LinearCode {
  std::uint16_t r = 0, g = 0, b = 0;
  bool operator==(const LinearCode&) const = default;
};

/// Radiance to linear codes: vignetting, blur, PRNU, shot noise, DSNU, read noise, clipping at zero
/// and full well, rounding. Row y draws from rng.fork(y): the same bytes on any number of threads.
/// Shot noise is an exact Poisson count below 30 electrons, above it a normal with the Poisson's
/// skewness, drawn together with the read noise.
/// @throws std::invalid_argument if sizes differ from the preset's or a radiance is not finite.
Image<LinearCode> expose(const Image<Rgbf>& radiance, const PhoneConfig& config,
                         const PhoneUnit& unit, const TrueView& view, Rng rng);

/// The calibration that `sense` reports for a view when given the same `rng`, without an image.
Camera reported_camera(const PhoneConfig& config, const PhoneUnit& unit, const TrueView& view,
                       const Rng& rng);

/// Radiance to the 8-bit sRGB image handed over: `expose`, the sRGB curve, JPEG if asked. The
/// reported camera is the device's with the focal length of the focus distance it reports.
SensorFrame sense(const Image<Rgbf>& radiance, const PhoneConfig& config, const PhoneUnit& unit,
                  const TrueView& view, Rng rng);

/// Temporal variance of the linear signal in units of radiance^2 that the sensor adds at a given
/// radiance >= 0 on the optical axis, for the comparison with the renderer's own variance: shot,
/// read and rounding noise [EMVA 1288: sigma_y^2 = K^2 sigma_d^2 + sigma_q^2 + K mu_y]. Above full
/// well it stays at its value there.
double sensor_variance(const PhoneConfig& config, double radiance,
                       double electrons_at_unit_radiance);
/// The same at the configured exposure; with automatic exposure, as if unit radiance were the
/// brightest.
double sensor_variance(const PhoneConfig& config, double radiance);

/// What the rig says of itself.
SensorReport report_of(const PhoneConfig& config, const PhoneUnit& unit);

/// A preset from sim/sensors/presets/<name>.toml. @throws std::invalid_argument listing the names
/// that exist.
PhoneConfig phone_preset(const std::string& name);
std::vector<std::string> phone_preset_names();

}  // namespace cousin
