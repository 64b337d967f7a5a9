#include "perception/segment/grains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "benchmarks/suites/real/rice_grains.h"
#include "sim/imaging/color.h"
#include "sim/imaging/image_io.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

struct Shape {
  Eigen::Vector2d centre_px;
  double length_px, width_px, angle_rad;
  bool is_bar = false;
};

bool covers(const Shape& s, double x, double y) {
  const double dx = x - s.centre_px.x(), dy = y - s.centre_px.y();
  const double u = (std::cos(s.angle_rad) * dx + std::sin(s.angle_rad) * dy) / (0.5 * s.length_px);
  const double v = (-std::sin(s.angle_rad) * dx + std::cos(s.angle_rad) * dy) / (0.5 * s.width_px);
  return s.is_bar ? std::max(std::abs(u), std::abs(v)) <= 1 : u * u + v * v <= 1;
}

/// Shapes on a dark ground, 8 x 8 samples a pixel in linear light: grains 0.4, bars 0.9, ground
/// 0.02.
Image<Rgb8> drawn(int width, int height, const std::vector<Shape>& shapes) {
  constexpr int kSamples = 8;
  Image<float> light(width, height, 0.02F);
  for (const Shape& s : shapes) {
    const double reach = 0.75 * s.length_px + 2;
    const int x0 = std::max(0, static_cast<int>(s.centre_px.x() - reach)),
              x1 = std::min(width, static_cast<int>(s.centre_px.x() + reach));
    const int y0 = std::max(0, static_cast<int>(s.centre_px.y() - reach)),
              y1 = std::min(height, static_cast<int>(s.centre_px.y() + reach));
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        int count = 0;
        for (int k = 0; k < kSamples * kSamples; ++k) {
          count += covers(s, x - 0.5 + (k % kSamples + 0.5) / kSamples,
                          y - 0.5 + (k / kSamples + 0.5) / kSamples)
                       ? 1
                       : 0;
        }
        const float share = static_cast<float>(count) / (kSamples * kSamples);
        light(x, y) += share * ((s.is_bar ? 0.9F : 0.4F) - light(x, y));
      }
    }
  }
  Image<Rgb8> image(width, height);
  std::transform(light.begin(), light.end(), image.begin(), [](float v) {
    const std::uint8_t code = srgb8_from_linear(v);
    return Rgb8{code, code, code};
  });
  return image;
}

constexpr double kStrip_px = 1000;  // 100 mm: 0.1 mm a pixel
const Shape kStrip{{620, 60}, kStrip_px, 60, 0.02, true};

TEST(Grains, EllipsesBesideAStripAreMeasuredWithinOnePercent) {
  std::vector<Shape> shapes = {kStrip};
  for (int i = 0; i < 12; ++i) {
    shapes.push_back(
        {{120.3 + 90.4 * i, 260.7 + 30.2 * (i % 3)}, 70.0 + i, 28.0 + 0.5 * i, 0.27 * i});
  }
  const GrainPhoto photo = measure_grains(drawn(1260, 420, shapes));
  ASSERT_EQ(photo.status, GrainStatus::ok);
  ASSERT_EQ(photo.strips.size(), 1U);
  EXPECT_NEAR(photo.strips[0].length_px, kStrip_px, 0.5);
  EXPECT_NEAR(photo.strips[0].angle_rad, 0.02, 0.002);
  ASSERT_EQ(photo.grains.size(), 12U);
  EXPECT_TRUE(photo.touching_px.empty());
  for (int i = 0; i < 12; ++i) {
    const Shape& truth = shapes[static_cast<std::size_t>(i) + 1];
    const auto grain = std::find_if(photo.grains.begin(), photo.grains.end(), [&](const Grain& g) {
      return (g.centre_px - truth.centre_px).norm() < 1;
    });
    ASSERT_NE(grain, photo.grains.end()) << i;
    // Blur draws in a curved edge: sigma^2 / (2 radius), 0.04 px at these tips.
    EXPECT_NEAR(grain->length_m, truth.length_px * 1e-4, 0.01 * truth.length_px * 1e-4) << i;
    EXPECT_NEAR(grain->width_m, truth.width_px * 1e-4, 0.01 * truth.width_px * 1e-4) << i;
  }
}

TEST(Grains, GrainsThatTouchAreCountedAndNotMeasured) {
  const std::vector<Shape> shapes = {kStrip,
                                     {{200, 250}, 75, 30, 0.0},  // end to end
                                     {{273, 250}, 75, 30, 0.0},
                                     {{500, 250}, 75, 30, 0.3},  // side by side, turned
                                     {{510, 277}, 75, 30, 0.9},
                                     {{800, 250}, 75, 30, 1.0}};  // alone
  const GrainPhoto photo = measure_grains(drawn(1260, 420, shapes));
  ASSERT_EQ(photo.status, GrainStatus::ok);
  EXPECT_EQ(photo.grains.size(), 1U);
  EXPECT_EQ(photo.touching_px.size(), 2U);
}

TEST(Grains, AStripCutShortDoesNotChangeTheScale) {
  Shape cut = kStrip;
  cut.centre_px = {620, 360};
  cut.length_px = 0.945 * kStrip_px;
  const GrainPhoto photo =
      measure_grains(drawn(1260, 420, {kStrip, cut, {{600, 210}, 75, 30, 0.4}}));
  ASSERT_EQ(photo.status, GrainStatus::ok);
  ASSERT_EQ(photo.strips.size(), 2U);
  EXPECT_NEAR(photo.m_per_px, 1e-4, 1e-7);
  EXPECT_NEAR(photo.strips[1].length_px, 0.945 * kStrip_px, 0.5);
}

TEST(Grains, WithoutStripOrGrainsItIsAStatus) {
  EXPECT_EQ(measure_grains({}).status, GrainStatus::no_strip);
  EXPECT_THROW(measure_grains({}, {.least_length_m = 0.02}), std::invalid_argument);
  EXPECT_EQ(measure_grains(Image<Rgb8>(64, 64)).status, GrainStatus::no_strip);
  EXPECT_EQ(measure_grains(Image<Rgb8>(64, 64, Rgb8{255, 255, 255})).status, GrainStatus::no_strip);
  EXPECT_EQ(measure_grains(drawn(1260, 420, {{{600, 210}, 75, 30, 0.4}})).status,
            GrainStatus::no_strip);
  EXPECT_EQ(measure_grains(drawn(1260, 420, {kStrip})).status, GrainStatus::no_grains);
  GrainConfig config;
  config.strip_length_m = 0;
  EXPECT_THROW(measure_grains({}, config), std::invalid_argument);
}

TEST(Grains, OfARealPhotographHaveTheSizeOfRiceAndTheScannersScale) {
  const std::filesystem::path file = real_data() / "images/grainpheno_rice/Test1_100mm_ruler.jpg";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "real captures are absent: " << file;
  const GrainPhoto photo = measure_grains(read_color(file));
  ASSERT_EQ(photo.status, GrainStatus::ok);
  EXPECT_EQ(photo.strips.size(), 2U);
  EXPECT_GT(photo.grains.size(), 40U);
  // Paper strips are cut by hand to about a millimetre; the scanner states 300 pixels an inch.
  EXPECT_NEAR(photo.m_per_px / stated_m_per_px(file), 1.0, 0.01);
  for (const Grain& grain : photo.grains) {
    EXPECT_GT(grain.length_m, 0.005);  // no rice in the husk is shorter than 5 mm or longer than 12
    EXPECT_LT(grain.length_m, 0.012);
    EXPECT_GT(grain.width_m, 0.0015);
    EXPECT_LT(grain.width_m, 0.0045);
  }
}

}  // namespace
}  // namespace cousin
