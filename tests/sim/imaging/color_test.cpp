#include "sim/imaging/color.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cousin {
namespace {

TEST(Colour, CodesRoundTrip) {
  for (int code = 0; code < 256; ++code) {
    EXPECT_EQ(srgb8_from_linear(linear_from_srgb8(static_cast<std::uint8_t>(code))), code);
  }
}

TEST(Colour, CurveHasTheStandardsValues) {
  // IEC 61966-2-1: 12.92 below the knee; middle grey 0.5 is 0.735357 in code; the inverse undoes
  // it.
  EXPECT_FLOAT_EQ(srgb_from_linear(0.002F), 0.02584F);
  EXPECT_NEAR(srgb_from_linear(0.5F), 0.7353570F, 1e-6);
  for (float x = 0; x <= 1; x += 1.0F / 512)
    EXPECT_NEAR(linear_from_srgb(srgb_from_linear(x)), x, 1e-6);
}

TEST(Colour, CodeIsTheRoundedCurveEverywhere) {
  // Steps finer than a float's resolution of a code edge are checked by walking across each edge.
  for (int code = 1; code < 256; ++code) {
    const double edge = (code - 0.5) / 255;
    const auto linear =
        static_cast<float>(edge <= 0.04045 ? edge / 12.92 : std::pow((edge + 0.055) / 1.055, 2.4));
    float x = linear * (1 - 1e-5F);
    for (int step = 0; step < 200; ++step, x += linear * 1e-7F) {
      ASSERT_EQ(srgb8_from_linear(x), std::lround(srgb_from_linear(x) * 255.0F)) << x;
    }
  }
}

TEST(Colour, OutOfRangeIsClampedAndNanIsBlack) {
  EXPECT_EQ(srgb8_from_linear(-1), 0);
  EXPECT_EQ(srgb8_from_linear(7), 255);
  EXPECT_EQ(srgb8_from_linear(std::numeric_limits<float>::infinity()), 255);
  EXPECT_EQ(srgb8_from_linear(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(srgb8_from_linear(std::nextafter(1.0F, 0.0F)), 255);
}

TEST(Colour, LumaOfGreyIsTheGrey) {
  Image<Rgb8> image(2, 1, Rgb8{77, 77, 77});
  image(1, 0) = {255, 0, 0};
  const Image<float> y = luma(image);
  EXPECT_NEAR(y(0, 0), 77, 1e-4);
  EXPECT_NEAR(y(1, 0), 0.299 * 255, 1e-4);
}

TEST(Colour, ImagesConvertPixelByPixel) {
  const Image<Rgb8> image(3, 2, Rgb8{0, 128, 255});
  const Image<Rgbf> linear = linear_from_srgb8(image);
  EXPECT_EQ(linear.width(), 3);
  EXPECT_EQ(linear(2, 1), (Rgbf{0, linear_from_srgb8(std::uint8_t{128}), 1}));
  EXPECT_TRUE(linear_from_srgb8(Image<Rgb8>()).empty());
}

}  // namespace
}  // namespace cousin
