// benchmarks/tools/calibrate on a depth camera's dataset: infrared pictures, the device's
// registration.
#include "benchmarks/tools/calibrate/device_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "benchmarks/tools/calibrate/calibration_output.h"
#include "benchmarks/tools/calibrate/device_output.h"
#include "sim/dataset/capture_io.h"
#include "sim/imaging/color.h"
#include "tests/calibration/boards/synthetic_target.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using synthetic::shoot_target;
using synthetic::tilted;
using testing::Contains;
using testing::HasSubstr;

const CalibrationTarget kBoard{TargetKind::chessboard, 8, 6, 0.03, 0, ""};

/// Colour, left and right imager, as they are.
std::vector<SensorReport> true_rig() {
  std::vector<SensorReport> rig(3);
  const char* names[] = {"rgb", "ir_left", "ir_right"};
  for (std::size_t i = 0; i < 3; ++i) {
    rig[i].name = names[i];
    rig[i].camera = {.model = LensModel::opencv5,
                     .width_px = 400,
                     .height_px = i == 0 ? 300 : 280,
                     .fx_px = i == 0 ? 420.0 : 330.0,
                     .fy_px = i == 0 ? 421.0 : 330.5,
                     .cx_px = 202,
                     .cy_px = i == 0 ? 147.0 : 141.0,
                     .distortion = {i == 0 ? -0.15 : -0.01, 0.03, 0, 0, 0}};
  }
  rig[1].sensor_from_rig.translation_m = {0.02, 0, 0};
  rig[1].sensor_from_rig.rotation = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX());
  rig[2].sensor_from_rig.translation_m = {-0.03, 0, 0};
  return rig;
}

/// What such a rig hands over of a board; it reports `reported` of itself.
Capture capture_of(const std::vector<SensorReport>& reported) {
  Capture capture;
  capture.board = to_text(kBoard);
  capture.rig = reported;
  const std::vector<SensorReport> rig = true_rig();
  for (int i = 0; i < 10; ++i) {
    const Pose pose =
        tilted(0.40 + 0.03 * (i % 3), 0.15 + 0.08 * (i % 6), 2.4 * i, 0.1 * (i % 3) - 0.1,
               {0.02 * std::cos(1.7 * i), 0.015 * std::sin(1.7 * i)});
    Frame frame;
    frame.id = i;
    frame.time_s = 0.5 * i;
    for (std::size_t s = 0; s < rig.size(); ++s) {
      const Camera& camera = rig[s].camera;
      const auto shot = shoot_target(kBoard, camera, rig[s].sensor_from_rig * pose,
                                     {.noise = 0.01, .samples = 8}, Rng(1).fork(s));
      SensorFrame picture;
      picture.reported = reported[s].camera;
      if (s == 0)
        picture.color = Image<Rgb8>(camera.width_px, camera.height_px);
      else
        picture.grey = Image<std::uint8_t>(camera.width_px, camera.height_px);
      for (std::size_t k = 0; k < shot.light.size(); ++k) {
        const float light = std::clamp(shot.light.data()[k], 0.0F, 1.0F);
        const std::uint8_t v = srgb8_from_linear(light);
        if (s == 0)
          picture.color.data()[k] = {v, v, v};
        else
          picture.grey.data()[k] = static_cast<std::uint8_t>(std::lround(255 * light));
      }
      frame.sensors.push_back(std::move(picture));
    }
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

CalibrationRun run_of(const std::vector<SensorReport>& reported) {
  const TemporaryFolder folder;
  write_capture(folder.path() / "000000", capture_of(reported));
  CalibrateConfig config;
  config.calibration.fixed = {"k3", "p1", "p2"};
  return run_calibration(photos_of_dataset(folder.path(), ""), config, {});
}

TEST(DeviceReport, AFactoryRegistrationThatIsOffIsWorthReplacing) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "three cameras need Ceres";
#endif
  std::vector<SensorReport> reported = true_rig();
  // 3 mrad of turn are 1.3 px in the colour picture.
  reported[1].sensor_from_rig.rotation =
      reported[1].sensor_from_rig.rotation *
      Eigen::Quaterniond(Eigen::AngleAxisd(0.003, Eigen::Vector3d::UnitY()));
  reported[0].shutter = Shutter::rolling;
  reported[0].readout_s = 0.0123;
  const CalibrationRun run = run_of(reported);
  ASSERT_TRUE(run.problems.empty()) << run.problems.front();
  EXPECT_EQ(run.photos.cameras, (std::vector<std::string>{"rgb", "ir_left", "ir_right"}));
  EXPECT_DOUBLE_EQ(run.input.views[3].time_s, 1.5);
  ASSERT_TRUE(run.registration);
  EXPECT_EQ(run.registration->verdict, RegistrationVerdict::replace);
  // At 0.6 m, over the image: f tan of 3 mrad, more at the sides.
  EXPECT_NEAR(run.registration->factory_rms_px, 1.3, 0.3);
  EXPECT_LT(run.registration->fresh_rms_px, 0.4);
  EXPECT_THAT(run.warnings, Contains(HasSubstr("12.3 ms")));
  const Pose found = run.result.camera_from_rig[1];
  const Pose truth = true_rig()[1].sensor_from_rig;
  EXPECT_LT(found.rotation.angularDistance(truth.rotation), 0.001);
  EXPECT_LT((found.translation_m - truth.translation_m).norm(), 0.0005);
  const auto json = nlohmann::json::parse(calibration_json(run));
  EXPECT_EQ(json["registration"]["verdict"], "replace");
  EXPECT_THAT(calibration_table(run), HasSubstr("worth replacing"));
  // Infrared pictures are linear: their corners are as good as the colour ones.
  EXPECT_LT(run.verdicts[1].rms_px, 0.06);
  EXPECT_FALSE(run.sample.empty());
}

TEST(DeviceReport, ATrueFactoryRegistrationIsNotReplaced) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "three cameras need Ceres";
#endif
  const CalibrationRun run = run_of(true_rig());
  ASSERT_TRUE(run.problems.empty()) << run.problems.front();
  ASSERT_TRUE(run.registration);
  EXPECT_NE(run.registration->verdict, RegistrationVerdict::replace);
  EXPECT_LT(run.registration->rms_px, 5 * run.registration->fresh_rms_px);
}

TEST(DeviceReport, AReadoutThatWasGivenHasNoDeviation) {
  CalibrationRun run;
  Camera camera;
  camera.height_px = 481;
  run.result.cameras = {camera};
  run.rolling.emplace();
  run.rolling->line_delay_s = 2e-5;
  EXPECT_THAT(device_table(run), HasSubstr("20 us a row, as given"));
  run.result.parameters = {"camera0.line_delay_s"};
  run.result.covariance = Eigen::MatrixXd::Constant(1, 1, 1e-14);
  EXPECT_THAT(device_table(run), HasSubstr("20 us a row +- 0.1,"));
}

}  // namespace
}  // namespace cousin
