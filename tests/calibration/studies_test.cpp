#include "benchmarks/calibration/studies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "benchmarks/calibration/board_photographs.h"
#include "benchmarks/calibration/calibration_errors.h"
#include "benchmarks/calibration/study_points.h"
#include "benchmarks/scenes/plant_run.h"
#include "calibration/target_detection.h"

namespace cousin {
namespace {

Camera d457() {
  Camera camera;
  camera.model = LensModel::opencv5;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 390;
  camera.cx_px = 320;
  camera.cy_px = 240;
  camera.distortion = {-0.055, 0.06, -0.001, -0.0009, -0.016};
  return camera;
}

TEST(CalibrationErrors, OfTheTrueLensAreNone) {
  const CalibrationErrors errors = calibration_errors(d457(), d457());
  EXPECT_LT(errors.projection_px, 1e-9);
  EXPECT_LT(errors.fruit_m, 1e-12);
  EXPECT_LT(errors.seed_m, 1e-12);
}

TEST(CalibrationErrors, AMovedPrincipalPointMovesFruitsButHardlyAnyProjection) {
  Camera moved = d457();
  moved.cx_px += 5;
  const CalibrationErrors errors = calibration_errors(d457(), moved);
  // 0.5 m * 5 / 390, and a few per cent more where the lens compresses.
  EXPECT_NEAR(errors.fruit_m, 0.00641, 0.0003);
  // A rotation takes up most of the 5 px.
  EXPECT_LT(errors.projection_px, 2);
  EXPECT_GT(errors.projection_worst_px, errors.projection_px);
}

TEST(CalibrationErrors, AWrongFocalLengthIsASidewaysErrorOfTheSameShare) {
  Camera longer = d457();
  longer.fx_px *= 1.01;
  longer.fy_px *= 1.01;
  // RMS of a hundredth of the distance from the axis: 0.5 m, half sides 0.82 and 0.62, uniform.
  const double rms_m = 0.005 * std::sqrt((0.82 * 0.82 + 0.62 * 0.62) / 3);
  EXPECT_NEAR(calibration_errors(d457(), longer).fruit_m, rms_m, 0.1 * rms_m);
}

TEST(BoardPhotographs, ShowTheBoardWhereTheTrueLensSeesIt) {
  const BoardPhotographs board({"rig=d457", "board=charuco_a4", "views=3"}, 4);
  ASSERT_EQ(board.size(), 3);
  double squares = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int i = 0; i < board.size(); ++i) {
    const TargetView found =
        find_target(light_of(board.take(i).sensors.at(0).color), board.target());
    ASSERT_TRUE(is_usable(found)) << found.reason;
    const TrueView& truth = board.truth().front().views.at(static_cast<std::size_t>(i));
    for (const TargetObservation& seen : found.points) {
      const Eigen::Vector3d& at = board.points_in_world_m().at(static_cast<std::size_t>(seen.id));
      const auto pixel = project(truth.camera, pose_at_row(truth, seen.pixel_px.y()) * at);
      ASSERT_TRUE(pixel.has_value());
      const Eigen::Vector2d off = seen.pixel_px - *pixel;
      sum += off;
      squares += off.squaredNorm();
      ++count;
    }
  }
  ASSERT_GT(count, 100);
  // The sensor's noise and mosaic leave .02 px a coordinate.
  EXPECT_LT(std::sqrt(squares / (2 * count)), 0.05);
  EXPECT_LT((sum / count).norm(), 0.01);
}

TEST(BoardPhotographs, RefuseABoardThatMoves) {
  EXPECT_THROW(BoardPhotographs({"rig=d457", "place=hand"}, 1), std::invalid_argument);
}

TEST(Studies, EveryPointHasAJobOfItsOwnAndKeysThatExist) {
  for (const bool quick : {false, true}) {
    std::set<std::string> names, keys;
    StudiesConfig config;
    config.quick = quick;
    for (const ShardJob& job : study_jobs(config)) {
      EXPECT_TRUE(names.insert(job.name).second) << job.name;
      EXPECT_TRUE(keys.insert(job.key).second) << job.key;
    }
    EXPECT_GT(names.size(), 30U);
    for (const StudyPoint& point : study_points(quick)) {
      std::vector<std::string> sets = study_sets(quick);
      sets.insert(sets.end(), point.sets.begin(), point.sets.end());
      EXPECT_NO_THROW(plant_run_config(BoardsSceneConfig(), sets)) << point.name();
    }
  }
}

TEST(Studies, RowsAreTheRmsOverRunsAndSayHowManyWereSolved) {
  StudiesConfig config;
  const StudyPoint point = study_points(false).front();
  std::vector<ScoreRow> rows;
  for (int run = 0; run < 2; ++run) {
    ScoreRow row;
    row.suite = "calibration";
    row.scene = point.axis;
    row.case_name = point.name() + " run " + std::to_string(run);
    row.method = point.methods.front().name;
    row.metric = "projection.rms";
    row.value = run == 0 ? 3 : 4;
    row.wall_s = 2;
    row.status = run == 0 ? ScoreStatus::ok : ScoreStatus::not_solved;
    rows.push_back(row);
  }
  const std::vector<ScoreRow> pooled = study_rows(rows, config);
  ASSERT_EQ(pooled.size(), 2U);
  EXPECT_NEAR(pooled[0].value, std::sqrt(12.5), 1e-12);
  EXPECT_EQ(pooled[0].status, ScoreStatus::not_solved);
  EXPECT_EQ(pooled[1].metric, "solved");
  EXPECT_EQ(pooled[1].value, 0.5);
  EXPECT_EQ(pooled[1].wall_s, 2);
}

TEST(Studies, SpoilMovesTheShareOfPointsThatIsAskedFor) {
  std::vector<TargetView> views(20);
  for (TargetView& view : views) {
    for (int id = 0; id < 100; ++id) view.points.push_back({id, Eigen::Vector2d::Zero()});
  }
  spoil(views, 0.1, Rng(1));
  int moved = 0;
  for (const TargetView& view : views) {
    for (const TargetObservation& point : view.points) {
      const double far_px = point.pixel_px.norm();
      if (far_px == 0) continue;
      ++moved;
      EXPECT_GE(far_px, 2);
      EXPECT_LE(far_px, 20);
    }
  }
  EXPECT_NEAR(moved, 200, 3 * std::sqrt(2000 * 0.1 * 0.9));
}

}  // namespace
}  // namespace cousin
