#include "perception/splats/swept_start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/imaging/color.h"
#include "tests/perception/splats/exposed_plane.h"

namespace cousin {
namespace {

TEST(SweptStart, PointsLieOnTheSurfaceAndExposuresAreTheViews) {
  const SweptStart start = swept_start(exposed_plane(), kPlaneVolume, {.most_points = 400});
  ASSERT_EQ(start.points.size(), 400u);
  int off = 0;
  double color = 0;
  for (const StartPoint& point : start.points) {
    EXPECT_EQ(point.opacity, 0.5);
    off += std::abs(point.position_m.z() - 0.03) > 0.005 ? 1 : 0;
    const double light = linear_from_srgb8(point.color.r);
    color += std::abs(light - light_at(point.position_m.x(), point.position_m.y())) / 400;
  }
  EXPECT_LT(off, 20);
  EXPECT_LT(color, 0.05);  // of 0.25, at the mean exposure
  ASSERT_EQ(start.exposures.status, ExposureStatus::ok);
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_NEAR(start.exposures.log_gain[v], plane_log_gain(static_cast<int>(v)), 0.02) << v;
}

// Red and blue lamps, as over trays: luma is nearly black.
TEST(SweptStart, SurfacesAreFoundUnderLampsWithoutGreen) {
  const SweptStart start = swept_start(exposed_plane({0.05, 0, 0.3}), kPlaneVolume,
                                       {.exposures = {.darkest = 0.02}, .most_points = 400});
  ASSERT_EQ(start.points.size(), 400u);
  int off = 0;
  for (const StartPoint& point : start.points)
    off += std::abs(point.position_m.z() - 0.03) > 0.005 ? 1 : 0;
  EXPECT_LT(off, 20);
  ASSERT_EQ(start.exposures.status, ExposureStatus::ok);
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_NEAR(start.exposures.log_gain[v], plane_log_gain(static_cast<int>(v)), 0.03) << v;
}

TEST(SweptStart, NothingToSweepGivesNoPoints) {
  std::vector<SplatView> plain = exposed_plane();
  for (SplatView& view : plain) {
    for (Image<float>& channel : view.full.color.channel)
      channel = Image<float>(kPlaneWidth_px, kPlaneHeight_px, 0.5F);
  }
  const SweptStart start = swept_start(plain, kPlaneVolume);
  EXPECT_TRUE(start.points.empty());
  EXPECT_NE(start.exposures.status, ExposureStatus::ok);
  EXPECT_TRUE(swept_start({}, kPlaneVolume).points.empty());
  EXPECT_THROW(swept_start(plain, kPlaneVolume, {.most_points = -1}), std::invalid_argument);
  EXPECT_THROW(swept_start(plain, kPlaneVolume, {.opacity = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
