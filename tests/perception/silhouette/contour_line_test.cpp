#include "perception/silhouette/contour_line.h"

#include <gtest/gtest.h>

namespace cousin {
namespace {

Image<std::uint8_t> disc(double radius_px, double x0, double y0) {
  Image<std::uint8_t> mask(64, 48, 0);
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if ((Eigen::Vector2d(x, y) - Eigen::Vector2d(x0, y0)).norm() < radius_px) mask(x, y) = 255;
    }
  }
  return mask;
}

TEST(ContourLine, DiscGivesItsCircle) {
  const Eigen::Vector2d centre(30.3, 22.6);
  const auto contour = smooth_contour(trace_mask(disc(14, centre.x(), centre.y())), 1.5);
  ASSERT_NEAR(static_cast<double>(contour.size()), 2 * 3.1416 * 14, 3);
  double radius = 0, curvature = 0;
  for (const ContourVertex& vertex : contour) {
    const Eigen::Vector2d from_centre = vertex.pixel_px - centre;
    EXPECT_GT(vertex.normal.dot(from_centre.normalized()), 0.95);
    radius += from_centre.norm() / static_cast<double>(contour.size());
    curvature += vertex.curvature_per_px / static_cast<double>(contour.size());
  }
  // Smoothing by sigma moves a circle in by sigma^2 / (2 r): the mask's 0.7 px and 1.5 px along the
  // line, 0.1 px in all.
  EXPECT_NEAR(radius, 14 - 0.1, 0.1);
  EXPECT_NEAR(curvature, 1.0 / 14, 0.01);
}

TEST(ContourLine, LongestLineIsTaken) {
  Image<std::uint8_t> mask = disc(8, 20, 20);
  for (int y = 30; y < 34; ++y) {
    for (int x = 50; x < 54; ++x) mask(x, y) = 255;
  }
  for (const Eigen::Vector2d& point : trace_mask(mask))
    EXPECT_LT((point - Eigen::Vector2d(20, 20)).norm(), 9);
}

TEST(ContourLine, EmptyMaskHasNoLine) {
  EXPECT_TRUE(trace_mask(Image<std::uint8_t>(20, 20, 0)).empty());
  EXPECT_TRUE(smooth_contour({}, 1.5).empty());
}

}  // namespace
}  // namespace cousin
