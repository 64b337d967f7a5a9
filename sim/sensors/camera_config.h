#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/config/fields.h"
#include "sim/imaging/demosaic.h"
#include "sim/sensors/lens_unit.h"
#include "sim/sensors/optics.h"
#include "sim/types/camera.h"
#include "sim/types/mosaic.h"

namespace cousin {

/// The lens of a camera's model; a unit's own lens is drawn about it.
struct LensConfig {
  LensModel model = LensModel::opencv5;
  double focal_px_per_width =
      0.8;  ///< over the image width: focused at infinity or, without autofocus, as it is
  double focal_y_over_x = 1;
  double centre_x_px_per_width = 0;  ///< of the principal point, from the middle of the image
  double centre_y_px_per_width = 0;
  std::vector<double> distortion;  ///< in the order of the model
  SplineLens spline;               ///< of a splined lens
  double principal_offset_px_per_width =
      0;  ///< sigma of a unit's principal point about the model's
  double focal_m = 0.004;
  double f_number = 0;  ///< focal length over the aperture's diameter; 0 = everything is sharp
  bool autofocus = false;
  double focus_m = 0;      ///< where it is sharp without autofocus; 0 = at infinity
  double focus_error = 0;  ///< relative sigma of the distance that autofocus finds
  // What the device reports differs from the truth by these (sigma, drawn once a device unless
  // said).
  double report_focal_error = 0;  ///< relative
  double report_focus_error = 0;  ///< relative, of the focused distance; drawn for each image
  double report_centre_error_px_per_width = 0;
  double report_distortion_error = 0;  ///< relative, each coefficient
  Optics optics;
};

/// From light to numbers [EMVA 1288 linear model; sensors.md A4].
struct PhotositesConfig {
  Mosaic mosaic = Mosaic::rggb;
  double sensitivity_red = 1;  ///< of red photosites over green ones, for white light of the scene
  double sensitivity_blue = 1;
  std::vector<double> srgb_from_camera;  ///< 3 x 3, row by row, rows sum to 1: linear sRGB from
                                         ///< white-balanced camera colour; empty = identity
  double electrons_at_unit_radiance =
      0;  ///< green, at the exposure used; 0 = auto: the 99.5 % brightest at 80 % of full well
  double full_well_e = 10000;
  double read_noise_e = 3;
  double prnu = 0.01;               ///< relative sigma of the response
  double dsnu_e = 1;                ///< sigma of the offset: of each photosite,
  double column_dsnu_e = 0;         ///< of each column,
  double row_dsnu_e = 0;            ///< of each row; fixed, as the others
  double row_noise_e = 0;           ///< sigma of each row's offset, drawn for each image
  double dark_current_e_per_s = 0;  ///< at dark_reference_k
  double dark_reference_k = 298.15;
  double dark_doubling_k = 7;  ///< warming that doubles it
  double temperature_k = 298.15;
  int bits = 12;        ///< 8..16; the largest code is full well
  int black_level = 0;  ///< code without light
  double exposure_s = 0.01;
  double readout_s = 0;  ///< first to last row; 0 = global shutter
};

enum class ToneCurve { srgb, gamma, linear };
std::string_view to_string(ToneCurve curve);
ToneCurve tone_curve_from_string(std::string_view text);

/// From raw numbers to the picture handed over.
struct DevelopConfig {
  Demosaic demosaic = Demosaic::malvar_he_cutler;
  double white_balance_red = 0;  ///< gain; 0 = what undoes sensitivity_red
  double white_balance_blue = 0;
  ToneCurve tone = ToneCurve::srgb;
  double gamma = 2.2;    ///< of ToneCurve::gamma: code = linear^(1 / gamma)
  int jpeg_quality = 0;  ///< 1..100; 0 = no JPEG
  bool raw = false;      ///< hand over the 16-bit linear image too
};

/// A colour or grey camera with a photosite a pixel. Presets are TOML with a source for each
/// number.
struct CameraSensorConfig {
  int width_px = 640;
  int height_px = 480;
  LensConfig lens;
  PhotositesConfig photosites;
  DevelopConfig develop;
};
Fields fields(CameraSensorConfig& config);
/// @param name  of the sensor, for messages
/// @throws std::invalid_argument naming sensor, key, value and limit.
void validate(const CameraSensorConfig& config, const std::string& name = "camera");

/// The model's lens without a unit's spread.
Camera nominal_camera(const CameraSensorConfig& config);
/// Linear sRGB from white-balanced camera colour.
Eigen::Matrix3d srgb_from_camera(const PhotositesConfig& config);
/// Mean dark electrons of one exposure.
double dark_electrons(const PhotositesConfig& config);
/// Codes an electron gives.
double codes_per_electron(const PhotositesConfig& config);

}  // namespace cousin
