#include "sim/sensors/rig_capture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/sensors/depth_test_scenes.h"

namespace cousin {
namespace {

using test::add_plate;
using test::even_sky;
using test::infrared_grey;
using testing::HasSubstr;

/// A printed plate before a printed wall, seen twice from poses a little apart.
Scene plates() {
  Scene scene;
  add_plate(scene, 1.2, -3, -3, 3, 3, infrared_grey(0.5F, 0.4F));
  add_plate(scene, 0.8, -0.1, -0.1, 0.1, 0.1, infrared_grey(0.6F, 0.4F));
  scene.lights.emplace_back(even_sky(0.02));
  for (int i = 0; i < 2; ++i) {
    View view;
    view.time_s = 0.5 * i;
    view.rig_from_world = test::rig_looking_along_x();
    view.rig_from_world.translation_m.x() += 0.01 * i;
    view.rig_from_world_end = view.rig_from_world;
    scene.views.push_back(view);
  }
  return scene;
}

ActiveStereoConfig small_d457() {
  ActiveStereoConfig config = active_stereo_preset("d457");
  config.columns = 424;
  config.color_columns = 160;
  config.color_rows = 120;
  config.color_focal_px = 100;
  return config;
}

RigConfig small_zed() {
  RigConfig rig = rig_preset("zed_hd720");
  for (RigSensor& sensor : rig.sensors) {
    sensor.camera.width_px = 160;
    sensor.camera.height_px = 90;
  }
  return rig;
}

/// Radiance that says through which view it was asked for.
Image<Rgbf> grey(const TrueView& view, const Rng&) {
  const auto shade = static_cast<float>(0.2 + 0.1 * view.time_s);
  return {view.camera.width_px, view.camera.height_px, {shade, shade, shade}};
}
Image<Rgbf> no_light(const TrueView&, const Rng&) { throw std::logic_error("light was traced"); }

constexpr Streams kAll{.color = true, .infrared = true, .depth = true};

struct Rigged {
  Scene scene = plates();
  RayScene rays{scene};
  RigCapture rig;
  explicit Rigged(const DeviceConfig& device, const RigCaptureConfig& config = {})
      : rig(device, config, rays, scene, Rng(3)) {}
};

TEST(RigCapture, ADepthCameraHandsOverColourBothInfraredImagesAndItsDepth) {
  const Rigged d457(small_d457());
  const RigFrame taken = d457.rig.take(1, kAll, grey);
  std::vector<std::string> names;
  for (const SensorReport& report : d457.rig.reports()) names.push_back(report.name);
  EXPECT_EQ(names, (std::vector<std::string>{"rgb", "ir_left", "ir_right", "depth"}));
  ASSERT_EQ(taken.frame.sensors.size(), 4U);
  EXPECT_EQ(taken.frame.sensors[0].color.width(), 160);
  for (const std::size_t s : {1, 2}) EXPECT_EQ(taken.frame.sensors[s].grey.width(), 424);
  const SensorFrame& depth = taken.frame.sensors[3];
  ASSERT_EQ(depth.depth.width(), 424);
  EXPECT_EQ(taken.invalid_reason.width(), 424);
  // Depth is the true one within the sensor's noise: 0.1 px at f B = 20 px m and 1.2 m is 7 mm, and
  // a unit's scale is off by 0.05 % in focal length and baseline and 0.01 px in disparity.
  int good = 0, valid = 0;
  for (std::size_t i = 0; i < depth.depth.size(); ++i) {
    EXPECT_EQ(depth.depth.data()[i] != 0, taken.invalid_reason.data()[i] == 0) << i;
    if (depth.depth.data()[i] == 0) continue;
    ++valid;
    const double off_m = depth.depth.data()[i] * depth.depth_unit_m -
                         static_cast<double>(taken.noise_free_depth_m.data()[i]);
    good += std::abs(off_m) < 3 * 0.007 ? 1 : 0;
  }
  EXPECT_GT(valid, 0.7 * 424 * 240);
  EXPECT_GT(good, 0.97 * valid);  // the rest lies at the plate's edge
}

TEST(RigCapture, WhatIsNotAskedForIsNotRenderedAndChangesNothingElse) {
  const Rigged d457(small_d457());
  const RigFrame all = d457.rig.take(0, kAll, grey);
  const RigFrame depth = d457.rig.take(0, {.depth = true}, no_light);
  EXPECT_EQ(depth.frame.sensors[3].depth, all.frame.sensors[3].depth);
  EXPECT_TRUE(depth.frame.sensors[0].color.empty() && depth.frame.sensors[1].grey.empty());
  const RigFrame infrared = d457.rig.take(0, {.infrared = true}, no_light);
  EXPECT_EQ(infrared.frame.sensors[2].grey, all.frame.sensors[2].grey);
  EXPECT_TRUE(infrared.frame.sensors[3].depth.empty());
  EXPECT_TRUE(infrared.noise_free_depth_m.empty());
  const RigFrame color = d457.rig.take(0, {.color = true}, grey);
  EXPECT_EQ(color.frame.sensors[0].color, all.frame.sensors[0].color);
  EXPECT_TRUE(color.frame.sensors[1].grey.empty() && color.frame.sensors[3].depth.empty());
}

TEST(RigCapture, AnOutlineHasAPixelWhereTheFrameHasAnImage) {
  const Rigged d457(small_d457());
  for (const Streams& streams : {kAll, Streams{.color = true}, Streams{.depth = true}}) {
    const Frame taken = d457.rig.take(0, streams, grey).frame;
    const Frame outline = d457.rig.outline(0, streams);
    for (std::size_t s = 0; s < 4; ++s) {
      const SensorFrame &a = taken.sensors[s], &b = outline.sensors[s];
      EXPECT_EQ(a.color.empty(), b.color.empty());
      EXPECT_EQ(a.grey.empty(), b.grey.empty());
      EXPECT_EQ(a.depth.empty(), b.depth.empty());
      EXPECT_EQ(a.reported, b.reported);
      EXPECT_EQ(a.time_s, b.time_s);
    }
  }
}

TEST(RigCapture, TheSameBytesOnOneTwoAndSevenThreadsInAnyOrder) {
  const Rigged d457(small_d457());
  const RigFrame expected = d457.rig.take(1, kAll, grey);
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Rigged again(small_d457());
    const RigFrame taken = again.rig.take(1, kAll, grey);
    EXPECT_EQ(taken.frame.sensors[3].depth, expected.frame.sensors[3].depth) << threads;
    EXPECT_EQ(taken.frame.sensors[1].grey, expected.frame.sensors[1].grey) << threads;
    EXPECT_EQ(taken.frame.sensors[0].color, expected.frame.sensors[0].color) << threads;
    EXPECT_EQ(taken.invalid_reason, expected.invalid_reason) << threads;
    EXPECT_TRUE(same_bits(taken.noise_free_depth_m, expected.noise_free_depth_m)) << threads;
  }
}

TEST(RigCapture, TheModelsDepthIsOfTheSameSurfacesAndReadsNoInfrared) {
  RigCaptureConfig by_model;
  by_model.depth_by = DepthBy::model;
  const Rigged full(small_d457()), fast(small_d457(), by_model);
  const RigFrame matched = full.rig.take(0, {.depth = true}, no_light);
  const RigFrame modelled = fast.rig.take(0, {.depth = true}, no_light);
  EXPECT_NE(matched.frame.sensors[3].depth, modelled.frame.sensors[3].depth);
  EXPECT_TRUE(same_bits(matched.noise_free_depth_m, modelled.noise_free_depth_m));
  // Infrared images do not depend on where depth comes from.
  EXPECT_EQ(fast.rig.take(0, {.infrared = true, .depth = true}, no_light).frame.sensors[1].grey,
            full.rig.take(0, {.infrared = true}, no_light).frame.sensors[1].grey);
  try {
    const Rigged passive(active_stereo_preset("d405"), by_model);
    FAIL() << "the model knows nothing of a scene's texture";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("needs a projector"));
  }
}

TEST(RigCapture, InfraredWithoutDotsIsThatOfARigWithItsProjectorOff) {
  ActiveStereoConfig config = small_d457();
  const RigFrame dotted = Rigged(config).rig.take(0, kAll, grey);
  config.infrared_without_dots = true;
  const RigFrame plain = Rigged(config).rig.take(0, kAll, grey);
  config.has_projector = false;
  const RigFrame off = Rigged(config).rig.take(0, kAll, grey);
  // How much neighbours differ over the print's wall, off the plate.
  const auto roughness = [](const RigFrame& taken) {
    const Image<std::uint8_t>& image = taken.frame.sensors[1].grey;
    double differences = 0, level = 0;
    for (int y = 40; y < 80; ++y) {
      for (int x = 40; x < 120; ++x) {
        differences += std::abs(image(x + 1, y) - image(x, y));
        level += image(x, y);
      }
    }
    return differences / level;
  };
  EXPECT_GT(roughness(dotted), 2 * roughness(off));
  EXPECT_NEAR(roughness(plain), roughness(off), 0.2 * roughness(off));
  // Depth is matched with dots as before.
  EXPECT_EQ(plain.frame.sensors[3].depth, dotted.frame.sensors[3].depth);
  EXPECT_NE(off.frame.sensors[3].depth, dotted.frame.sensors[3].depth);
  // Of the images alone no depth is matched.
  const RigFrame alone = Rigged(config).rig.take(0, {.infrared = true}, no_light);
  EXPECT_TRUE(alone.frame.sensors[3].depth.empty());
}

TEST(RigCapture, ReportsDifferFromTheTruthByTheConfiguredErrors) {
  ActiveStereoConfig config = small_d457();
  config.focal_error = config.color_focal_error = 0.01;
  config.sync_error_s = 0.002;
  config.has_projector = false;  // its dots take longest to draw
  double focal = 0, start_s = 0;
  constexpr int kUnits = 200;
  const Scene scene = plates();
  const RayScene rays(scene);
  for (std::uint64_t unit = 0; unit < kUnits; ++unit) {
    const RigCapture rig(config, {}, rays, scene, Rng(unit));
    const Frame frame = rig.reported(1);
    const TrueView& left = rig.views()[1].views[1];
    focal += std::pow(left.camera.fx_px / frame.sensors[1].reported.fx_px - 1, 2);
    start_s += std::pow(rig.views()[0].views[1].time_s - *frame.sensors[0].time_s, 2);
    EXPECT_EQ(rig.views()[3].views[1].time_s, *frame.sensors[3].time_s);
    EXPECT_EQ(frame.time_s, 0.5);
  }
  // 200 draws know a sigma to 5 %, allow four; truncation at 2.5 sigmas takes 4.5 % off.
  EXPECT_NEAR(std::sqrt(focal / kUnits), 0.01 * 0.955, 0.2 * 0.01);
  EXPECT_NEAR(std::sqrt(start_s / kUnits), 0.002, 0.2 * 0.002);
}

TEST(RigCapture, AnArmReportsItsPosesWithTheirErrorAndAHandNone) {
  RigCaptureConfig arm;
  arm.knows_pose = true;
  arm.pose_error_m = 0.001;
  arm.pose_error_rad = 0.002;
  const Scene scene = plates();
  const RayScene rays(scene);
  ActiveStereoConfig device = small_d457();
  device.has_projector = false;
  double squares_m2 = 0, squares_rad2 = 0;
  constexpr int kUnits = 200;
  for (std::uint64_t unit = 0; unit < kUnits; ++unit) {
    const RigCapture rig(device, arm, rays, scene, Rng(unit));
    const Pose error = *rig.reported(1).rig_from_world * inverse(scene.views[1].rig_from_world);
    squares_rad2 += std::pow(angle_rad(error.rotation), 2) / 3;
    squares_m2 += error.translation_m.squaredNorm() / 3;
  }
  // 600 draws know a sigma to 3 %, allow four.
  EXPECT_NEAR(std::sqrt(squares_m2 / kUnits), 0.001, 0.12 * 0.001);
  EXPECT_NEAR(std::sqrt(squares_rad2 / kUnits), 0.002, 0.12 * 0.002);
  const RigCapture hand(small_zed(), {}, rays, scene, Rng(1));
  EXPECT_FALSE(hand.reported(1).rig_from_world);
}

TEST(RigCapture, TheZedsDisparityIsWhereTheOtherEyeSeesThePoint) {
  RigConfig config = small_zed();
  config.sync_error_s = config.hand_speed_m_per_s = config.hand_rate_rad_per_s = 0;
  const Rigged zed(config);
  const ViewMatch match = zed.rig.disparity(0);
  const TrueView &left = zed.rig.views()[0].views[0], &right = zed.rig.views()[1].views[0];
  const TruthImages truth = render_truth(zed.rays, zed.scene, left, {.depth = true});
  int seen = 0;
  for (int y = 2; y < 90; y += 7) {
    for (int x = 2; x < 160; x += 7) {
      if (match.state(x, y) != PointState::visible) continue;
      const auto ray = unproject(left.camera, Eigen::Vector2d(x, y));
      ASSERT_TRUE(ray);
      const Eigen::Vector3d point_m = *ray * (double(truth.depth_m(x, y)) / ray->z());
      const auto there = project(
          right.camera, right.camera_from_world * (inverse(left.camera_from_world) * point_m));
      ASSERT_TRUE(there);
      // Float depth: f * 6e-8 px; float flow of up to 20 px: 1e-6.
      EXPECT_NEAR(match.flow_px(x, y).x(), there->x() - x, 1e-4);
      EXPECT_NEAR(match.flow_px(x, y).y(), there->y() - y, 1e-4);
      ++seen;
    }
  }
  EXPECT_GT(seen, 100);
  EXPECT_TRUE(Rigged(small_d457()).rig.disparity(0).state.empty());
}

TEST(RigCapture, AStreamThatTheRigDoesNotHaveIsRefused) {
  const Rigged zed(small_zed());
  EXPECT_THROW(zed.rig.take(0, {.infrared = true}, grey), std::invalid_argument);
  EXPECT_THROW(zed.rig.take(0, {.depth = true}, grey), std::invalid_argument);
  EXPECT_THROW(zed.rig.take(0, {.raw = true}, grey), std::invalid_argument);
  const Frame both = zed.rig.take(0, {.color = true}, grey).frame;
  EXPECT_FALSE(both.sensors[0].color.empty() || both.sensors[1].color.empty());
}

TEST(RigCapture, AllFramesAreThoseTakenOneByOne) {
  const Rigged d457(small_d457());
  const RigRun run = take_all(d457.rig, {.depth = true}, {.invalid_reason = true}, no_light);
  ASSERT_EQ(run.frames.size(), 2U);
  const RigFrame second = d457.rig.take(1, {.depth = true}, no_light);
  EXPECT_EQ(run.frames[1].sensors[3].depth, second.frame.sensors[3].depth);
  EXPECT_EQ(run.truth[1].invalid_reason, second.invalid_reason);
  EXPECT_TRUE(run.truth[1].noise_free_depth_m.empty());
}

TEST(Device, EveryPresetIsFoundByItsNameAndStreamsHaveNames) {
  for (const std::string& name : device_preset_names()) {
    DeviceConfig config = device_preset(name);
    const Streams streams = streams_of(config);
    EXPECT_TRUE(streams.color) << name;
    EXPECT_EQ(streams_from_string("all", streams, name), streams);
    EXPECT_EQ(streams_from_string(to_string(streams), streams, name), streams);
    // Every number of a preset is a key, so that the resolved text makes the same device.
    const std::string text = to_toml(fields(config));
    DeviceConfig again = device_preset(name);
    read_toml_text(text, name, fields(again), MissingKeys::error);
    EXPECT_EQ(to_toml(fields(again)), text) << name;
  }
  EXPECT_THROW(device_preset("d999"), std::invalid_argument);
  const Streams phone{.color = true};
  try {
    streams_from_string("color,depth", phone, "phone_video_720p");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("rig phone_video_720p has no depth; it has color"));
  }
  EXPECT_THROW(streams_from_string("colour", phone, "p"), std::invalid_argument);
  EXPECT_THROW(streams_from_string("", phone, "p"), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
