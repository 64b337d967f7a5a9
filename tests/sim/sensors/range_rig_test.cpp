#include "sim/sensors/range_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "sim/dataset/atomic_file.h"
#include "sim/sensors/depth_presets.h"
#include "sim/sensors/rig_capture.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"
#include "tests/sim/sensors/depth_test_scenes.h"

namespace cousin {
namespace {

using testing::HasSubstr;

/// A plate before a wall, seen twice from poses a little apart.
Scene plates() {
  Scene scene;
  test::add_plate(scene, 1.2, -3, -3, 3, 3, test::infrared_grey(0.5F));
  test::add_plate(scene, 0.8, -0.1, -0.1, 0.1, 0.1, test::infrared_grey(0.6F));
  scene.lights.emplace_back(test::even_sky(0.02));
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

RangeRigConfig small_rig(const std::string& name) {
  RangeRigConfig config = range_rig_preset(name);
  std::visit(
      [](auto& depth) {
        depth.columns = 160;
        depth.rows = 120;
        depth.focal_px = 130;
      },
      config.depth);
  CameraSensorConfig& color = config.body.sensors.front().camera;
  color.width_px = 120;
  color.height_px = 90;
  return config;
}

Image<Rgbf> grey(const TrueView& view, const Rng&) {
  return {view.camera.width_px, view.camera.height_px, {0.3F, 0.3F, 0.3F}};
}
Image<Rgbf> no_light(const TrueView&, const Rng&) { throw std::logic_error("light was traced"); }

struct Rigged {
  Scene scene = plates();
  RayScene rays{scene};
  RigCapture rig;
  explicit Rigged(const DeviceConfig& device, const RigCaptureConfig& config = {})
      : rig(device, config, rays, scene, Rng(3)) {}
};

constexpr Streams kBoth{.color = true, .depth = true};

TEST(RangeRig, HandsOverColourAndDepthThatIsTrueWithinItsNoise) {
  for (const std::string& name : range_rig_preset_names()) {
    const Rigged kinect(small_rig(name));
    const RigFrame taken = kinect.rig.take(1, kBoth, grey);
    ASSERT_EQ(taken.frame.sensors.size(), 2U) << name;
    EXPECT_EQ(kinect.rig.reports()[0].name, "rgb");
    EXPECT_EQ(kinect.rig.reports()[1].name, "depth");
    EXPECT_EQ(taken.frame.sensors[0].color.width(), 120);
    const SensorFrame& depth = taken.frame.sensors[1];
    ASSERT_EQ(depth.depth.width(), 160);
    EXPECT_EQ(depth.depth_unit_m, 0.001);
    int good = 0, valid = 0;
    for (std::size_t i = 0; i < depth.depth.size(); ++i) {
      EXPECT_EQ(depth.depth.data()[i] != 0, taken.invalid_reason.data()[i] == 0) << name << i;
      if (depth.depth.data()[i] == 0) continue;
      ++valid;
      const double off_m = depth.depth.data()[i] * depth.depth_unit_m -
                           static_cast<double>(taken.noise_free_depth_m.data()[i]);
      // Time of flight: wiggling of 5 mm and noise of 2 mm; structured light: steps of
      // z^2 / (8 f b), 18 mm at 1.2 m and f b = 9.75 px m, half of it by rounding.
      good += std::abs(off_m) < 0.02 ? 1 : 0;
    }
    EXPECT_GT(valid, 0.7 * 160 * 120) << name;
    EXPECT_GT(good, 0.95 * valid) << name;  // the rest lies at the plate's edge
  }
}

TEST(RangeRig, DepthAloneTracesNoLightAndIsTheSame) {
  for (const std::string& name : range_rig_preset_names()) {
    const Rigged kinect(small_rig(name));
    const RigFrame both = kinect.rig.take(0, kBoth, grey);
    const RigFrame depth = kinect.rig.take(0, {.depth = true}, no_light);
    EXPECT_EQ(depth.frame.sensors[1].depth, both.frame.sensors[1].depth);
    EXPECT_TRUE(depth.frame.sensors[0].color.empty());
    const RigFrame color = kinect.rig.take(0, {.color = true}, grey);
    EXPECT_EQ(color.frame.sensors[0].color, both.frame.sensors[0].color);
    EXPECT_TRUE(color.noise_free_depth_m.empty());
    const Frame outline = kinect.rig.outline(0, kBoth);
    for (std::size_t s = 0; s < 2; ++s) {
      EXPECT_EQ(outline.sensors[s].reported, both.frame.sensors[s].reported);
      EXPECT_EQ(outline.sensors[s].depth.empty(), both.frame.sensors[s].depth.empty());
      EXPECT_EQ(outline.sensors[s].color.empty(), both.frame.sensors[s].color.empty());
    }
    EXPECT_TRUE(kinect.rig.disparity(0).state.empty());
    EXPECT_THROW(kinect.rig.take(0, {.infrared = true}, grey), std::invalid_argument);
  }
}

TEST(RangeRig, TheSameBytesOnOneTwoAndSevenThreads) {
  for (const std::string& name : range_rig_preset_names()) {
    const Rigged kinect(small_rig(name));
    const RigFrame expected = kinect.rig.take(1, kBoth, grey);
    for (const std::size_t threads : {1, 2, 7}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const Rigged again(small_rig(name));
      const RigFrame taken = again.rig.take(1, kBoth, grey);
      EXPECT_EQ(taken.frame.sensors[1].depth, expected.frame.sensors[1].depth) << threads;
      EXPECT_EQ(taken.frame.sensors[0].color, expected.frame.sensors[0].color) << threads;
      EXPECT_EQ(taken.invalid_reason, expected.invalid_reason) << threads;
      EXPECT_TRUE(same_bits(taken.noise_free_depth_m, expected.noise_free_depth_m)) << threads;
    }
  }
}

TEST(RangeRig, ReportsDifferFromTheTruthByTheConfiguredErrors) {
  RangeRigConfig config = small_rig("kinect_v2");
  config.focal_error = 0.01;
  config.color_rotation_error_rad = 0.02;
  const Scene scene = plates();
  const RayScene rays(scene);
  double focal = 0, turn_rad2 = 0;
  constexpr int kUnits = 200;
  for (std::uint64_t unit = 0; unit < kUnits; ++unit) {
    const RangeRigUnit made = make_range_rig(config, Rng(unit));
    focal += std::pow(depth_camera(made.truth).fx_px / made.depth_reported.fx_px - 1, 2);
    const Pose turn = made.color_from_rig * inverse(made.color_from_rig_reported);
    turn_rad2 += std::pow(angle_rad(turn.rotation), 2) / 3;
  }
  // 200 draws know a sigma to 5 %, allow four; truncation at 2.5 sigmas takes 4.5 % off.
  EXPECT_NEAR(std::sqrt(focal / kUnits), 0.01 * 0.955, 0.2 * 0.01);
  EXPECT_NEAR(std::sqrt(turn_rad2 / kUnits), 0.02 * 0.955, 0.2 * 0.02);
  // Where the colour camera truly is, a sensor's view says; a hand would have moved it since.
  config.body.hand_speed_m_per_s = config.body.hand_rate_rad_per_s = 0;
  const RigCapture rig(config, {}, rays, scene, Rng(1));
  const Pose color_from_depth = rig.views()[0].views[0].camera_from_world *
                                inverse(rig.views()[1].views[0].camera_from_world);
  EXPECT_NEAR(centre_in_world_m(color_from_depth).x(), 0.052, 1e-9);
}

TEST(RangeRig, TheFastModelOfStereoIsRefused) {
  RigCaptureConfig by_model;
  by_model.depth_by = DepthBy::model;
  try {
    const Rigged kinect(small_rig("kinect_v1"), by_model);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("the fast model is of stereo depth cameras"));
  }
}

TEST(RangeRig, APresetOfOnesOwnIsReadFromItsFileAndErrorsNameIt) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "mine.toml";
  const std::string text(structured_light_preset_texts().front().toml);
  std::string mine = text;
  mine.replace(mine.find("baseline_m = 0.075"), 18, "baseline_m = 0.081");
  write_file(file, mine);
  const auto device = std::get<RangeRigConfig>(device_preset(file.string()));
  EXPECT_EQ(std::get<StructuredLightConfig>(device.depth).baseline_m, 0.081);
  EXPECT_THROW(time_of_flight_preset(file.string()), std::invalid_argument);

  const auto refusal = [&](const std::string& what) {
    write_file(file, what);
    try {
      range_rig_preset(file.string());
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  mine.replace(mine.find("baseline_m = 0.081"), 18, "baseline_m = 99.01");
  EXPECT_THAT(refusal(mine),
              testing::AllOf(HasSubstr("mine.toml"), HasSubstr("baseline_m"), HasSubstr("99.01")));
  EXPECT_THAT(refusal("title = \"\"\n"), HasSubstr("there must be one table"));
  EXPECT_THROW(device_preset((folder.path() / "none.toml").string()), std::runtime_error);
}

}  // namespace
}  // namespace cousin
