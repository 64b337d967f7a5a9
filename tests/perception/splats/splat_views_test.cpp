#include "perception/splats/splat_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

namespace cousin {
namespace {

/// What the world shows along a ray, 0..1, linear in its tangents.
std::array<double, 3> scene(double u, double v) {
  return {0.5 + 0.4 * u, 0.5 + 0.4 * v, 0.5 + 0.2 * u - 0.2 * v};
}

Image<Rgb8> photograph(const Camera& camera) {
  Image<Rgb8> image(camera.width_px, camera.height_px);
  for (int y = 0; y < camera.height_px; ++y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const auto ray = unproject(camera, {x, y});
      if (!ray || ray->z() <= 0) continue;
      const auto color = scene(ray->x() / ray->z(), ray->y() / ray->z());
      const auto code = [](double c) { return static_cast<std::uint8_t>(std::lround(255 * c)); };
      image(x, y) = {code(color[0]), code(color[1]), code(color[2])};
    }
  }
  return image;
}

Camera pinhole(int width, int height) {
  return {.width_px = width,
          .height_px = height,
          .fx_px = 0.9 * width,
          .fy_px = 0.95 * width,
          .cx_px = 0.5 * width - 1.25,
          .cy_px = 0.5 * height + 2.5};
}

Camera barrel(int width, int height) {
  Camera camera = pinhole(width, height);
  camera.model = LensModel::opencv5;
  camera.distortion = {-0.2, 0.03, 0.001, -0.0005};
  return camera;
}

Capture capture_of(const std::vector<Camera>& cameras) {
  Capture capture;
  for (const Camera& camera : cameras) {
    Frame frame{.id = static_cast<int>(capture.frames.size()), .rig_from_world = Pose{}};
    frame.sensors.push_back({.reported = camera, .color = photograph(camera)});
    capture.frames.push_back(frame);
  }
  capture.rig.push_back({.camera = cameras.front()});
  return capture;
}

/// Largest difference from what each pixel's ray shows, over pixels that count fully.
double worst_difference(const SplatViewLevel& level) {
  double worst = 0;
  int counted = 0;
  for (int y = 0; y < level.camera.height_px; ++y) {
    for (int x = 0; x < level.camera.width_px; ++x) {
      if (!level.weight.empty() && level.weight(x, y) < 1) continue;
      ++counted;
      const auto expected = scene((x - level.camera.cx_px) / level.camera.fx_px,
                                  (y - level.camera.cy_px) / level.camera.fy_px);
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = static_cast<double>(level.color.channel[c](x, y));
        const double difference = std::abs(value - expected[c]);
        if (std::isnan(difference)) return kNaN;
        worst = std::max(worst, difference);
      }
    }
  }
  return 2 * counted > level.camera.width_px * level.camera.height_px ? worst : kNaN;
}

/// As they are, halved and halved twice.
std::vector<SplatViewLevel> sizes_of(const SplatView& view) {
  return {view.full, halved(view.full), halved(view.full, 2)};
}

// Codes are rounded to half of 1/255; float sums add 1e-6.
constexpr double kHalfCode = 0.5 / 255 + 1e-6;

TEST(SplatViews, EveryLevelShowsEachRayWhatTheWorldShowsIt) {
  const Capture capture = capture_of({pinhole(203, 151)});
  const std::vector<SplatView> views = splat_views(capture, reported_poses(capture));
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].full.camera, pinhole(203, 151));
  EXPECT_EQ(halved(views[0].full).camera.width_px, 101);
  EXPECT_EQ(halved(views[0].full, 2).camera.height_px, 37);
  for (const SplatViewLevel& level : sizes_of(views[0])) {
    EXPECT_LE(worst_difference(level), kHalfCode);
    EXPECT_TRUE(level.weight.empty());
    EXPECT_EQ(level.color.channel[2].width(), level.camera.width_px);
  }
}

TEST(SplatViews, ALensIsUndistorted) {
  const Capture capture = capture_of({barrel(240, 180)});
  const std::vector<SplatView> views = splat_views(capture, reported_poses(capture));
  for (const SplatViewLevel& level : sizes_of(views.at(0))) {
    EXPECT_EQ(level.camera.model, LensModel::pinhole);
    // Half a code in the photograph, a cubic's weights sum to at most 1.27 of it, half a code of
    // its own.
    EXPECT_LE(worst_difference(level), (0.5 * 1.27 * 1.27 + 0.5) / 255 + 1e-5);
  }
}

TEST(SplatViews, WhatThePhotographDoesNotShowHasNoWeight) {
  Camera cushion = barrel(240, 180);
  cushion.distortion[0] = 0.15;  // corners of the pinhole image lie outside the photograph
  const Capture capture = capture_of({cushion});
  const SplatView view = splat_views(capture, reported_poses(capture)).at(0);
  const SplatViewLevel& full = view.full;
  ASSERT_FALSE(full.weight.empty());
  EXPECT_EQ(full.weight(0, 0), 0);
  EXPECT_EQ(full.color.channel[0](0, 0), 0);
  EXPECT_EQ(full.weight(120, 90), 1);
  const SplatViewLevel half = halved(full);
  // A half-size pixel has the mean of its four weights, and the colour of those that count.
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 120; ++x) {
      float sum = 0, color = 0;
      for (int k = 0; k < 4; ++k) {
        const float w = full.weight(2 * x + k % 2, 2 * y + k / 2);
        sum += w;
        color += w * full.color.channel[1](2 * x + k % 2, 2 * y + k / 2);
      }
      EXPECT_EQ(half.weight(x, y), sum / 4);
      EXPECT_FLOAT_EQ(half.color.channel[1](x, y), sum > 0 ? color / sum : 0);
    }
  }
}

TEST(SplatViews, WhatIsBehindTheSceneIsKeptAtEachSize) {
  for (const Camera& camera : {pinhole(96, 64), barrel(96, 64)}) {
    const Capture capture = capture_of({camera});
    Image<std::uint8_t> left(96, 64);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 41; ++x) left(x, y) = 255;
    }
    const SplatView view = splat_views(capture, reported_poses(capture), {}, {}, {left}).at(0);
    for (const SplatViewLevel& level : sizes_of(view)) {
      ASSERT_EQ(level.behind.width(), level.camera.width_px);
      const int y = level.behind.height() / 2;
      EXPECT_NEAR(level.behind(level.behind.width() / 4, y), 1, 1e-6);
      EXPECT_NEAR(level.behind(3 * level.behind.width() / 4, y), 0, 1e-6);
    }
    if (camera.model == LensModel::pinhole) {  // half of the pixel of half the size
      EXPECT_EQ(halved(view.full).behind(20, 10), 0.5F);
    }
    EXPECT_THROW(
        splat_views(capture, reported_poses(capture), {}, {}, {Image<std::uint8_t>(95, 64)}),
        std::invalid_argument);
    EXPECT_THROW(splat_views(capture, reported_poses(capture), {}, {}, {left, left}),
                 std::invalid_argument);
  }
}

TEST(SplatViews, AnyLargestSideKeepsWhereRaysGo) {
  for (const int side : {150, 97, 64}) {
    const Capture capture = capture_of({pinhole(203, 151), barrel(151, 203)});
    const std::vector<SplatView> views =
        splat_views(capture, reported_poses(capture), {}, {.largest_side_px = side});
    for (const SplatView& view : views) {
      const Camera& camera = view.full.camera;
      EXPECT_EQ(std::max(camera.width_px, camera.height_px), side);
      for (const SplatViewLevel& level : sizes_of(view))
        EXPECT_LE(worst_difference(level), (0.5 * 1.27 * 1.27 + 0.5) / 255 + 1e-5);
    }
  }
}

TEST(SplatViews, MaskedPixelsHaveNoWeightInAnyLens) {
  const Capture capture = capture_of({pinhole(120, 90), barrel(120, 90)});
  std::vector<Image<std::uint8_t>> masks(2, Image<std::uint8_t>(120, 90, 1));
  for (Image<std::uint8_t>& mask : masks) {
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 60; ++x) mask(x, y) = 0;
    }
  }
  for (const SplatView& view : splat_views(capture, reported_poses(capture), masks)) {
    // The barrel moves the mask's edge, near the centre, by less than two pixels.
    for (int y = 0; y < 90; ++y) {
      EXPECT_EQ(view.full.weight(55, y), 0) << y;
      EXPECT_EQ(view.full.weight(64, y), 1) << y;
    }
  }
}

TEST(SplatViews, FramesWithoutPoseOrPictureGiveNoView) {
  Capture capture = capture_of({pinhole(60, 50), pinhole(60, 50), pinhole(60, 50)});
  capture.frames[0].rig_from_world.reset();
  capture.frames[1].sensors[0].color = {};
  const std::vector<SplatView> views = splat_views(capture, reported_poses(capture));
  ASSERT_EQ(views.size(), 1u);
  EXPECT_EQ(views[0].frame, 2);
}

TEST(SplatViews, NoSideIsHalvedBelow16Pixels) {
  EXPECT_EQ(halvings_of(pinhole(64, 80), 2), 2);
  EXPECT_EQ(halvings_of(pinhole(80, 63), 2), 1);
  EXPECT_EQ(halvings_of(pinhole(31, 400), 2), 0);
  EXPECT_EQ(halvings_of(pinhole(400, 300), 1), 1);
  EXPECT_EQ(halvings_of(pinhole(400, 300), 0), 0);
  const Capture capture = capture_of({pinhole(60, 50)});
  const SplatViewLevel full = splat_views(capture, reported_poses(capture)).at(0).full;
  EXPECT_EQ(halved(full, 9).camera, halved(full).camera);  // an eighth of 60 x 50 is too small
  EXPECT_EQ(halved(full, 0).color.channel, full.color.channel);
}

TEST(SplatViews, TheSensorsPlaceOnTheRigIsInItsPose) {
  Capture capture = capture_of({pinhole(60, 50)});
  capture.rig[0].sensor_from_rig.translation_m = {0.1, 0.2, 0.3};
  capture.frames[0].rig_from_world = look_at({1, 2, 3}, {0, 0, 0});
  const Pose pose = splat_views(capture, reported_poses(capture)).at(0).camera_from_world;
  const Eigen::Vector3d in_rig = *capture.frames[0].rig_from_world * Eigen::Vector3d(5, 6, 7);
  EXPECT_LT((pose * Eigen::Vector3d(5, 6, 7) - in_rig - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(),
            1e-12);
}

TEST(SplatViews, AnyNumberOfThreadsGivesTheSameBytes) {
  const Capture capture =
      capture_of({barrel(80, 60), pinhole(80, 60), barrel(60, 80), pinhole(77, 61)});
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] { return splat_views(capture, reported_poses(capture)); });
  };
  const std::vector<SplatView> one = with_threads(1);
  const std::vector<SplatView> eight = with_threads(8);
  ASSERT_EQ(one.size(), eight.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].full.color.channel, eight[i].full.color.channel);
    EXPECT_EQ(one[i].full.weight, eight[i].full.weight);
  }
}

TEST(SplatViews, RefusesWhatDoesNotFitAndSaysWhat) {
  using ::testing::HasSubstr;
  const Capture capture = capture_of({pinhole(60, 50), pinhole(60, 50)});
  const Poses poses = reported_poses(capture);
  const auto message = [&](const Poses& p, const std::vector<Image<std::uint8_t>>& masks,
                           const SplatViewsConfig& config) -> std::string {
    try {
      splat_views(capture, p, masks, config);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(message(poses, {}, {}), "");
  EXPECT_THAT(message({}, {}, {}), HasSubstr("0 poses"));
  EXPECT_THAT(message(poses, {{}}, {}), HasSubstr("1 masks and 0 screens for 2 frames"));
  EXPECT_THAT(message(poses, {{}, Image<std::uint8_t>(50, 50)}, {}),
              HasSubstr("frame 1: the mask is 50 x 50, the image 60 x 50"));
  EXPECT_THAT(message(poses, {}, {.most_pixels = 5000}), HasSubstr("most_pixels is 5000"));
  EXPECT_THAT(message(poses, {}, {.largest_side_px = 5}), HasSubstr("largest_side_px = 5"));
  Poses small = poses;
  small[0].camera = pinhole(59, 50);
  EXPECT_THAT(message(small, {}, {}), HasSubstr("the image is 60 x 50, its camera 59 x 50"));
}

}  // namespace
}  // namespace cousin
