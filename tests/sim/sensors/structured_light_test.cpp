#include "sim/sensors/structured_light.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>

#include "sim/sensors/range_rig.h"

namespace cousin {
namespace {

StructuredLightConfig camera() { return structured_light_preset("kinect_v1"); }

/// A plane turned about the vertical, through the axis at a depth.
StructuredLightInputs plane(const StructuredLightConfig& config, double z_m, double turn_rad) {
  StructuredLightInputs in{Image<float>(config.columns, config.rows),
                           Image<Eigen::Vector3f>(config.columns, config.rows)};
  const Eigen::Vector3d normal(std::sin(turn_rad), 0, -std::cos(turn_rad));
  for (int y = 0; y < config.rows; ++y) {
    for (int x = 0; x < config.columns; ++x) {
      const Eigen::Vector3d ray((x - 0.5 * (config.columns - 1)) / config.focal_px,
                                (y - 0.5 * (config.rows - 1)) / config.focal_px, 1);
      in.depth_m(x, y) = static_cast<float>(normal.z() * z_m / normal.dot(ray));
      in.normal(x, y) = normal.cast<float>();
    }
  }
  return in;
}

/// RMS error over the image's middle and what `law` says of each pixel.
std::pair<double, double> spread(const StructuredLightConfig& config,
                                 const StructuredLightInputs& in,
                                 const std::function<double(double, double)>& law) {
  const StructuredLightDepth depth = sense_structured_light(in, config, Rng(3));
  double n = 0, squares = 0, expected = 0;
  for (int y = 120; y < 360; ++y) {
    for (int x = 160; x < 480; ++x) {
      if (depth.depth(x, y) == 0) continue;
      const auto z = static_cast<double>(in.depth_m(x, y));
      const Eigen::Vector3d ray((x - 319.5) / config.focal_px, (y - 239.5) / config.focal_px, 1);
      n += 1;
      squares += std::pow(depth.depth(x, y) * config.depth_unit_m - z, 2);
      expected +=
          std::pow(law(z, std::acos(-ray.normalized().dot(in.normal(x, y).cast<double>()))), 2);
    }
  }
  return {std::sqrt(squares / n), std::sqrt(expected / n)};
}

TEST(StructuredLight, AxialNoiseIsNguyens) {
  const StructuredLightConfig config = camera();
  // 0.0012 + 0.0019 * 0.36 + 0.0001 * 1 at 1 m and 45 degrees.
  EXPECT_NEAR(axial_sigma_m(config, 1, M_PI / 4), 0.0012 + 0.000684 + 0.0001, 1e-9);
  for (const auto& [z, turn] : {std::pair{0.8, 0.4}, {1.5, 0.6}, {1.9, 0.3}}) {
    const auto [found, expected] =
        spread(config, plane(config, z, turn),
               [&](double at, double theta) { return axial_sigma_m(config, at, theta); });
    // 76800 pixels: 0.3 %; depth goes as 1 / code, whose curvature and the millimetre add some.
    EXPECT_NEAR(found / expected, 1, 0.03) << z;
  }
}

TEST(StructuredLight, CodesSpreadAsBarronAndMalikWroteThem) {
  StructuredLightConfig config = camera();
  config.axial = AxialNoise::barron_malik;
  config.depth_unit_m = 1e-4;
  // 35130 = f b / step in centimetres.
  EXPECT_NEAR(100 * config.focal_px * config.baseline_m / config.disparity_step_px, 35130, 1);
  const auto [found, expected] = spread(config, plane(config, 1.5, 0.4), [&](double z, double) {
    return z * z / 351.3 * std::sqrt(1 / 36.0 + 1 / 12.0);
  });
  EXPECT_NEAR(found / expected, 1, 0.02);
  const StructuredLightDepth depth =
      sense_structured_light(plane(config, 1.5, 0.4), config, Rng(3));
  for (const int x : {200, 320, 440}) {
    const double code = 351.3 / (depth.depth(x, 240) * config.depth_unit_m);
    EXPECT_NEAR(code, std::round(code), 0.02) << x;  // rounding to 0.1 mm is 0.008 of a code
  }
}

TEST(StructuredLight, EdgesMoveByTheLateralNoise) {
  StructuredLightConfig config = camera();
  StructuredLightInputs in = plane(config, 1, 0);
  for (int y = 0; y < config.rows; ++y) {
    for (int x = 0; x < 320; ++x)
      in.depth_m(x, y) = 2;  // the projector's shadow is on the far left
  }
  config.lateral_px = 3;
  config.lateral_tilt_px = 0;
  const StructuredLightDepth depth = sense_structured_light(in, config, Rng(3));
  // k pixels from the edge, noise reaches the far wall with P(N(0, 3) < -(k + 0.5)); that part of
  // it lies in the plate's shadow: 22 px left of it. 440 draws: 2.4 points each.
  for (const int k : {0, 1, 3}) {
    double moved = 0;
    for (int y = 20; y < 460; ++y)
      moved += depth.reason(320 + k, y) == InvalidReason::no_projector ? 1 : 0;
    EXPECT_NEAR(moved / 440, 0.5 * std::erfc((k + 0.5) / 3 / std::sqrt(2.0)), 0.09) << k;
  }
}

TEST(StructuredLight, SaysWhyThereIsNoDepth) {
  const StructuredLightConfig config = camera();
  StructuredLightInputs in = plane(config, 2, 0);
  for (int y = 200; y < 280; ++y) {
    for (int x = 300; x < 340; ++x) in.depth_m(x, y) = 0.8F;
  }
  in.depth_m(100, 100) = std::numeric_limits<float>::quiet_NaN();
  in.normal(500, 100) = {1, 0, -0.01F};
  in.normal(500, 100).normalize();
  const StructuredLightDepth depth = sense_structured_light(in, config, Rng(3));
  // The shadow is f b (1/0.8 - 1/2) = 33 px wide, left of the plate: the projector is to the right.
  EXPECT_EQ(depth.reason(285, 240), InvalidReason::no_projector);
  EXPECT_EQ(depth.reason(255, 240), InvalidReason::none);
  EXPECT_EQ(depth.reason(100, 100), InvalidReason::out_of_range);
  EXPECT_EQ(depth.reason(500, 100), InvalidReason::low_signal);
  EXPECT_EQ(depth.reason(2, 240), InvalidReason::band);
  EXPECT_EQ(sense_structured_light(plane(config, 3.5, 0), config, Rng(3)).reason(320, 240),
            InvalidReason::out_of_range);
}

TEST(StructuredLight, GivesTheSameBytesForAnyNumberOfThreads) {
  const StructuredLightConfig config = camera();
  const StructuredLightInputs in = plane(config, 1, 0.5);
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return sense_structured_light(in, config, Rng(3)).depth;
  };
  const Image<std::uint16_t> one = with_threads(1);
  EXPECT_EQ(one, with_threads(2));
  EXPECT_EQ(one, with_threads(7));
}

TEST(StructuredLight, RejectsWhatDoesNotFit) {
  StructuredLightConfig config = camera();
  EXPECT_THROW(sense_structured_light({}, config, Rng(3)), std::invalid_argument);
  config.least_depth_m = 5;
  EXPECT_THROW(validate(config), std::invalid_argument);
  EXPECT_THROW(structured_light_preset("kinect_v9"), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
