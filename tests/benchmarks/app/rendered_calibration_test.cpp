// A depth camera and a phone's video as a user calibrates them: boards are rendered, found, solved,
// and what comes out is held against what was true.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/truth_io.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::HasSubstr;

json calibration_of(const Program& program, const std::string& out) {
  return json::parse(read_file(program.path(out + "/calibration.json")), nullptr, false);
}

/// A small D457, whose makers were up to 20 mrad off with the colour camera and 2 % with the
/// baseline.
Words small_d457() {
  return {"--set", "rig=d457",
          "--set", "rig.columns=424",
          "--set", "rig.color_columns=320",
          "--set", "rig.color_rows=240",
          "--set", "rig.color_focal_px=195",
          "--set", "rig.color_distortion=[-0.0557, 0.0603, -0.00098, -0.00085]",
          "--set", "rig.infrared_without_dots=true",
          "--set", "rig.color_rotation_error_rad=0.02",
          "--set", "rig.baseline_error=0.02",
          "--set", "render.pixel_samples=4",
          "--set", "render.max_bounces=0"};
}

/// The whole board in all three pictures, 0.45 to 0.9 m away.
Words boards_for_all(int views) {
  return {"--set", "board=chessboard_a2",    "--set",   "views=" + std::to_string(views),
          "--set", "coverage=0.7",           "--set",   "poses.fill_min=0.4",
          "--set", "poses.fill_max=0.7",     "--truth", "none",
          "--set", "poses.tilt_max_rad=0.7", "--seed",  "3"};
}

TEST(AppRenderedCalibration, ADepthCamerasRegistrationAndDepthAreWhatTheTruthSays) {
#ifdef COUSIN_NO_CERES
  GTEST_SKIP() << "three cameras need Ceres";
#endif
  const Program program;
  const Outcome rendered =
      program.run(Words{"render", "boards", "--out", "boards"} + small_d457() + boards_for_all(9));
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const Outcome run = program.run({"calibrate", "boards", "--fix", "k3", "--out", "out"});
  ASSERT_EQ(run.code, 0) << run.err << run.out;
  const json found = calibration_of(program, "out");
  const SceneTruth truth = read_truth(program.path("boards/000000"));
  ASSERT_EQ(found["cameras"].size(), 3U);
  int seen = 0;
  for (const auto& image : found["images"]) seen += image["points"] > 80;
  EXPECT_GE(seen, 22);  // of 27

  // Lenses and places, all within what the calibration says of itself.
  const Pose rgb_from_world = truth.views[0].camera_from_world;
  double squares = 0;
  int count = 0;
  const auto hold = [&](const json& parameter, double is, const std::string& name) {
    const double sigmas =
        (parameter["value"].get<double>() - is) / parameter["deviation"].get<double>();
    EXPECT_LT(std::abs(sigmas), 4) << name;
    squares += sigmas * sigmas;
    ++count;
  };
  for (std::size_t c = 0; c < 3; ++c) {
    const TrueView& view = c == 0 ? truth.views[0] : truth.other_sensors[c - 1].views[0];
    const json& parameters = found["cameras"][c]["parameters"];
    const std::string name = found["cameras"][c]["name"];
    hold(parameters["fx_px"], view.camera.fx_px, name + " fx");
    hold(parameters["cx_px"], view.camera.cx_px, name + " cx");
    if (c == 0) continue;
    const Pose from_rgb = view.camera_from_world * inverse(rgb_from_world);
    const Eigen::AngleAxisd turn(from_rgb.rotation);
    hold(parameters["t_x"], from_rgb.translation_m.x(), name + " x");
    hold(parameters["r_y"], turn.angle() * turn.axis().y(), name + " turn");
  }
  EXPECT_LT(squares / count, 3);

  // The registration is off by about f times the turn.
  const Pose depth_from_rgb =
      truth.other_sensors[0].views[0].camera_from_world * inverse(rgb_from_world);
  const double turn_px = angle_rad(depth_from_rgb.rotation) * truth.views[0].camera.fx_px;
  EXPECT_EQ(found["registration"]["verdict"], "replace");
  EXPECT_GT(found["registration"]["reported_rms_px"], 0.4 * turn_px);
  EXPECT_LT(found["registration"]["reported_rms_px"], 2 * turn_px);

  // Depth is off by what focal length, baseline and the right imager's turn make of it.
  const TrueView& left = truth.other_sensors[0].views[0];
  const TrueView& right = truth.other_sensors[1].views[0];
  const Pose right_from_left = right.camera_from_world * inverse(left.camera_from_world);
  const json& depth = found["depth"];
  const double at_m = depth["distance_m"];
  const Eigen::Vector3d in_right = right_from_left * Eigen::Vector3d(0, 0, at_m);
  const double disparity_px = -left.camera.fx_px * in_right.x() / in_right.z();
  const double off_m = 212 * 0.095 / disparity_px - at_m;
  const double sigma_m =
      std::hypot(depth["spread_m"].get<double>(), depth["fresh_m"].get<double>());
  // A matcher reads its disparity off to a few hundredths of a pixel by itself.
  const double matcher_m = 0.03 / disparity_px * at_m;
  EXPECT_NEAR(depth["mean_m"].get<double>(), off_m, 3 * sigma_m + matcher_m);
  EXPECT_LT(sigma_m, 0.002);
  EXPECT_GE(depth["views"], 7);
  ASSERT_GT(std::abs(off_m), 0.003);
  EXPECT_EQ(depth["verdict"], "correct");
  EXPECT_THAT(read_file(program.path("out/report.html")), HasSubstr("depth on the boards"));
}

TEST(AppRenderedCalibration, AVideoTellsThePhonesReadout) {
#ifdef COUSIN_NO_CERES
  const Words solver = {"--solver", "opencv"};
#else
  const Words solver = {};
#endif
  const Program program;
  const Outcome rendered = program.run({"render",  "boards",
                                        "--out",   "video",
                                        "--set",   "plan=video",
                                        "--set",   "board=chessboard_a4",
                                        "--set",   "views=40",
                                        "--set",   "video.rate_hz=30",
                                        "--set",   "video.pose_step_s=0.4",
                                        "--set",   "rig.hand_speed_m_per_s=0",
                                        "--set",   "rig.hand_rate_rad_per_s=0",
                                        "--set",   "poses.fill_min=0.45",
                                        "--set",   "rig.width_px=320",
                                        "--set",   "rig.height_px=180",
                                        "--set",   "rig.autofocus=false",
                                        "--set",   "rig.readout_s=0.018",
                                        "--set",   "render.pixel_samples=4",
                                        "--set",   "render.max_bounces=0",
                                        "--truth", "none"});
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const Words calibrate = Words{"calibrate", "video", "--fix", "k3"} + solver;
  const Outcome run =
      program.run(calibrate + Words{"--set", "rolling_shutter=true", "--out", "rolled"});
  ASSERT_EQ(run.code, 0) << run.err << run.out;
  const json rolled = calibration_of(program, "rolled");
  const double rows = 179;
  const double readout_s = rows * rolled["rolling_shutter"]["line_delay_s"].get<double>();
  const double sigma_s = rows * rolled["rolling_shutter"]["deviation_s"].get<double>();
  EXPECT_EQ(rolled["rolling_shutter"]["neighbouring_views"], 39);
  EXPECT_LT(sigma_s, 0.001);
  EXPECT_NEAR(readout_s, 0.018, 4 * sigma_s);
  EXPECT_EQ(rolled["rolling_shutter"]["reported_readout_s"], 0.018);
  const TrueView view = read_truth(program.path("video/000000")).views[0];
  const auto fx = [](const json& found) { return found["cameras"][0]["parameters"]["fx_px"]; };
  EXPECT_NEAR(fx(rolled)["value"].get<double>(), view.camera.fx_px,
              4 * fx(rolled)["deviation"].get<double>());

  // As if all rows were read at once, residuals are several times as large, and it is said why.
  (void)program.run(calibrate + Words{"--out", "still"});
  const json still = calibration_of(program, "still");
  EXPECT_GT(still["rms_px"], 1.5 * rolled["rms_px"].get<double>());
  EXPECT_THAT(still["warnings"], Contains(HasSubstr("18 ms")));

  // Without neighbours in time, motion and line delay cannot be told apart.
  const Outcome alone = program.run(calibrate + Words{"--set", "rolling_shutter=true", "--set",
                                                      "rolling.max_gap_s=0.01", "--out", "alone"});
  EXPECT_EQ(alone.code, 1);
  const json apart = calibration_of(program, "alone");
  EXPECT_EQ(apart["status"], "not_determined");
  EXPECT_TRUE(apart["rolling_shutter"]["line_delay_s"].is_null());
  EXPECT_THAT(apart["not_determined"], Contains("camera0.line_delay_s"));
}

}  // namespace
}  // namespace cousin
