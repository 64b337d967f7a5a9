#include "calibration/plate_outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace cousin {
namespace {

constexpr double kPixelsPerSquare = 10;

/// 255 where a pixel is not green: neither red nor blue falls well short of green.
cv::Mat not_green(const Image<Rgb8>& color) {
  constexpr int kLead = 25;  // of 255, of green over the larger of red and blue
  cv::Mat mask(color.height(), color.width(), CV_8U);
  for (int y = 0; y < color.height(); ++y) {
    auto* row = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < color.width(); ++x) {
      const Rgb8 c = color(x, y);
      row[x] = c.g > std::max(c.r, c.b) + kLead ? 0 : 255;
    }
  }
  return mask;
}

/// The largest region's outline as four corners, clockwise in the image; empty if it has not four
/// sides.
std::vector<cv::Point2f> plate_quad(const cv::Mat& mask) {
  constexpr double kMinArea = 400;  // px^2
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto largest = std::max_element(
      outlines.begin(), outlines.end(),
      [](const auto& a, const auto& b) { return cv::contourArea(a) < cv::contourArea(b); });
  if (largest == outlines.end() || cv::contourArea(*largest) < kMinArea) return {};
  std::vector<cv::Point> hull, quad;
  cv::convexHull(*largest, hull, true);
  const double length = cv::arcLength(hull, true);
  for (double tolerance = 0.01; tolerance < 0.1; tolerance *= 1.25) {
    cv::approxPolyDP(hull, quad, tolerance * length, true);
    if (quad.size() <= 4) break;
  }
  if (quad.size() != 4) return {};
  return {quad.begin(), quad.end()};
}

}  // namespace

std::vector<LatticeCorner> lattice_of_upright_plate(const Image<Rgb8>& color,
                                                    const Image<float>& perceptual,
                                                    const SeedBoard& board, double smoothing_px,
                                                    double contrast) {
  std::vector<cv::Point2f> quad = plate_quad(not_green(color));
  if (quad.empty()) return {};
  // Clockwise on both sides, so that the warp does not mirror the print. The signed area says which
  // way round.
  double area = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2f a = quad[i], b = quad[(i + 1) % 4];
    area += a.x * b.y - a.y * b.x;
  }
  if (area < 0) std::reverse(quad.begin(), quad.end());
  const int side = static_cast<int>(std::lround(kPixelsPerSquare * board.plate_m / board.square_m));
  const float low = -0.5F, high = static_cast<float>(side) - 0.5F;
  const std::vector<cv::Point2f> upright = {{low, low}, {high, low}, {high, high}, {low, high}};
  const cv::Mat upright_from_image = cv::getPerspectiveTransform(quad, upright);
  Image<float> warped(side, side);
  cv::Mat to(side, side, CV_32F, warped.data());
  cv::warpPerspective(cv::Mat(perceptual.height(), perceptual.width(), CV_32F,
                              const_cast<float*>(perceptual.data())),
                      to, upright_from_image, to.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  std::vector<LatticeCorner> lattice =
      grow_lattice(warped, find_saddles(warped, smoothing_px, contrast), board.squares - 1);
  const cv::Mat back = upright_from_image.inv();
  for (LatticeCorner& c : lattice) {
    std::vector<cv::Point2d> point = {{c.pixel_px.x(), c.pixel_px.y()}}, image;
    cv::perspectiveTransform(point, image, back);
    c.pixel_px = {image[0].x, image[0].y};
  }
  return lattice;
}

}  // namespace cousin
