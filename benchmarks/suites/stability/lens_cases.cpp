#include "benchmarks/suites/stability/lens_cases.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/imaging/rectification.h"
#include "sim/sensors/active_stereo.h"
#include "sim/sensors/rig.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

/// 1 if the call throws std::invalid_argument, as it must.
double refused(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument&) {
    return 1;
  }
  return 0;
}

Camera wide_splined(double fov_x_rad, double bend) {
  Camera camera{LensModel::splined_stereographic, 1280, 960, 300, 300, 639.5, 479.5, {}, {}};
  camera.spline = {.order = 3, .columns = 18, .rows = 16, .fov_x_rad = fov_x_rad, .delta_u = {}};
  for (int j = 0; j < 16; ++j) {
    for (int i = 0; i < 18; ++i) {
      camera.spline.delta_u.push_back(bend * ((i + j) % 2 == 0 ? 1 : -1));
      camera.spline.delta_u.push_back(bend * (i % 2 == 0 ? 1 : -1));
    }
  }
  return camera;
}

/// Largest distance in pixels between a pixel and where its ray projects; infinite where it has
/// none.
double round_trip_px(const Camera& camera) {
  Rng rng(3);
  double largest = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector2d pixel(uniform(rng, -0.5, camera.width_px - 0.5),
                                uniform(rng, -0.5, camera.height_px - 0.5));
    const auto ray = unproject(camera, pixel);
    const auto back = ray ? project(camera, *ray) : std::nullopt;
    if (!back) return std::numeric_limits<double>::infinity();
    largest = worse(largest, (*back - pixel).norm());
  }
  return largest;
}

/// Knots' bend at which the checkerboard of `wide_splined` just still unfolds, by bisection.
double last_bend(double fov_x_rad) {
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    const bool folds = refused([&] { validate(wide_splined(fov_x_rad, middle)); }) == 1;
    (folds ? high : low) = middle;
  }
  return low;
}

std::vector<StabilityRow> lenses() {
  Camera folding{LensModel::opencv5, 640, 480, 400, 400, 319.5, 239.5, {}, {}};
  folding.distortion = {-0.9};
  const double wide = 3.9;
  const double bend = last_bend(wide);
  return {
      make_row("polynomial that folds inside the image", "refused", "", 1,
               refused([&] { validate(folding); }), false),
      make_row("spline that folds inside the image", "refused", "", 1,
               refused([&] { validate(wide_splined(wide, 1.1 * bend)); }), false),
      make_row("spline that reaches not over the image", "refused", "", 1,
               refused([&] { validate(wide_splined(1.0, 0)); }), false),
      make_row("splined lens of 223 degrees", "round trip", "px", 1e-9,
               round_trip_px(wide_splined(wide, 0.3 * bend))),
      make_row("spline bent to just before folding", "round trip", "px", 1e-6,
               round_trip_px(wide_splined(wide, 0.999 * bend))),
      make_row("point straight behind a splined lens", "given a pixel", "", 0,
               project(wide_splined(wide, 0), {0, 0, -1}).has_value() ? 1 : 0),
  };
}

/// A colour camera of 64 x 48 of the DSLR's photosites.
CameraSensorConfig small_camera() {
  CameraSensorConfig config = rig_preset("dslr_apsc_24mp").sensors.front().camera;
  config.width_px = 64;
  config.height_px = 48;
  return config;
}

Image<std::uint16_t> raw_at(const CameraSensorConfig& config, float radiance) {
  const CameraUnit unit = make_camera_unit(config, Rng(1));
  return expose(Image<Rgbf>(64, 48, {radiance, radiance, radiance}), config, unit,
                unit.lens.at_infinity, Rng(2));
}

std::vector<StabilityRow> lights() {
  CameraSensorConfig fixed = small_camera();
  fixed.photosites.electrons_at_unit_radiance = 1000;
  const Image<Rgb8> white = develop(raw_at(fixed, 1e30F), fixed);
  const auto white_share =
      static_cast<double>(std::count(white.begin(), white.end(), Rgb8{255, 255, 255})) /
      static_cast<double>(white.size());
  const Image<std::uint16_t> dark = raw_at(small_camera(), 0);  // automatic exposure of black
  double sum = 0;
  for (const std::uint16_t code : dark) sum += code;
  const double offset = sum / static_cast<double>(dark.size()) - fixed.photosites.black_level;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RigConfig namesakes = rig_preset("zed_hd720");
  namesakes.sensors[1].name = namesakes.sensors[0].name;
  return {
      make_row("radiance of 1e30", "share of white pixels", "", 1, white_share, false),
      // 3072 photosites of 3.2 e and 0.42 codes an electron: the mean is known to 0.024 codes.
      make_row("no light, automatic exposure", "mean from the black level", "DN", 0.12,
               std::abs(offset)),
      make_row("radiance that is no number", "refused", "", 1,
               refused([&] { raw_at(fixed, static_cast<float>(nan)); }), false),
      make_row("rig whose cameras share a name", "refused", "", 1,
               refused([&] { validate(namesakes); }), false),
  };
}

/// Two cameras in one place see no depth: whoever asks for it is told so. To take pictures with
/// such a rig is no mistake.
std::vector<StabilityRow> coincident_cameras() {
  RigConfig rig = rig_preset("zed_hd720");
  rig.sensors[1].centre_in_rig_m = rig.sensors[0].centre_in_rig_m;
  const RigUnit unit = make_rig(rig, Rng(1));
  const std::vector<SensorReport> reports = report_of(rig, unit);
  const Pose right_from_left = reports[1].sensor_from_rig * inverse(reports[0].sensor_from_rig);
  std::string told;
  try {
    rectify(reports[0].camera, reports[1].camera, right_from_left);
  } catch (const std::invalid_argument& error) {
    told = error.what();
  }
  ActiveStereoConfig device = active_stereo_preset("d457");
  device.baseline_m = 0;
  const char* const kName = "rig whose two cameras coincide";
  return {
      make_row(kName, "accepted as cameras", "", 0, refused([&] { validate(rig); })),
      make_row(kName, "stereo depth refused, and why", "", 1,
               told.find("the cameras coincide") != std::string::npos ? 1 : 0, false),
      make_row("depth camera of baseline 0", "refused", "", 1, refused([&] { validate(device); }),
               false),
  };
}

}  // namespace

std::vector<StabilityRow> lens_cases() {
  std::vector<StabilityRow> rows = lenses();
  for (const std::vector<StabilityRow>& more : {lights(), coincident_cameras()})
    rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

}  // namespace cousin
