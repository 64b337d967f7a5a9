#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/imaging/color.h"
#include "sim/sensors/phone.h"

namespace cousin {
namespace {

/// A small phone without noise: 16 000 000 e of full well leave relative shot noise of 0.03 %.
PhoneConfig quiet_phone() {
  PhoneConfig config;
  config.width_px = 160;
  config.height_px = 90;
  config.full_well_e = 1e7;
  config.electrons_at_unit_radiance = 1e7;
  config.bits = 16;
  config.read_noise_e = config.prnu = config.dsnu_e = 0;
  return config;
}

Scene one_view_at(double distance_m) {
  Scene scene;
  View view;
  view.rig_from_world = look_at({distance_m, 0, 0}, {0, 0, 0});
  view.rig_from_world_end = view.rig_from_world;
  scene.views = {view};
  return scene;
}

TrueView still_view(const PhoneUnit& unit) {
  TrueView view;
  view.camera = unit.camera_at_infinity;
  return view;
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(PhoneFocus, BreathesByTheThinLensLaw) {
  // 1/f = 1/Z + 1/v: at 0.3 m a 4.2 mm lens images at v = f (1 + 1.42 %).
  EXPECT_NEAR(focus_breathing(0.0042, 0.3), 1 / (1 - 0.0042 / 0.3), 1e-15);
  PhoneConfig config = quiet_phone();
  config.focus_error = 0;
  const PhoneUnit unit = make_phone(config, Rng(1));
  const TrueView view = true_view(config, unit, one_view_at(0.3), 0, Rng(2));
  EXPECT_NEAR(view.camera.fx_px / unit.camera_at_infinity.fx_px, 1 / (1 - 0.0042 / 0.3), 1e-12);
  EXPECT_THROW(focus_breathing(0.0042, 0.008), std::invalid_argument);
}

TEST(PhoneFocus, LocksAtInfinityWithoutAutofocus) {
  PhoneConfig config = quiet_phone();
  config.autofocus = false;
  const PhoneUnit unit = make_phone(config, Rng(1));
  const TrueView view = true_view(config, unit, one_view_at(0.3), 0, Rng(2));
  EXPECT_EQ(view.camera, unit.camera_at_infinity);
}

TEST(PhoneReport, EqualsTheTruthWhenItsErrorsAreZero) {
  PhoneConfig config = quiet_phone();
  config.report_focal_error = config.report_focus_error = 0;
  config.report_centre_error_px_per_width = config.report_distortion_error = 0;
  const PhoneUnit unit = make_phone(config, Rng(1));
  const TrueView view = true_view(config, unit, one_view_at(0.4), 0, Rng(2));
  const SensorFrame frame =
      sense(Image<Rgbf>(160, 90, {0.5F, 0.5F, 0.5F}), config, unit, view, Rng(3));
  EXPECT_NEAR(frame.reported.fx_px, view.camera.fx_px, 1e-9);
  EXPECT_EQ(frame.reported.cx_px, view.camera.cx_px);
  EXPECT_EQ(frame.reported.distortion, view.camera.distortion);
}

TEST(PhoneReport, DiffersFromTheTruthByTheConfiguredErrors) {
  PhoneConfig config = quiet_phone();
  config.width_px = 32;
  config.height_px = 18;
  std::vector<double> focal, centre, distortion;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const PhoneUnit unit = make_phone(config, Rng(seed));
    focal.push_back(unit.reported_at_infinity.fx_px / unit.camera_at_infinity.fx_px - 1);
    centre.push_back(unit.reported_at_infinity.cx_px - unit.camera_at_infinity.cx_px);
    distortion.push_back(
        unit.reported_at_infinity.distortion[0] / unit.camera_at_infinity.distortion[0] - 1);
  }
  // Normals cut at 2.5 sigma keep 0.9546 of their sigma; 400 draws know it to 3.5 %, allow four.
  constexpr double kCut = 0.9546;
  EXPECT_NEAR(rms(focal), kCut * config.report_focal_error, 0.14 * config.report_focal_error);
  EXPECT_NEAR(rms(centre), kCut * 0.032, 0.14 * 0.032);
  EXPECT_NEAR(rms(distortion), kCut * config.report_distortion_error,
              0.14 * config.report_distortion_error);
}

TEST(PhoneShutter, MovesTheCameraByTheHandWhileRowsAreRead) {
  PhoneConfig config = quiet_phone();
  const PhoneUnit unit = make_phone(config, Rng(1));
  const Scene scene = one_view_at(0.4);
  std::vector<double> shift, turn;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const TrueView view = true_view(config, unit, scene, 0, Rng(seed));
    EXPECT_EQ(view.readout_s, config.readout_s);
    const Pose end_from_begin = view.camera_from_world_end * inverse(view.camera_from_world);
    for (int axis = 0; axis < 3; ++axis) shift.push_back(end_from_begin.translation_m[axis]);
    turn.push_back(angle_rad(end_from_begin.rotation) / std::sqrt(3.0));
  }
  // 6000 normals: relative sigma 0.9 %; allow four.
  EXPECT_NEAR(rms(shift) / (config.readout_s * config.hand_speed_m_per_s), 1, 0.04);
  EXPECT_NEAR(rms(turn) / (config.readout_s * config.hand_rate_rad_per_s), 1, 0.04);

  config.readout_s = 0;
  const TrueView still = true_view(config, unit, scene, 0, Rng(1));
  EXPECT_EQ(still.camera_from_world_end.translation_m, still.camera_from_world.translation_m);
  EXPECT_EQ(report_of(config, unit).shutter, Shutter::global);
}

TEST(PhoneShutter, RefusesAViewThatTheSceneDoesNotHave) {
  const PhoneConfig config = quiet_phone();
  const PhoneUnit unit = make_phone(config, Rng(1));
  EXPECT_THROW(true_view(config, unit, one_view_at(0.4), 1, Rng(1)), std::invalid_argument);
  EXPECT_THROW(true_view(config, unit, one_view_at(0.4), -1, Rng(1)), std::invalid_argument);
}

TEST(PhoneOptics, VignettingFollowsItsPolynomial) {
  PhoneConfig config = quiet_phone();
  config.blur_sigma_px = 0;
  const PhoneUnit unit = make_phone(config, Rng(1));
  const Image<LinearCode> codes =
      expose(Image<Rgbf>(160, 90, {0.9F, 0.9F, 0.9F}), config, unit, still_view(unit), Rng(2));
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(80, 45), std::pair(159, 30)}) {
    const double r2 = (std::pow(x - unit.camera_at_infinity.cx_px, 2) +
                       std::pow(y - unit.camera_at_infinity.cy_px, 2)) /
                      (0.25 * (160 * 160 + 90 * 90));
    const double gain = 1 + r2 * (config.vignetting_a + r2 * config.vignetting_b);
    // Shot noise at 9e6 e is 0.033 %; allow five.
    EXPECT_NEAR(codes(x, y).g / 65535.0, 0.9 * gain, 0.0017) << x << ' ' << y;
  }
}

TEST(PhoneOptics, BlurSpreadsAPointByItsSigma) {
  PhoneConfig config = quiet_phone();
  config.blur_sigma_px = 1.2;
  config.vignetting_a = config.vignetting_b = 0;
  const PhoneUnit unit = make_phone(config, Rng(1));
  Image<Rgbf> radiance(160, 90);
  radiance(70, 40) = {1, 1, 1};
  const Image<LinearCode> codes = expose(radiance, config, unit, still_view(unit), Rng(2));
  double sum = 0, xx = 0, yy = 0;
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 160; ++x) {
      sum += codes(x, y).r;
      xx += codes(x, y).r * std::pow(x - 70, 2);
      yy += codes(x, y).r * std::pow(y - 40, 2);
    }
  }
  // A sampled Gaussian has the variance of the continuous one (aliasing below 1e-10), cut at four
  // sigmas.
  EXPECT_NEAR(xx / sum, 1.44, 0.02);
  EXPECT_NEAR(yy / sum, 1.44, 0.02);
  EXPECT_NEAR(sum / 65535, 1, 0.002);
}

TEST(PhoneProcessing, AppliesTheSrgbCurveToTheLinearSignal) {
  PhoneConfig config = quiet_phone();
  config.vignetting_a = config.vignetting_b = 0;
  const PhoneUnit unit = make_phone(config, Rng(1));
  const SensorFrame frame =
      sense(Image<Rgbf>(160, 90, {0.5F, 0.2F, 0.0F}), config, unit, still_view(unit), Rng(2));
  for (const Rgb8& pixel : frame.color) {
    // One code of slack: shot noise may cross a rounding edge.
    ASSERT_NEAR(pixel.r, srgb8_from_linear(0.5F), 1);
    ASSERT_NEAR(pixel.g, srgb8_from_linear(0.2F), 1);
    ASSERT_EQ(pixel.b, 0);
  }
}

TEST(PhoneProcessing, JpegKeepsTheImageNearly) {
  PhoneConfig config = quiet_phone();
  const PhoneUnit unit = make_phone(config, Rng(1));
  Image<Rgbf> radiance(160, 90);
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 160; ++x) {
      const auto v = static_cast<float>(0.4 + 0.3 * std::sin(0.1 * x) * std::cos(0.13 * y));
      radiance(x, y) = {v, 0.8F * v, 0.5F * v};
    }
  }
  const SensorFrame exact = sense(radiance, config, unit, still_view(unit), Rng(2));
  config.jpeg_quality = 90;
  const SensorFrame jpeg = sense(radiance, config, unit, still_view(unit), Rng(2));
  EXPECT_NE(jpeg.color, exact.color);
  std::vector<double> difference;
  for (std::size_t i = 0; i < exact.color.size(); ++i) {
    difference.push_back(double(jpeg.color.data()[i].g) - exact.color.data()[i].g);
  }
  EXPECT_LT(rms(difference), 2);  // of 255, on a smooth image at quality 90
}

}  // namespace
}  // namespace cousin
