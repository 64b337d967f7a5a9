#include "sim/sensors/camera_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <vector>

#include "sim/imaging/color.h"
#include "sim/sensors/metering.h"

namespace cousin {
namespace {

constexpr int kWidth = 320, kHeight = 240;

/// A camera whose lens does nothing; 1000 e at unit radiance.
CameraSensorConfig plain_camera(Mosaic mosaic = Mosaic::rggb) {
  CameraSensorConfig config;
  config.width_px = kWidth;
  config.height_px = kHeight;
  config.lens.model = LensModel::pinhole;
  config.photosites.mosaic = mosaic;
  config.photosites.electrons_at_unit_radiance = 1000;
  config.photosites.full_well_e = 8000;
  config.photosites.bits = 14;
  config.photosites.black_level = 600;
  return config;
}

/// 16 bits and ten million electrons: relative shot noise of 0.03 %.
CameraSensorConfig quiet_camera(Mosaic mosaic = Mosaic::rggb) {
  CameraSensorConfig config = plain_camera(mosaic);
  config.photosites.full_well_e = config.photosites.electrons_at_unit_radiance = 1e7;
  config.photosites.bits = 16;
  config.photosites.read_noise_e = config.photosites.prnu = config.photosites.dsnu_e = 0;
  return config;
}

Image<Rgbf> even(float r, float g, float b) { return {kWidth, kHeight, {r, g, b}}; }

Image<std::uint16_t> raw_of(const CameraSensorConfig& config, const Image<Rgbf>& radiance,
                            std::uint64_t seed = 2) {
  const CameraUnit unit = make_camera_unit(config, Rng(1));
  return expose(radiance, config, unit, unit.lens.at_infinity, Rng(seed));
}

double mean_code(const Image<std::uint16_t>& raw) {
  double sum = 0;
  for (const std::uint16_t code : raw) sum += code;
  return sum / static_cast<double>(raw.size());
}

double variance(const std::vector<double>& v) {
  double sum = 0, squares = 0;
  for (const double x : v) {
    sum += x;
    squares += x * x;
  }
  const auto n = static_cast<double>(v.size());
  return (squares - sum * sum / n) / (n - 1);
}

TEST(CameraSensor, DarkFramesLieAtTheBlackLevelWithNoiseOnBothSides) {
  CameraSensorConfig config = plain_camera();
  config.photosites.dsnu_e = 0;
  const Image<std::uint16_t> raw = raw_of(config, even(0, 0, 0));
  const double k = codes_per_electron(config.photosites);
  // 76 800 draws of 3 e: the mean is known to 0.011 e; allow five.
  EXPECT_NEAR(mean_code(raw), 600, 5 * 0.011 * k);
  EXPECT_LT(*std::min_element(raw.begin(), raw.end()), 600 - 8 * k);
}

TEST(CameraSensor, DarkCurrentGrowsWithTimeAndDoublesWithWarmth) {
  CameraSensorConfig config = plain_camera();
  PhotositesConfig& p = config.photosites;
  p.dsnu_e = 0;
  p.dark_current_e_per_s = 200;
  p.exposure_s = 0.5;
  p.dark_doubling_k = 7;
  p.temperature_k = p.dark_reference_k + 14;
  EXPECT_NEAR(dark_electrons(p), 200 * 0.5 * 4, 1e-9);
  const Image<std::uint16_t> raw = raw_of(config, even(0, 0, 0));
  const double k = codes_per_electron(p);
  std::vector<double> codes(raw.begin(), raw.end());
  // Poisson of 400 e: the mean is known to 0.07 e, the variance to 0.5 %; allow five.
  EXPECT_NEAR((mean_code(raw) - 600) / k, 400, 0.37);
  EXPECT_NEAR(variance(codes), code_variance(p, 0), 0.026 * code_variance(p, 0));
}

TEST(CameraSensor, RawIsLinearInLightAndPacksTheMosaic) {
  CameraSensorConfig config = quiet_camera(Mosaic::grbg);
  config.photosites.sensitivity_red = 0.5;
  config.photosites.sensitivity_blue = 0.8;
  const double full = 65535 - 600;
  for (const float light : {0.2F, 0.4F, 0.8F}) {
    const Image<std::uint16_t> raw = raw_of(config, even(light, light, light));
    const double expected[] = {0.5, 1, 0.8};
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        const double share = expected[bayer_channel(Mosaic::grbg, x, y)];
        // Shot noise: 5 sigmas of sqrt(8e6) e of 1e7.
        EXPECT_NEAR((raw(x, y) - 600) / full, share * static_cast<double>(light), 1.5e-3);
      }
    }
  }
}

TEST(CameraSensor, WhiteStaysWhiteAndColoursComeBackThroughTheMatrix) {
  CameraSensorConfig config = quiet_camera();
  PhotositesConfig& p = config.photosites;
  p.sensitivity_red = 0.55;
  p.sensitivity_blue = 0.65;
  p.srgb_from_camera = {1.6, -0.5, -0.1, -0.2, 1.5, -0.3, 0, -0.6, 1.6};
  p.electrons_at_unit_radiance = 8e6;
  for (const Rgbf colour :
       {Rgbf{0.5F, 0.5F, 0.5F}, Rgbf{0.6F, 0.3F, 0.2F}, Rgbf{0.1F, 0.5F, 0.4F}}) {
    const Image<Rgbf> linear =
        develop_linear(raw_of(config, even(colour.r, colour.g, colour.b)), config);
    // Shot noise of 1e6 e at least, times 3.5 for gains and matrix: five sigmas are 0.01.
    const Rgbf seen = linear(100, 100);
    EXPECT_NEAR(seen.r, 0.8F * colour.r, 0.01F);
    EXPECT_NEAR(seen.g, 0.8F * colour.g, 0.01F);
    EXPECT_NEAR(seen.b, 0.8F * colour.b, 0.01F);
  }
}

TEST(CameraSensor, OverexposureIsWhiteWhateverTheSensitivities) {
  for (const double red : {0.5, 1.4}) {
    CameraSensorConfig config = plain_camera();
    config.photosites.sensitivity_red = red;
    config.photosites.sensitivity_blue = 0.7;
    config.photosites.srgb_from_camera = {1.6, -0.5, -0.1, -0.2, 1.5, -0.3, 0, -0.6, 1.6};
    const Image<std::uint16_t> raw = raw_of(config, even(1000, 1000, 1000));
    EXPECT_EQ(*std::min_element(raw.begin(), raw.end()), (1 << 14) - 1);
    for (const Rgb8& pixel : develop(raw, config)) ASSERT_EQ(pixel, (Rgb8{255, 255, 255}));
  }
}

TEST(CameraSensor, AGreyCameraMeasuresLuminance) {
  const CameraSensorConfig config = quiet_camera(Mosaic::grey);
  const Image<Rgbf> linear = develop_linear(raw_of(config, even(0.9F, 0.3F, 0.6F)), config);
  const Rgbf seen = linear(5, 6);
  EXPECT_NEAR(seen.g, 0.2126F * 0.9F + 0.7152F * 0.3F + 0.0722F * 0.6F, 1.5e-3F);
  EXPECT_EQ(seen.r, seen.g);
  EXPECT_EQ(seen.b, seen.g);
}

TEST(CameraSensor, ToneCurvesAreTheOnesNamed) {
  CameraSensorConfig config = quiet_camera();
  const Image<std::uint16_t> raw = raw_of(config, even(0.5F, 0.5F, 0.5F));
  const auto code = [&](ToneCurve tone) {
    config.develop.tone = tone;
    return static_cast<int>(develop(raw, config)(50, 50).g);
  };
  EXPECT_NEAR(code(ToneCurve::srgb), srgb8_from_linear(0.5F), 1);
  EXPECT_NEAR(code(ToneCurve::linear), 127.5, 1);
  EXPECT_NEAR(code(ToneCurve::gamma), 255 * std::pow(0.5, 1 / 2.2), 1);
}

TEST(CameraSensor, ColumnsAndRowsKeepTheirOwnOffsets) {
  CameraSensorConfig config = plain_camera();
  PhotositesConfig& p = config.photosites;
  p.read_noise_e = p.dsnu_e = 0;
  p.column_dsnu_e = 20;
  p.row_dsnu_e = 10;
  const CameraUnit unit = make_camera_unit(config, Rng(1));
  const Image<std::uint16_t> a = expose(even(0, 0, 0), config, unit, unit.lens.at_infinity, Rng(2));
  const Image<std::uint16_t> b = expose(even(0, 0, 0), config, unit, unit.lens.at_infinity, Rng(3));
  EXPECT_EQ(a, b);  // nothing else is random in the dark
  const double k = codes_per_electron(p);
  std::vector<double> columns, rows;
  for (int x = 0; x < kWidth; ++x) columns.push_back((a(x, 7) - a(0, 7)) / k);
  for (int y = 0; y < kHeight; ++y) rows.push_back((a(9, y) - a(9, 0)) / k);
  // Relative error of sigma is 1 / sqrt(2 n): 4 % and 4.6 %; allow four.
  EXPECT_NEAR(std::sqrt(variance(columns)), 20, 0.16 * 20);
  EXPECT_NEAR(std::sqrt(variance(rows)), 10, 0.19 * 10);
  const Image<float> map = dsnu_map(config, unit);
  EXPECT_NEAR(a(31, 17) - 600, k * static_cast<double>(map(31, 17)), 0.51);
}

TEST(CameraSensor, RowNoiseIsNewInEachImage) {
  CameraSensorConfig config = plain_camera();
  config.photosites.read_noise_e = config.photosites.dsnu_e = 0;
  config.photosites.row_noise_e = 15;
  const Image<std::uint16_t> a = raw_of(config, even(0, 0, 0), 2);
  const Image<std::uint16_t> b = raw_of(config, even(0, 0, 0), 3);
  std::vector<double> difference;
  for (int y = 0; y < kHeight; ++y) {
    difference.push_back((a(0, y) - b(0, y)) / codes_per_electron(config.photosites));
    EXPECT_EQ(a(0, y), a(kWidth - 1, y));
  }
  EXPECT_NEAR(std::sqrt(variance(difference) / 2), 15, 0.19 * 15);  // 4 / sqrt(2 n)
}

TEST(CameraSensor, CodeVarianceIsTheMeasuredTemporalVariance) {
  CameraSensorConfig config = plain_camera(Mosaic::grey);
  config.photosites.dark_current_e_per_s = 500;
  config.photosites.row_noise_e = 1;
  for (const float light : {0.05F, 0.5F, 4.0F}) {
    const Image<std::uint16_t> a = raw_of(config, even(light, light, light), 2);
    const Image<std::uint16_t> b = raw_of(config, even(light, light, light), 3);
    std::vector<double> difference;
    for (std::size_t i = 0; i < a.size(); ++i) {
      difference.push_back(static_cast<double>(a.data()[i]) - b.data()[i]);
    }
    // Half the variance of 76 800 differences: relative sigma 0.5 %, and the rows' own draws 1 % of
    // at most a twentieth.
    const double expected = code_variance(config.photosites, 1000.0 * static_cast<double>(light));
    EXPECT_NEAR(0.5 * variance(difference), expected, 0.03 * expected) << light;
  }
}

TEST(CameraSensor, HandsOverRawAndSaysWhatItsNumbersMean) {
  CameraSensorConfig config = plain_camera(Mosaic::bggr);
  config.develop.raw = true;
  const CameraUnit unit = make_camera_unit(config, Rng(1));
  TrueView view;
  view.camera = unit.lens.at_infinity;
  const SensorFrame frame = sense(even(0.5F, 0.4F, 0.3F), config, unit, view, Rng(2));
  const SensorReport report = report_of(config, unit, "left", {});
  EXPECT_TRUE(report.linear_raw);
  EXPECT_EQ(report.raw_format, (RawFormat{Mosaic::bggr, 14, 600}));
  EXPECT_EQ(frame.color, develop(frame.raw, config));
  EXPECT_EQ(report.shutter, Shutter::global);

  config.develop.raw = false;
  EXPECT_TRUE(sense(even(0, 0, 0), config, unit, view, Rng(2)).raw.empty());
  EXPECT_EQ(report_of(config, unit, "left", {}).raw_format, RawFormat{});
}

TEST(CameraSensor, AutomaticExposureSeesWhatThePhotositesSee) {
  CameraSensorConfig config = plain_camera();
  config.photosites.electrons_at_unit_radiance = 0;
  config.photosites.sensitivity_red = 2;
  // Red photosites are the brightest, at twice their light.
  EXPECT_NEAR(electrons_per_radiance(config, even(0.5F, 0.2F, 0.2F)), 0.8 * 8000 / 1.0, 1e-2);
  EXPECT_EQ(electrons_per_radiance(config, even(0, 0, 0)), 0.8 * 8000);
}

TEST(CameraSensor, SpotMeteringBringsTheSpotsMeanToAQuarterOfFullWell) {
  CameraSensorConfig config = plain_camera();
  config.photosites.electrons_at_unit_radiance = 0;
  const MeteredSpot fruit{0.5 * kWidth, 0.5 * kHeight, 5};
  const auto sky_with_fruit = [&](const Rgbf& colour) {
    Image<Rgbf> radiance = even(1, 1, 1);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (std::hypot(x - fruit.x_px, y - fruit.y_px) < 8)
          radiance.row(y)[static_cast<std::size_t>(x)] = colour;
      }
    }
    return radiance;
  };
  const auto electrons = [&](const Rgbf& colour, const MeteredSpot& spot) {
    return metered(config, sky_with_fruit(colour), spot).photosites.electrons_at_unit_radiance;
  };
  const double full_well = config.photosites.full_well_e;
  // Radiances are single precision numbers: 1e-5 is plenty.
  EXPECT_NEAR(electrons({0.1F, 0.05F, 0.05F}, fruit), 0.25 * full_well / 0.1, 1e-5 * full_well);
  // What is ever so dark stays dark: all else would be white.
  EXPECT_NEAR(electrons({0, 0, 0}, fruit), 8 * 0.8 * full_well, 1e-5 * full_well);
  EXPECT_EQ(electrons({0, 0, 0}, {}), 0);  // left automatic
  config.photosites.electrons_at_unit_radiance = 123;
  EXPECT_EQ(electrons({0, 0, 0}, fruit), 123);
}

TEST(CameraSensor, GivesTheSameBytesOnAnyNumberOfThreads) {
  CameraSensorConfig config = plain_camera();
  config.lens.optics.red.scale = 1.003;
  config.lens.optics.blue.scale = 0.998;
  config.lens.optics.vignetting_a = -0.3;
  config.lens.optics.blur_sigma_px = 0.8;
  config.photosites.column_dsnu_e = config.photosites.row_dsnu_e = config.photosites.row_noise_e =
      2;
  config.develop.jpeg_quality = 90;
  Image<Rgbf> radiance(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      radiance(x, y) = {0.05F * static_cast<float>(x % 97), 0.02F * static_cast<float>(y), 0.3F};
    }
  }
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return develop(raw_of(config, radiance), config);
  };
  const Image<Rgb8> one = run(1);
  EXPECT_EQ(run(2), one);
  EXPECT_EQ(run(7), one);
}

TEST(CameraSensor, ASplinedLensIsDrawnAndReported) {
  CameraSensorConfig config = plain_camera();
  config.lens.model = LensModel::splined_stereographic;
  config.lens.spline = {.order = 3, .columns = 9, .rows = 8, .fov_x_rad = 1.9, .delta_u = {}};
  for (int i = 0; i < 144; ++i) config.lens.spline.delta_u.push_back(0.01 * std::sin(1.7 * i));
  config.lens.report_distortion_error = 0.1;
  const CameraUnit unit = make_camera_unit(config, Rng(1));
  const SplineLens& truth = unit.lens.at_infinity.spline;
  const SplineLens& reported = unit.lens.reported_at_infinity.spline;
  EXPECT_EQ(truth, config.lens.spline);
  EXPECT_NE(reported.delta_u, truth.delta_u);
  EXPECT_NEAR(reported.delta_u[5] / truth.delta_u[5], reported.delta_u[8] / truth.delta_u[8],
              1e-12);
}

TEST(CameraSensor, RejectsWhatCannotBeBuilt) {
  const auto message = [](auto change) {
    CameraSensorConfig config = plain_camera();
    change(config);
    try {
      validate(config, "left");
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  using testing::AllOf;
  using testing::HasSubstr;
  using Config = CameraSensorConfig;
  EXPECT_EQ(message([](Config&) {}), "accepted");
  EXPECT_THAT(message([](Config& c) { c.photosites.full_well_e = -1; }),
              AllOf(HasSubstr("left"), HasSubstr("full_well_e = -1")));
  EXPECT_THAT(message([](Config& c) { c.photosites.black_level = 16383; }),
              HasSubstr("below the largest code 16383"));
  EXPECT_THAT(message([](Config& c) {
                c.photosites.srgb_from_camera = {1, 0, 0};
              }),
              HasSubstr("takes 9 or none"));
  EXPECT_THAT(
      message([](Config& c) { c.photosites.srgb_from_camera = {1, 0, 0, 0, 1, 0, 0, 1, 1}; }),
      HasSubstr("row 2 sums to 2"));
  EXPECT_THAT(
      message([](Config& c) { c.photosites.srgb_from_camera = {1, 0, 0, 1, 0, 0, 1, 0, 0}; }),
      HasSubstr("determinant"));
  EXPECT_THAT(message([](Config& c) { c.lens.distortion = {0.1}; }), HasSubstr("at most 0"));
  EXPECT_THAT(message([](Config& c) { c.lens.optics.vignetting_a = -1; }),
              HasSubstr("vignetting gain"));
  EXPECT_THAT(message([](Config& c) { c.lens.optics.red.scale = 2; }), HasSubstr("red_scale"));
  EXPECT_THAT(message([](Config& c) { c.photosites.prnu = std::nan(""); }), HasSubstr("prnu"));
  EXPECT_THAT(message([](Config& c) { c.lens.model = LensModel::splined_stereographic; }),
              HasSubstr("columns = 0"));
}

TEST(CameraSensor, RejectsRadianceThatIsNotFiniteOrOfAnotherSize) {
  const CameraSensorConfig config = plain_camera();
  EXPECT_THROW(raw_of(config, Image<Rgbf>(kWidth - 1, kHeight)), std::invalid_argument);
  Image<Rgbf> radiance = even(0.5F, 0.5F, 0.5F);
  radiance(3, 4).r = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(raw_of(config, radiance), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
