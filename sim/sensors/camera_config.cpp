#include "sim/sensors/camera_config.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<std::pair<ToneCurve, std::string_view>, 3> kToneNames = {
    {{ToneCurve::srgb, "srgb"}, {ToneCurve::gamma, "gamma"}, {ToneCurve::linear, "linear"}}};

/// An enum with to_string, as text.
template <class Enum>
TextField text_field(Enum& value, Enum (*from_string)(std::string_view)) {
  return {[&value] { return std::string(to_string(value)); },
          [&value, from_string](const std::string& text) { value = from_string(text); }};
}

Fields spline_fields(SplineLens& spline) {
  Fields rows = {
      {"order", &spline.order, "of the B-splines: 2 or 3", 2, 3},
      {"columns", &spline.columns, "control points along x", 0, 1024},
      {"rows", &spline.rows, "control points along y", 0, 1024},
      {"fov_x_rad", &spline.fov_x_rad, "angle from left to right end", 0, 6.2},
      {"delta_u", &spline.delta_u, "x and y of each control point, row by row", -100, 100}};
  for (Field& row : rows) row.optional = true;  // of a splined lens only
  return rows;
}

Fields optics_fields(Optics& optics) {
  return {
      {"vignetting_a", &optics.vignetting_a,
       "gain = 1 + a r^2 + b r^4 + c r^6, r over the half diagonal", -1, 1},
      {"vignetting_b", &optics.vignetting_b, "see vignetting_a", -1, 1},
      {"vignetting_c", &optics.vignetting_c, "see vignetting_a", -1, 1},
      {"red_scale", &optics.red.scale, "red lands at r (scale + cubic r^2), r as above", 0.95,
       1.05},
      {"red_cubic", &optics.red.cubic, "see red_scale", -0.01, 0.01},
      {"blue_scale", &optics.blue.scale, "blue lands at r (scale + cubic r^2)", 0.95, 1.05},
      {"blue_cubic", &optics.blue.cubic, "see blue_scale", -0.01, 0.01},
      {"blur_sigma_px", &optics.blur_sigma_px, "Gaussian blur of lens and pixel", 0, 10},
  };
}

Fields lens_fields(LensConfig& lens) {
  const Fields rows = {
      {"model", text_field(lens.model, lens_model_from_string),
       "pinhole, opencv5, opencv8, opencv12, kannala_brandt4 or splined_stereographic"},
      {"focal_px_per_width", &lens.focal_px_per_width, "focal length over the image width", 0.05,
       100},
      {"focal_y_over_x", &lens.focal_y_over_x, "of the focal lengths in pixels", 0.5, 2},
      {"centre_x_px_per_width", &lens.centre_x_px_per_width,
       "principal point from the middle, over the width", -0.2, 0.2},
      {"centre_y_px_per_width", &lens.centre_y_px_per_width, "see centre_x_px_per_width", -0.2,
       0.2},
      {"distortion", &lens.distortion, "coefficients in the lens model's order", -100, 100},
      {"principal_offset_px_per_width", &lens.principal_offset_px_per_width,
       "sigma of a unit's principal point, over the width", 0, 0.1},
      {"focal_m", &lens.focal_m, "physical focal length", 1e-4, 1},
      {"f_number", &lens.f_number, "focal length over aperture; 0: everything is sharp", 0, 100},
      {"autofocus", &lens.autofocus, "focus on the scene for each image"},
      {"focus_m", &lens.focus_m, "focused distance without autofocus; 0: infinity", 0, 1e6},
      {"focus_error", &lens.focus_error, "relative sigma of autofocus's distance", 0, 0.5},
      {"report_focal_error", &lens.report_focal_error,
       "relative sigma of the reported focal length", 0, 0.2},
      {"report_focus_error", &lens.report_focus_error,
       "relative sigma of the reported focus distance", 0, 0.5},
      {"report_centre_error_px_per_width", &lens.report_centre_error_px_per_width,
       "sigma of the reported principal point, over the width", 0, 0.1},
      {"report_distortion_error", &lens.report_distortion_error,
       "relative sigma of each reported distortion coefficient", 0, 1},
  };
  return rows + optics_fields(lens.optics) + nested("spline", spline_fields(lens.spline));
}

Fields photosites_fields(PhotositesConfig& p) {
  return {
      {"mosaic", text_field(p.mosaic, mosaic_from_string), "grey, rggb, bggr, grbg or gbrg"},
      {"sensitivity_red", &p.sensitivity_red, "of red photosites over green ones", 0.01, 100},
      {"sensitivity_blue", &p.sensitivity_blue, "of blue photosites over green ones", 0.01, 100},
      {"srgb_from_camera", &p.srgb_from_camera, "3 x 3 by rows; empty: identity", -10, 10},
      {"electrons_at_unit_radiance", &p.electrons_at_unit_radiance,
       "exposure: electrons at radiance 1; 0: automatic", 0, 1e9},
      {"full_well_e", &p.full_well_e, "saturation", 10, 1e7},
      {"read_noise_e", &p.read_noise_e, "sigma of the read noise", 0, 1e4},
      {"prnu", &p.prnu, "relative sigma of the photosites' response", 0, 0.2},
      {"dsnu_e", &p.dsnu_e, "sigma of the photosites' offset", 0, 1e4},
      {"column_dsnu_e", &p.column_dsnu_e, "sigma of the columns' offset", 0, 1e4},
      {"row_dsnu_e", &p.row_dsnu_e, "sigma of the rows' offset", 0, 1e4},
      {"row_noise_e", &p.row_noise_e, "sigma of the rows' offset, new in each image", 0, 1e4},
      {"dark_current_e_per_s", &p.dark_current_e_per_s, "at dark_reference_k", 0, 1e6},
      {"dark_reference_k", &p.dark_reference_k, "temperature of dark_current_e_per_s", 200, 400},
      {"dark_doubling_k", &p.dark_doubling_k, "warming that doubles the dark current", 1, 100},
      {"temperature_k", &p.temperature_k, "of the sensor", 200, 400},
      {"bits", &p.bits, "of the analog-to-digital converter", 8, 16},
      {"black_level", &p.black_level, "code without light", 0, 60000},
      {"exposure_s", &p.exposure_s, "exposure time", 0, 60},
      {"readout_s", &p.readout_s, "first to last row; 0: global shutter", 0, 1},
  };
}

Fields develop_fields(DevelopConfig& d) {
  return {
      {"demosaic", text_field(d.demosaic, demosaic_from_string), "bilinear or malvar_he_cutler"},
      {"white_balance_red", &d.white_balance_red, "gain; 0: undoes sensitivity_red", 0, 100},
      {"white_balance_blue", &d.white_balance_blue, "gain; 0: undoes sensitivity_blue", 0, 100},
      {"tone", text_field(d.tone, tone_curve_from_string), "srgb, gamma or linear"},
      {"gamma", &d.gamma, "code = linear^(1 / gamma)", 0.2, 5},
      {"jpeg_quality", &d.jpeg_quality, "1 to 100; 0: no JPEG", 0, 100},
      {"raw", &d.raw, "hand over the 16-bit linear image too"},
  };
}

[[noreturn]] void reject(const std::string& name, const std::string& what) {
  throw std::invalid_argument(name + ": " + what);
}

void check_lens(const CameraSensorConfig& config, const std::string& name) {
  const LensConfig& lens = config.lens;
  const int allowed = distortion_count(lens.model);
  if (static_cast<int>(lens.distortion.size()) > allowed) {
    reject(name, "lens.distortion has " + std::to_string(lens.distortion.size()) +
                     " coefficients; " + std::string(to_string(lens.model)) + " takes at most " +
                     std::to_string(allowed));
  }
  if (lens.autofocus && !(lens.focal_px_per_width > 0)) reject(name, "lens.focal_px_per_width");
  const Camera camera = nominal_camera(config);
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    reject(name, error.what());
  }
  // The gain must stay positive out to the corner of the farthest-off optical axis.
  const double reach = 1.2 + 2 * std::hypot(lens.centre_x_px_per_width, lens.centre_y_px_per_width);
  for (int i = 0; i <= 24; ++i) {
    const double r2 = std::pow(reach * i / 24, 2);
    const Optics& o = lens.optics;
    const double gain = 1 + r2 * (o.vignetting_a + r2 * (o.vignetting_b + r2 * o.vignetting_c));
    if (!(gain > 0)) {
      reject(name, "vignetting gain = " + std::to_string(gain) + " at " +
                       std::to_string(std::sqrt(r2)) + " half diagonals must be positive");
    }
  }
}

void check_colours(const PhotositesConfig& p, const std::string& name) {
  if (p.srgb_from_camera.empty()) return;
  if (p.srgb_from_camera.size() != 9) {
    reject(name, "photosites.srgb_from_camera has " + std::to_string(p.srgb_from_camera.size()) +
                     " numbers; it takes 9 or none");
  }
  const Eigen::Matrix3d m = srgb_from_camera(p);
  if (!m.allFinite() || !(m.determinant() > 1e-3)) {
    reject(name, "photosites.srgb_from_camera has a determinant of " +
                     std::to_string(m.determinant()) + "; it must be above 0.001");
  }
  for (int row = 0; row < 3; ++row) {
    if (std::abs(m.row(row).sum() - 1) < 1e-6) continue;
    reject(name, "photosites.srgb_from_camera's row " + std::to_string(row) + " sums to " +
                     std::to_string(m.row(row).sum()) + "; white stays white only with 1");
  }
}

}  // namespace

std::string_view to_string(ToneCurve curve) {
  return kToneNames.at(static_cast<std::size_t>(curve)).second;
}

ToneCurve tone_curve_from_string(std::string_view text) {
  std::string names;
  for (const auto& [curve, name] : kToneNames) {
    if (name == text) return curve;
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  throw std::invalid_argument("tone curve \"" + std::string(text) + "\" is not one of " + names);
}

Fields fields(CameraSensorConfig& config) {
  const Fields size = {{"width_px", &config.width_px, "image width", 16, 65535},
                       {"height_px", &config.height_px, "image height", 16, 65535}};
  return size + nested("lens", lens_fields(config.lens)) +
         nested("photosites", photosites_fields(config.photosites)) +
         nested("develop", develop_fields(config.develop));
}

void validate(const CameraSensorConfig& config, const std::string& name) {
  CameraSensorConfig copy = config;
  check_limits(fields(copy), name);
  const PhotositesConfig& p = config.photosites;
  if (p.black_level >= (1 << p.bits) - 1) {
    reject(name, "photosites.black_level = " + std::to_string(p.black_level) +
                     " must be below the largest code " + std::to_string((1 << p.bits) - 1));
  }
  check_colours(p, name);
  check_lens(config, name);
}

Camera nominal_camera(const CameraSensorConfig& config) {
  const LensConfig& lens = config.lens;
  Camera camera;
  camera.model = lens.model;
  camera.width_px = config.width_px;
  camera.height_px = config.height_px;
  camera.fx_px = lens.focal_px_per_width * config.width_px;
  camera.fy_px = camera.fx_px * lens.focal_y_over_x;
  camera.cx_px = 0.5 * (config.width_px - 1) + lens.centre_x_px_per_width * config.width_px;
  camera.cy_px = 0.5 * (config.height_px - 1) + lens.centre_y_px_per_width * config.width_px;
  std::copy_n(lens.distortion.begin(), std::min(lens.distortion.size(), camera.distortion.size()),
              camera.distortion.begin());
  camera.spline = lens.spline;
  return camera;
}

Eigen::Matrix3d srgb_from_camera(const PhotositesConfig& config) {
  if (config.srgb_from_camera.empty()) return Eigen::Matrix3d::Identity();
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      config.srgb_from_camera.data());
}

double dark_electrons(const PhotositesConfig& p) {
  return p.dark_current_e_per_s * p.exposure_s *
         std::exp2((p.temperature_k - p.dark_reference_k) / p.dark_doubling_k);
}

double codes_per_electron(const PhotositesConfig& p) {
  return ((1 << p.bits) - 1 - p.black_level) / p.full_well_e;
}

}  // namespace cousin
