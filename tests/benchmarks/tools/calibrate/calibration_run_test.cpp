// benchmarks/tools/calibrate/calibration_run.h: photographs to cameras, and what is refused.
#include "benchmarks/tools/calibrate/calibration_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "benchmarks/tools/calibrate/calibration_output.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/color.h"
#include "sim/imaging/image_io.h"
#include "tests/calibration/boards/synthetic_target.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using synthetic::shoot_target;
using synthetic::tilted;
using testing::AllOf;
using testing::HasSubstr;

const CalibrationTarget kBoard{TargetKind::chessboard, 8, 6, 0.03, 0, ""};
const CalibrationTarget kHalfTurn{TargetKind::chessboard, 7, 5, 0.03, 0, ""};

Camera lens() {
  return {.model = LensModel::opencv5,
          .width_px = 400,
          .height_px = 300,
          .fx_px = 420,
          .fy_px = 421,
          .cx_px = 202,
          .cy_px = 147,
          .distortion = {-0.15, 0.05, 0, 0, 0}};
}

/// A photograph in 8 bits of sRGB with noise.
void photograph(const fs::path& file, const CalibrationTarget& target, const Camera& camera,
                const Pose& pose) {
  const auto shot = shoot_target(target, camera, pose, {.noise = 0.01, .samples = 8}, Rng(1));
  Image<Rgb8> color(camera.width_px, camera.height_px);
  for (std::size_t i = 0; i < color.size(); ++i) {
    const std::uint8_t v = srgb8_from_linear(shot.light.data()[i]);
    color.data()[i] = {v, v, v};
  }
  write_png(file, color);
}

Pose pose_of(int i) {
  const double axis = 2.4 * i;
  return tilted(0.36 + 0.02 * (i % 3), 0.15 + 0.08 * (i % 6), axis, 0.1 * (i % 3) - 0.1,
                {0.02 * std::cos(1.7 * i), 0.015 * std::sin(1.7 * i)});
}

std::string name_of(const char* what, int i) {
  return std::string(what) + (i < 10 ? "0" : "") + std::to_string(i) + ".png";
}

CalibrateConfig lean() {
  CalibrateConfig config;
  config.calibration.fixed = {"k3", "p1", "p2"};
#ifdef COUSIN_NO_CERES
  config.calibration.solver = CalibrationSolver::opencv;
  config.calibration.weigh_by_covariance = false;
#endif
  return config;
}

CalibrationRun run_folder(const fs::path& folder, const CalibrationTarget& target,
                          const CalibrateConfig& config = lean()) {
  return run_calibration(photos_of_folder(folder, target), config, {});
}

TEST(RunCalibration, GivesTheLensBackWithinItsDeviations) {
  const TemporaryFolder folder;
  for (int i = 0; i < 10; ++i)
    photograph(folder.path() / name_of("view", i), kBoard, lens(), pose_of(i));
  const CalibrationRun run = run_folder(folder.path(), kBoard);
  ASSERT_TRUE(run.problems.empty()) << run.problems.front();
  const Camera& found = run.result.cameras.front();
  // Four deviations, which corner noise of 1 % and 350 corners make a fraction of a pixel.
  const auto within = [&](double value, double truth, const char* name) {
    const double sigma = deviation(run.result, std::string("camera0.") + name);
    EXPECT_LT(sigma, 1) << name;
    EXPECT_NEAR(value, truth, 4 * sigma) << name;
  };
  within(found.fx_px, 420, "fx_px");
  within(found.fy_px, 421, "fy_px");
  within(found.cx_px, 202, "cx_px");
  within(found.cy_px, 147, "cy_px");
  ASSERT_EQ(run.verdicts.size(), 1U);
  EXPECT_LT(run.verdicts[0].rms_px, 0.05);
  EXPECT_GT(run.verdicts[0].coverage, 0.4);
  ASSERT_TRUE(run.verdicts[0].next);
  const NextView next = *run.verdicts[0].next;
  EXPECT_LT(next.then_px, 0.97 * next.now_px);
  // The view that is asked for, taken, gives what was promised; to first order, and with corners
  // that are not all alike.
  photograph(folder.path() / "view99.png", kBoard, lens(), next.camera_from_target);
  const CalibrationRun better = run_folder(folder.path(), kBoard);
  ASSERT_TRUE(better.verdicts.at(0).next);
  EXPECT_NEAR(better.verdicts[0].next->now_px, next.then_px, 0.3 * next.then_px);
  EXPECT_LT(better.verdicts[0].next->now_px, next.now_px);

  // What is written reads back.
  const TemporaryFolder out;
  const auto json = nlohmann::json::parse(calibration_json(run));
  EXPECT_EQ(json["cameras"][0]["parameters"]["fx_px"]["value"].get<double>(), found.fx_px);
  EXPECT_GT(json["cameras"][0]["parameters"]["fx_px"]["deviation"].get<double>(), 0);
  EXPECT_EQ(json["images"].size(), 10U);
  (void)write_calibration_files(out.path(), run);
  for (const char* file : {"opencv/camera.yaml", "ros/camera.yaml", "kalibr/camchain.yaml",
                           "mrcal/camera.cameramodel", "colmap/cameras.txt"})
    EXPECT_TRUE(fs::exists(out.path() / file)) << file;
  write_calibration_report(out.path() / "report.html", run, {}, "cousin calibrate x");
  EXPECT_THAT(read_file(out.path() / "report.html"),
              AllOf(HasSubstr("coverage"), HasSubstr("residuals"), HasSubstr("uncertainty")));
}

TEST(RunCalibration, TurnsAStereoHeadsBoardsToAgree) {
  const TemporaryFolder folder;
  const Pose right_from_left{Eigen::Quaterniond::Identity(), {-0.06, 0, 0}};
  for (int i = 0; i < 8; ++i) {
    // A quarter turn: the end that is up may be another one in the other camera.
    Pose pose = pose_of(i);
    pose.rotation =
        Eigen::AngleAxisd(i % 2 == 0 ? 1.57 : 0.1, Eigen::Vector3d::UnitZ()) * pose.rotation;
    pose.translation_m += Eigen::Vector3d(0.03, 0, 0.12);
    photograph(folder.path() / name_of("left", i), kHalfTurn, lens(), pose);
    Pose tilted_right = right_from_left;
    tilted_right.rotation = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ());
    photograph(folder.path() / name_of("right", i), kHalfTurn, lens(), tilted_right * pose);
  }
  CalibrateConfig by_opencv = lean();
  by_opencv.calibration.solver = CalibrationSolver::opencv;
  by_opencv.calibration.weigh_by_covariance = false;
  for (const CalibrateConfig& config : {lean(), by_opencv}) {
    const CalibrationRun run = run_folder(folder.path(), kHalfTurn, config);
    ASSERT_TRUE(run.problems.empty()) << run.problems.front();
    // Baseline over its deviation; a board turned by half a turn would leave tens of pixels.
    EXPECT_LT(run.result.rms_px, 0.06);
    EXPECT_NEAR(run.result.camera_from_rig[1].translation_m.norm(), 0.06, 0.0002);
  }
}

TEST(RunCalibration, ParallelBoardsAreRefusedOrWarnedOf) {
  const TemporaryFolder folder;
  for (int i = 0; i < 6; ++i)
    photograph(folder.path() / name_of("view", i), kBoard, lens(),
               tilted(0.4 + 0.02 * i, 0.02, 0.5 * i, 0));
  const CalibrationRun run = run_folder(folder.path(), kBoard);
  EXPECT_FALSE(run.problems.empty() && run.warnings.empty());
  const std::string table = calibration_table(run);
  EXPECT_THAT(table, HasSubstr("parallel"));
  const TemporaryFolder out;
  if (!run.problems.empty()) {
    EXPECT_TRUE(write_calibration_files(out.path(), run).empty());
    EXPECT_FALSE(fs::exists(out.path() / "opencv"));
  }
}

TEST(RunCalibration, NamesWhatIsWrongWithItsImages) {
  const auto message = [](const fs::path& folder, const CalibrationTarget& target) {
    try {
      (void)run_folder(folder, target);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  {
    const TemporaryFolder folder;
    photograph(folder.path() / "a.png", kBoard, lens(), pose_of(0));
    photograph(folder.path() / "b.png", kBoard, resized(lens(), 320, 240), pose_of(1));
    EXPECT_THAT(message(folder.path(), kBoard),
                AllOf(HasSubstr("b.png: 320 x 240 pixels; a.png has 400 x 300")));
  }
  {
    const TemporaryFolder folder;
    write_png(folder.path() / "grey.png", Image<std::uint8_t>(320, 240, 90));
    EXPECT_THAT(message(folder.path(), kBoard),
                AllOf(HasSubstr("no board found in any of 1 images"), HasSubstr("grey.png")));
  }
  {
    const TemporaryFolder folder;
    photograph(folder.path() / "a.png", kBoard, lens(), pose_of(0));
    EXPECT_THAT(message(folder.path(), {TargetKind::chessboard, 6, 5, 0.03, 0, ""}),
                AllOf(HasSubstr("a.png"), HasSubstr("board of the wrong size"),
                      HasSubstr("7 x 5 inner corners are seen; the board has 5 x 4")));
  }
  {
    const TemporaryFolder folder;
    photograph(folder.path() / "a.png", kBoard, lens(), pose_of(0));
    write_file(folder.path() / "b.png", "not a picture");
    EXPECT_THAT(message(folder.path(), kBoard), HasSubstr("b.png"));
  }
}

}  // namespace
}  // namespace cousin
