#include "sim/sensors/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <string>

#include "tests/places/places.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Scene one_view(const Pose& begin, const Pose& end) {
  Scene scene;
  View view;
  view.time_s = 10;
  view.rig_from_world = begin;
  view.rig_from_world_end = end;
  scene.views = {view};
  return scene;
}

/// The ZED at rest, without errors of time.
RigConfig still_zed() {
  RigConfig rig = rig_preset("zed_hd720");
  rig.sync_error_s = rig.hand_speed_m_per_s = rig.hand_rate_rad_per_s = 0;
  return rig;
}

TEST(RigPreset, EveryNameLoadsAndMakesARig) {
  std::set<std::string> names;
  for (const std::string& name : rig_preset_names()) {
    EXPECT_TRUE(names.insert(name).second) << name << " is listed twice";
    const RigConfig config = rig_preset(name);
    const RigUnit unit = make_rig(config, Rng(1));
    const std::vector<SensorReport> reports = report_of(config, unit);
    ASSERT_EQ(reports.size(), config.sensors.size());
    EXPECT_EQ(reports[0].camera.width_px, config.sensors[0].camera.width_px);
    EXPECT_EQ(config.evidence, Evidence::verified);  // no device has been measured yet
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("redmi_k50", "iphone_12_pro", "dslr_apsc_24mp",
                                                   "zed_hd720", "zed_hd1080"));
}

TEST(RigPreset, EveryNumberSaysWhereItComesFrom) {
  for (const std::string& name : rig_preset_names()) {
    std::ifstream file(source_folder() / ("sim/sensors/presets/" + name + ".toml"));
    ASSERT_TRUE(file) << name;
    std::string comment;
    int numbers = 0;
    for (std::string line; std::getline(file, line);) {
      if (line.empty()) comment.clear();
      if (line.starts_with("#")) comment = line.find(": ") < 12 ? line : comment + line;
      const std::size_t equals = line.find(" = ");
      if (equals == std::string::npos || line.starts_with("#")) continue;
      if (line.starts_with("title") || line.starts_with("evidence")) continue;  // no numbers
      ++numbers;
      EXPECT_TRUE(comment.starts_with("# sourced: ") || comment.starts_with("# fitted: ") ||
                  comment.starts_with("# free: "))
          << name << ": " << line << " has no source";
    }
    EXPECT_GT(numbers, 50) << name;
  }
}

TEST(RigPreset, UnknownNameListsTheOnesThatExist) {
  try {
    rig_preset("zed_hd4k");
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("zed_hd4k"), HasSubstr("redmi_k50, iphone_12_pro")));
  }
}

TEST(RigPreset, TheZedIsItsFactoryFile) {
  const RigConfig rig = rig_preset("zed_hd720");
  ASSERT_EQ(rig.sensors.size(), 2U);
  const Camera left = nominal_camera(rig.sensors[0].camera);
  const Camera right = nominal_camera(rig.sensors[1].camera);
  // Nine digits in the file.
  EXPECT_NEAR(left.fx_px, 701.88, 1e-5);
  EXPECT_NEAR(left.fy_px, 701.7, 1e-5);
  EXPECT_NEAR(left.cx_px, 641.285, 1e-5);
  EXPECT_NEAR(left.cy_px, 344.1835, 1e-5);
  EXPECT_NEAR(right.fx_px, 700.965, 1e-5);
  EXPECT_NEAR(right.fy_px, 701.11, 1e-5);
  EXPECT_NEAR(right.cx_px, 633.515, 1e-5);
  EXPECT_NEAR(right.cy_px, 359.3135, 1e-5);
  EXPECT_EQ(right.distortion[0], -0.172795);
  // Everything else is shared.
  EXPECT_EQ(rig.sensors[0].camera.photosites.full_well_e,
            rig.sensors[1].camera.photosites.full_well_e);
  const Pose left_from_right =
      sensor_from_rig(rig.sensors[0]) * inverse(sensor_from_rig(rig.sensors[1]));
  EXPECT_NEAR(left_from_right.translation_m.x(), 0.119978, 1e-12);
  // Both eyes look towards each other's side: the right axis has a component to the left.
  EXPECT_NEAR((left_from_right.rotation * Eigen::Vector3d::UnitZ()).x(), -0.00623976, 1e-6);
}

TEST(RigToml, ErrorsNameFileKeyAndLimit) {
  std::ifstream file(source_folder() / "sim/sensors/presets/zed_hd720.toml");
  const std::string good((std::istreambuf_iterator<char>(file)), {});
  const auto error = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    try {
      rig_from_toml(text, "my.toml");
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(error("prnu = 0.005", "prnu = 0.006"), "accepted");
  EXPECT_THAT(error("prnu = 0.005", "prnu = 0.5"),
              AllOf(HasSubstr("my.toml:"), HasSubstr("camera.photosites.prnu = 0.5")));
  EXPECT_THAT(error("prnu = 0.005\n", ""), HasSubstr("missing keys: camera.photosites.prnu"));
  EXPECT_THAT(error("prnu = 0.005", "pnru = 0.005"),
              HasSubstr("unknown key 'camera.photosites.pnru"));
  EXPECT_THAT(error("[rgb_right.lens]", "[rgb_right.lens]\nk9 = 1"),
              HasSubstr("unknown key 'rgb_right.lens.k9"));
  EXPECT_THAT(error("[0.119978, 2.59812e-05, 1.58877e-05]", "[0.119978, 0]"),
              HasSubstr("rgb_right.centre_in_rig_m has 2 numbers, not 3"));
  EXPECT_THAT(error("[rgb_right]\n", "[rgb_right]\nwidth_px = 8\n"),
              HasSubstr("rgb_right.width_px = 8"));
  EXPECT_THAT(error("evidence = \"verified\"", "evidence = \"believed\""),
              HasSubstr("not one of verified, cross-checked, validated"));
  EXPECT_THAT(error("[rgb]", "[Rgb]"), HasSubstr("a-z 0-9 _"));
  std::string many = good;
  for (int i = 0; i < 20; ++i) many += "\n[extra" + std::to_string(i) + "]\n";
  EXPECT_THROW(rig_from_toml(many, "my.toml"), std::runtime_error);
  EXPECT_THROW(rig_from_toml("", "my.toml"), std::runtime_error);
}

TEST(RigViews, EyesOfARigAtRestStandWhereTheyAreMounted) {
  const RigConfig rig = still_zed();
  const RigUnit unit = make_rig(rig, Rng(1));
  const Pose pose = look_at({0.3, -0.2, 1.0}, {0, 0, 0});
  const std::vector<TrueView> views = true_views(rig, unit, one_view(pose, pose), 0, Rng(2));
  ASSERT_EQ(views.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const Pose expected = sensor_from_rig(rig.sensors[i]) * pose;
    EXPECT_LT((views[i].camera_from_world.translation_m - expected.translation_m).norm(), 1e-15);
    EXPECT_LT((views[i].camera_from_world_end.translation_m - expected.translation_m).norm(),
              1e-12);
    EXPECT_EQ(views[i].time_s, 10);
    EXPECT_EQ(views[i].exposure_s, 0.01);
    EXPECT_EQ(views[i].readout_s, 0.014);
    EXPECT_EQ(views[i].focus_m, 0.56);
    EXPECT_NEAR(views[i].aperture_radius_m, 0.0028 / 4, 1e-15);
  }
}

TEST(RigViews, AutofocusFindsTheViewsFocus) {
  const RigConfig rig = rig_preset("redmi_k50");
  Scene scene = one_view(look_at({0.5, 0.1, 0.4}, {0.5, 0.1, 0}, {0, 1, 0}),
                         look_at({0.5, 0.1, 0.4}, {0.5, 0.1, 0}, {0, 1, 0}));
  const auto focus_m = [&] {
    return true_views(rig, make_rig(rig, Rng(1)), scene, 0, Rng(2)).front().focus_m;
  };
  // Its error is drawn within 2.5 sigmas of 1 %; the hand moves it by less than a millimetre.
  EXPECT_NEAR(focus_m(), std::hypot(0.5, 0.1, 0.4), 0.026 * 0.65);  // the origin
  scene.views[0].focus_in_world_m = {0.5, 0.1, 0};
  EXPECT_NEAR(focus_m(), 0.4, 0.026 * 0.4);
}

TEST(RigViews, ADelayedSensorIsWhereTheBodyHasMovedTo) {
  RigConfig rig = still_zed();
  rig.sensors[1].trigger_delay_s = 0.007;  // half of the readout
  const RigUnit unit = make_rig(rig, Rng(1));
  Pose begin = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  Pose end = begin;
  end.translation_m.x() += 0.02;
  const std::vector<TrueView> views = true_views(rig, unit, one_view(begin, end), 0, Rng(2));
  const auto body_x_m = [&](std::size_t i, const Pose& camera_from_world) {
    return (inverse(sensor_from_rig(rig.sensors[i])) * camera_from_world).translation_m.x() -
           begin.translation_m.x();
  };
  EXPECT_NEAR(body_x_m(0, views[0].camera_from_world), 0, 1e-12);
  EXPECT_NEAR(body_x_m(0, views[0].camera_from_world_end), 0.02, 1e-12);
  EXPECT_NEAR(body_x_m(1, views[1].camera_from_world), 0.01, 1e-12);
  EXPECT_NEAR(body_x_m(1, views[1].camera_from_world_end), 0.03, 1e-12);
  EXPECT_NEAR(views[1].time_s, 10.007, 1e-12);
}

TEST(RigViews, SynchronisationErrorsHaveTheirSigmaAndAreNewForEachFrame) {
  RigConfig rig = still_zed();
  rig.sync_error_s = 0.001;
  const RigUnit unit = make_rig(rig, Rng(1));
  const Pose pose = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  const Scene scene = one_view(pose, pose);
  double squares = 0;
  constexpr int kFrames = 2000;
  for (std::uint64_t frame = 0; frame < kFrames; ++frame) {
    const std::vector<TrueView> views = true_views(rig, unit, scene, 0, Rng(frame));
    squares += std::pow(views[0].time_s - views[1].time_s, 2);
  }
  // The difference of two: sqrt(2) of it; 2000 draws know it to 1.6 %, allow four.
  EXPECT_NEAR(std::sqrt(squares / kFrames), 0.001 * std::sqrt(2.0), 0.064 * 0.001 * std::sqrt(2.0));
}

TEST(RigViews, TheHandCarriesAllSensorsAsOneBody) {
  RigConfig rig = still_zed();
  rig.hand_speed_m_per_s = 0.5;
  rig.hand_rate_rad_per_s = 0.5;
  const RigUnit unit = make_rig(rig, Rng(1));
  const Pose pose = look_at({0.1, 0.2, 1}, {0, 0, 0});
  const std::vector<TrueView> views = true_views(rig, unit, one_view(pose, pose), 0, Rng(5));
  const auto body = [&](std::size_t i) {
    return inverse(sensor_from_rig(rig.sensors[i])) * views[i].camera_from_world_end;
  };
  EXPECT_LT((body(0).translation_m - body(1).translation_m).norm(), 1e-12);
  EXPECT_GT((body(0).translation_m - pose.translation_m).norm(), 1e-4);
  EXPECT_LT(angle_rad(body(0).rotation * body(1).rotation.conjugate()), 1e-7);
}

TEST(RigViews, RefusesAViewThatTheSceneDoesNotHave) {
  const RigConfig rig = still_zed();
  const RigUnit unit = make_rig(rig, Rng(1));
  const Pose pose = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  EXPECT_THROW(true_views(rig, unit, one_view(pose, pose), 1, Rng(1)), std::invalid_argument);
  EXPECT_THROW(true_views(rig, unit, one_view(pose, pose), -1, Rng(1)), std::invalid_argument);
}

TEST(Rig, EyesSeeTheSameLightWithNoiseOfTheirOwn) {
  RigConfig rig = still_zed();
  for (RigSensor& sensor : rig.sensors) {
    sensor.camera.width_px = 160;
    sensor.camera.height_px = 90;
  }
  const RigUnit unit = make_rig(rig, Rng(1));
  const Pose pose = look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  const std::vector<TrueView> views = true_views(rig, unit, one_view(pose, pose), 0, Rng(2));
  const Image<Rgbf> grey(160, 90, {0.3F, 0.3F, 0.3F});
  const std::vector<SensorFrame> frames = sense({grey, grey}, rig, unit, views, Rng(2));
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_NE(frames[0].color, frames[1].color);
  double difference = 0;
  for (std::size_t i = 0; i < frames[0].color.size(); ++i) {
    difference += double(frames[0].color.data()[i].g) - frames[1].color.data()[i].g;
  }
  // Codes near 200 with noise of two: means of 14 400 agree to 0.03; the centres of their
  // vignetting differ by 1 %, which a mean over the image knows to a code.
  EXPECT_NEAR(difference / 14400, 0, 1);
  EXPECT_EQ(sense({grey, grey}, rig, unit, views, Rng(2))[1].color, frames[1].color);
  EXPECT_THROW(sense({grey}, rig, unit, views, Rng(2)), std::invalid_argument);
}

TEST(Rig, RefusesSensorsThatCannotBeToldApart) {
  RigConfig rig = still_zed();
  rig.sensors[1].name = "rgb";
  EXPECT_THROW(make_rig(rig, Rng(1)), std::invalid_argument);
  rig.sensors[1].name = "../rgb";
  EXPECT_THROW(make_rig(rig, Rng(1)), std::invalid_argument);
  rig.sensors.clear();
  EXPECT_THROW(make_rig(rig, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
