#include "perception/segment/green.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace cousin {
namespace {

/// Every colour with this red.
Image<Rgb8> plane_of_red(int red) {
  Image<Rgb8> image(256, 256);
  for (int g = 0; g < 256; ++g) {
    for (int b = 0; b < 256; ++b) {
      image(b, g) = {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(g),
                     static_cast<std::uint8_t>(b)};
    }
  }
  return image;
}

TEST(Green, HsvOfEveryColorEqualsOpenCvs) {
  std::size_t different = 0;
  for (int red = 0; red < 256; ++red) {
    Image<Rgb8> image = plane_of_red(red);
    const cv::Mat rgb(256, 256, CV_8UC3, image.data());
    cv::Mat hsv;
    cv::cvtColor(rgb, hsv, cv::COLOR_RGB2HSV);
    for (int y = 0; y < 256; ++y) {
      for (int x = 0; x < 256; ++x) {
        const auto& v = hsv.at<cv::Vec3b>(y, x);
        different += hsv8(image(x, y)) == Hsv8{v[0], v[1], v[2]} ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(different, 0U);
}

TEST(Green, MaskIsTheComplementOfInRange) {
  Image<Rgb8> image = plane_of_red(60);
  const cv::Mat rgb(256, 256, CV_8UC3, image.data());
  cv::Mat hsv, green;
  cv::cvtColor(rgb, hsv, cv::COLOR_RGB2HSV);
  cv::inRange(hsv, cv::Scalar(35, 25, 25), cv::Scalar(77, 255, 255), green);
  const Image<std::uint8_t> kept = remove_green(image);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) ASSERT_EQ(kept(x, y), 255 - green.at<std::uint8_t>(y, x));
  }
}

TEST(Green, SpecksAreFilledAndTheScreenStaysAsItIs) {
  // A screen on the left and a strip of two pixels, a speck, and a 3 x 3 square with one pixel out.
  Image<std::uint8_t> kept(20, 12, 255);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 5; ++x) kept(x, y) = 0;
    for (int x = 8; x < 10; ++x) kept(x, y) = 0;
  }
  kept(13, 2) = 0;
  for (int y = 6; y < 9; ++y) {
    for (int x = 14; x < 17; ++x) kept(x, y) = 0;
  }
  Image<std::uint8_t> expected(20, 12, 255);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 5; ++x) expected(x, y) = 0;
  }
  for (int y = 6; y < 9; ++y) {
    for (int x = 14; x < 17; ++x) expected(x, y) = 0;
  }
  EXPECT_EQ(without_specks(kept), expected);
  kept(15, 7) = 255;  // no square is whole now
  const Image<std::uint8_t> filled = without_specks(kept);
  EXPECT_EQ(filled(14, 6), 255);
  EXPECT_EQ(filled(0, 0), 0) << "beyond the border all is green";
  EXPECT_TRUE(without_specks({}).empty());
}

TEST(Green, EmptyImageGivesAnEmptyMask) { EXPECT_TRUE(remove_green({}).empty()); }

TEST(Green, LimitOutsideEightBitsIsNamed) {
  GreenConfig config;
  config.hue_high = 300;
  try {
    remove_green(Image<Rgb8>(1, 1), config);
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("hue_high = 300"));
  }
}

}  // namespace
}  // namespace cousin
