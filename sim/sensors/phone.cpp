#include "sim/sensors/phone.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"
#include "sim/sensors/hand_motion.h"
#include "sim/sensors/phone_presets.h"
#include "sim/sensors/photosites.h"

namespace cousin {
namespace {

[[noreturn]] void reject_phone(const std::string& what) {
  throw std::invalid_argument("phone: " + what);
}

void require(bool good, const char* key, double value, const char* limit) {
  if (!good) reject_phone(std::string(key) + " = " + std::to_string(value) + " must be " + limit);
}

Camera nominal_camera(const PhoneConfig& config) {
  Camera camera;
  camera.model = config.lens;
  camera.width_px = config.width_px;
  camera.height_px = config.height_px;
  camera.fx_px = camera.fy_px = config.focal_px_per_width * config.width_px;
  camera.cx_px = 0.5 * (config.width_px - 1);
  camera.cy_px = 0.5 * (config.height_px - 1);
  std::copy(config.distortion.begin(), config.distortion.end(), camera.distortion.begin());
  return camera;
}

/// Fixed pattern: mean plus sigma times a normal for each photosite; row y draws from rng.fork(y).
Image<Rgbf> fixed_pattern(int width, int height, double mean, double sigma, const Rng& rng) {
  Image<Rgbf> pattern(width, height);
  tbb::parallel_for(0, height, [&](int y) {
    const std::span<Rgbf> row = pattern.row(y);
    fixed_pattern_row({&row.front().r, 3 * row.size()}, mean, sigma,
                      rng.fork(static_cast<std::uint64_t>(y)));
  });
  return pattern;
}

}  // namespace

Fields fields(PhoneConfig& config) {
  const TextField lens{
      [&config] { return std::string(to_string(config.lens)); },
      [&config](const std::string& text) { config.lens = lens_model_from_string(text); }};
  return {
      {"lens", lens, "lens model: pinhole, opencv5, opencv8, opencv12 or kannala_brandt4"},
      {"width_px", &config.width_px, "image width", 16, 65535},
      {"height_px", &config.height_px, "image height", 16, 65535},
      {"focal_px_per_width", &config.focal_px_per_width, "focal length at infinity over the width",
       0.1, 100},
      {"distortion", &config.distortion, "true distortion coefficients, in the lens model's order",
       -100, 100},
      {"principal_offset_px_per_width", &config.principal_offset_px_per_width,
       "sigma of the principal point about the centre, over the width", 0, 0.1},
      {"autofocus", &config.autofocus,
       "focus on the scene for each image; false: focused at infinity"},
      {"focal_m", &config.focal_m, "physical focal length", 1e-4, 1},
      {"focus_error", &config.focus_error, "relative sigma of the focused distance", 0, 0.5},
      {"report_focal_error", &config.report_focal_error,
       "relative sigma of the reported focal length", 0, 0.2},
      {"report_focus_error", &config.report_focus_error,
       "relative sigma of the reported focus distance", 0, 0.5},
      {"report_centre_error_px_per_width", &config.report_centre_error_px_per_width,
       "sigma of the reported principal point, over the width", 0, 0.1},
      {"report_distortion_error", &config.report_distortion_error,
       "relative sigma of each reported distortion coefficient", 0, 1},
      {"electrons_at_unit_radiance", &config.electrons_at_unit_radiance,
       "exposure: electrons at radiance 1; 0: automatic", 0, 1e9},
      {"full_well_e", &config.full_well_e, "saturation", 10, 1e7},
      {"read_noise_e", &config.read_noise_e, "sigma of the read noise", 0, 1e4},
      {"prnu", &config.prnu, "relative sigma of the photosites' response", 0, 0.2},
      {"dsnu_e", &config.dsnu_e, "sigma of the photosites' offset", 0, 1e4},
      {"bits", &config.bits, "of the analog-to-digital converter", 8, 16},
      {"exposure_s", &config.exposure_s, "reported exposure time", 0, 60},
      {"readout_s", &config.readout_s, "first to last row; 0: global shutter", 0, 1},
      {"hand_speed_m_per_s", &config.hand_speed_m_per_s, "sigma of the hand's velocity, each axis",
       0, 10},
      {"hand_rate_rad_per_s", &config.hand_rate_rad_per_s,
       "sigma of the hand's turning rate, each axis", 0, 10},
      {"blur_sigma_px", &config.blur_sigma_px, "Gaussian blur of lens and pixel", 0, 10},
      {"vignetting_a", &config.vignetting_a,
       "gain = 1 + a r^2 + b r^4 + c r^6, r over the half diagonal", -1, 1},
      {"vignetting_b", &config.vignetting_b, "see vignetting_a", -1, 1},
      {"vignetting_c", &config.vignetting_c, "see vignetting_a", -1, 1},
      {"jpeg_quality", &config.jpeg_quality, "1 to 100; 0: no JPEG", 0, 100},
  };
}

void validate(const PhoneConfig& config) {
  PhoneConfig copy = config;
  check_limits(fields(copy), "phone");
  const int allowed = distortion_count(config.lens);
  if (static_cast<int>(config.distortion.size()) > allowed) {
    reject_phone("distortion has " + std::to_string(config.distortion.size()) +
                 " coefficients; lens " + std::string(to_string(config.lens)) + " takes at most " +
                 std::to_string(allowed));
  }
  for (const double k : config.distortion) require(std::isfinite(k), "distortion", k, "finite");
  // The gain must stay positive out to the corner of the farthest-off optical axis (r up to 1.2).
  for (int i = 0; i <= 24; ++i) {
    const double r2 = std::pow(0.05 * i, 2);
    const double gain =
        1 + r2 * (config.vignetting_a + r2 * (config.vignetting_b + r2 * config.vignetting_c));
    require(gain > 0, "vignetting gain", gain, "positive up to 1.2 half diagonals");
  }
  validate(nominal_camera(config));
}

PhoneUnit make_phone(const PhoneConfig& config, Rng rng) {
  validate(config);
  PhoneUnit unit;

  const LensUnit lens =
      draw_lens(nominal_camera(config),
                {.centre_px = config.principal_offset_px_per_width * config.width_px,
                 .report_focal = config.report_focal_error,
                 .report_centre_px = config.report_centre_error_px_per_width * config.width_px,
                 .report_distortion = config.report_distortion_error},
                rng);
  unit.camera_at_infinity = lens.at_infinity;
  unit.reported_at_infinity = lens.reported_at_infinity;

  const int width = config.width_px;
  const int height = config.height_px;
  unit.prnu_gain = fixed_pattern(width, height, 1, config.prnu, rng.fork("prnu"));
  unit.dsnu_e = fixed_pattern(width, height, 0, config.dsnu_e, rng.fork("dsnu"));
  return unit;
}

TrueView true_view(const PhoneConfig& config, const PhoneUnit& unit, const Scene& scene, int frame,
                   Rng rng) {
  if (frame < 0 || frame >= static_cast<int>(scene.views.size())) {
    reject_phone("frame " + std::to_string(frame) + " is not one of the scene's " +
                 std::to_string(scene.views.size()) + " views");
  }
  const View& seen = scene.views[static_cast<std::size_t>(frame)];
  TrueView view;
  view.frame = frame;
  view.time_s = seen.time_s;
  view.camera_from_world = seen.rig_from_world;
  view.camera_from_world_end = seen.rig_from_world;
  view.camera = unit.camera_at_infinity;
  view.readout_s = config.readout_s;

  if (config.autofocus) {
    Rng focus = rng.fork("focus");
    const double distance_m =
        (centre_in_world_m(seen.rig_from_world) - seen.focus_in_world_m).norm() *
        (1 + truncated_normal(focus, 0, config.focus_error));
    view.camera = with_focus(view.camera, focus_breathing(config.focal_m, distance_m));
  }
  if (config.readout_s > 0) {
    Rng hand = rng.fork("hand");
    const Eigen::Vector3d shift_m = config.readout_s * config.hand_speed_m_per_s * normal3(hand);
    const Eigen::Vector3d turn_rad = config.readout_s * config.hand_rate_rad_per_s * normal3(hand);
    Pose end_from_begin;
    end_from_begin.translation_m = shift_m;
    if (const double angle = turn_rad.norm(); angle > 0) {
      end_from_begin.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn_rad / angle));
    }
    view.camera_from_world_end = end_from_begin * seen.rig_from_world_end;
  }
  return view;
}

SensorReport report_of(const PhoneConfig& config, const PhoneUnit& unit) {
  SensorReport report;
  report.name = "rgb";
  report.camera = unit.reported_at_infinity;
  report.exposure_s = config.exposure_s;
  report.shutter = config.readout_s > 0 ? Shutter::rolling : Shutter::global;
  report.readout_s = config.readout_s;
  return report;
}

std::vector<std::string> phone_preset_names() { return preset_names(phone_preset_texts()); }

PhoneConfig phone_preset(const std::string& name) {
  return read_preset<PhoneConfig>(name, phone_preset_texts());
}

}  // namespace cousin
