#include "perception/splats/swept_start.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sim/imaging/color.h"

namespace cousin {
namespace {

constexpr int kWidth = 160, kHeight = 120;
const SweepVolume kVolume{{-0.25, -0.2, -0.05}, {0.25, 0.2, 0.15}};

/// Spots a few pixels wide, without a period within the plane.
double light_at(double x_m, double y_m) {
  double sum = 0;
  for (int i = 1; i <= 6; ++i)
    sum += std::sin(90 * (x_m * std::cos(1.7 * i) + y_m * std::sin(1.7 * i)) + i * i);
  return 0.25 + 0.03 * sum;
}

/// The plane z = 0.03 from about half a metre, by automatic exposure.
/// @param lamp  its light in each channel
std::vector<SplatView> photographs(const std::array<double, 3>& lamp = {1, 1, 1}) {
  std::vector<SplatView> views;
  for (int i = 0; i < 8; ++i) {
    SplatView view;
    view.frame = i;
    const double turn = 0.785 * i;
    view.camera_from_world = look_at({0.15 * std::cos(turn), 0.15 * std::sin(turn), 0.5},
                                     {0, 0, 0.03}, Eigen::Vector3d::UnitY());
    SplatViewLevel& level = view.full;
    level.camera = {LensModel::pinhole, kWidth, kHeight, 180, 180, 79.5, 59.5};
    for (Image<float>& channel : level.color.channel) channel = Image<float>(kWidth, kHeight);
    const Lens lens(level.camera);
    const Pose world_from_camera = inverse(view.camera_from_world);
    const Eigen::Vector3d eye_m = world_from_camera.translation_m;
    const double gain = i % 2 == 0 ? 1.3 : 1 / 1.3;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Eigen::Vector3d ray = world_from_camera.rotation * *lens.unproject({x, y});
        const Eigen::Vector3d at_m = eye_m + ray * ((0.03 - eye_m.z()) / ray.z());
        const double light = gain * light_at(at_m.x(), at_m.y());
        for (std::size_t c = 0; c < 3; ++c)
          level.color.channel[c](x, y) = srgb_from_linear(static_cast<float>(lamp[c] * light));
      }
    }
    views.push_back(view);
  }
  return views;
}

TEST(SweptStart, PointsLieOnTheSurfaceAndExposuresAreTheViews) {
  const SweptStart start = swept_start(photographs(), kVolume, {.most_points = 400});
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
    EXPECT_NEAR(start.exposures.log_gain[v], (v % 2 == 0 ? 1 : -1) * std::log(1.3), 0.02) << v;
}

// Red and blue lamps, as over trays: luma is nearly black.
TEST(SweptStart, SurfacesAreFoundUnderLampsWithoutGreen) {
  const SweptStart start = swept_start(photographs({0.05, 0, 0.3}), kVolume,
                                       {.exposures = {.darkest = 0.02}, .most_points = 400});
  ASSERT_EQ(start.points.size(), 400u);
  int off = 0;
  for (const StartPoint& point : start.points)
    off += std::abs(point.position_m.z() - 0.03) > 0.005 ? 1 : 0;
  EXPECT_LT(off, 20);
  ASSERT_EQ(start.exposures.status, ExposureStatus::ok);
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_NEAR(start.exposures.log_gain[v], (v % 2 == 0 ? 1 : -1) * std::log(1.3), 0.03) << v;
}

TEST(SweptStart, NothingToSweepGivesNoPoints) {
  std::vector<SplatView> plain = photographs();
  for (SplatView& view : plain) {
    for (Image<float>& channel : view.full.color.channel)
      channel = Image<float>(kWidth, kHeight, 0.5F);
  }
  const SweptStart start = swept_start(plain, kVolume);
  EXPECT_TRUE(start.points.empty());
  EXPECT_NE(start.exposures.status, ExposureStatus::ok);
  EXPECT_TRUE(swept_start({}, kVolume).points.empty());
  EXPECT_THROW(swept_start(plain, kVolume, {.most_points = -1}), std::invalid_argument);
  EXPECT_THROW(swept_start(plain, kVolume, {.opacity = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
