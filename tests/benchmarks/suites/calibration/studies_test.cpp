#include "benchmarks/suites/calibration/studies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/suites/calibration/board_photographs.h"
#include "benchmarks/suites/calibration/calibration_errors.h"
#include "benchmarks/suites/calibration/study_points.h"
#include "calibration/boards/target_detection.h"
#include "scenes/boards/boards_scene.h"

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

TEST(BoardPhotographs, OneDoesNotDependOnHowManyThereAreNorOnOtherSensors) {
  const std::vector<std::string> sets = {"rig=d457", "board=charuco_a4"};
  const std::vector<std::string> blurred = {"rig.color.lens.blur_sigma_px=2"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = sets;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  const BoardPhotographs few(with({"views=2"}), 4);
  const BoardPhotographs many(with({"views=5"}), 4, {.sensors = {{}, blurred}});
  const BoardPhotographs alone(with({"views=2", blurred.front()}), 4);
  const std::vector<Frame> each = many.take_each(1, 2);
  ASSERT_EQ(each.size(), 2U);
  EXPECT_EQ(few.take(1).sensors.at(0).color, each[0].sensors.at(0).color);
  EXPECT_EQ(alone.take(1).sensors.at(0).color, each[1].sensors.at(0).color);
  EXPECT_NE(each[0].sensors.at(0).color, each[1].sensors.at(0).color);
  EXPECT_EQ(many.take_each(1, 1).size(), 1U);
}

TEST(BoardPhotographs, RefuseASensorThatSeesOtherLight) {
  EXPECT_THROW(
      BoardPhotographs({"rig=d457", "views=2"}, 1, {.sensors = {{}, {"rig.color_focal_px=400"}}}),
      std::invalid_argument);
  EXPECT_THROW(BoardPhotographs({"rig=d457", "views=2"}, 1, {.sensors = {}}),
               std::invalid_argument);
}

TEST(BoardPhotographs, FewRaysAtEdgesAddLittleToTheSensorsNoise) {
  const std::vector<std::string> sets = {"rig=d457", "board=charuco_a4", "views=2"};
  const BoardPhotographs few(sets, 4), many(sets, 4, {.edge_samples = 256});
  double of_rays = 0, of_all = 0;
  int count = 0;
  for (int i = 0; i < 2; ++i) {
    const TargetView a = find_target(light_of(few.take(i).sensors.at(0).color), few.target());
    const TargetView b = find_target(light_of(many.take(i).sensors.at(0).color), few.target());
    const TrueView& truth = few.truth().front().views.at(static_cast<std::size_t>(i));
    std::size_t k = 0;
    for (const TargetObservation& seen : a.points) {
      while (k < b.points.size() && b.points[k].id < seen.id) ++k;
      if (k == b.points.size() || b.points[k].id != seen.id) continue;
      const Eigen::Vector3d& at = few.points_in_world_m().at(static_cast<std::size_t>(seen.id));
      const auto pixel = project(truth.camera, truth.camera_from_world * at);
      ASSERT_TRUE(pixel.has_value());
      of_rays += (seen.pixel_px - b.points[k].pixel_px).squaredNorm();
      of_all += (seen.pixel_px - *pixel).squaredNorm();
      ++count;
    }
  }
  ASSERT_GT(count, 60);
  // The same noise of the sensor in both: what differs are the rays. A fifth of the variance is a
  // tenth of the deviation.
  EXPECT_LT(of_rays, 0.2 * of_all)
      << std::sqrt(of_rays / (2 * count)) << " px of " << std::sqrt(of_all / (2 * count)) << " px";
}

TEST(BoardPhotographs, RefuseABoardThatMoves) {
  EXPECT_THROW(BoardPhotographs({"rig=d457", "place=hand"}, 1), std::invalid_argument);
}

// A job's name is the file of its kept result: another name makes it anew.
TEST(Studies, JobsKeepTheirNames) {
  const auto names = [](const StudiesConfig& config) {
    std::string text;
    for (const ShardJob& job : study_jobs(config)) {
      EXPECT_TRUE(job.name.starts_with("study_") && job.name.ends_with(".json")) << job.name;
      text += job.name.substr(6, job.name.size() - 11) + " ";
    }
    return text;
  };
  std::istringstream points(
      "images_3 tilt_3_deg tilt_5_deg tilt_10_deg tilt_20_deg tilt_45_deg "
      "size_of_the_board_in_the_picture_0.25 "
      "size_of_the_board_in_the_picture_0.5 "
      "size_of_the_board_in_the_picture_0.85 coverage_0 coverage_0.5 "
      "coverage_1 squares_0.012_m squares_0.022_m squares_0.045_m "
      "rolling_shutter_0_s rolling_shutter_0.01_s rolling_shutter_0.033_s "
      "warp_0.001_m warp_0.004_m print_stretch_0.003 print_stretch_0.01 "
      "board_chessboard_a4 board_aprilgrid_a4 board_circles_a4 "
      "board_acircles_a4 lens_model_8_images strawberries_tilted_up_to_4_deg "
      "strawberries_tilted_up_to_10_deg "
      "strawberries_tilted_up_to_45_deg__close "
      "strawberries_tilted_up_to_10_deg__paper_bent_by_2_mm focus_held "
      "focus_breathes ");
  std::vector<std::string> of_run;
  for (std::string point; points >> point;) of_run.push_back(point);
  std::string full = "positions_as_made positions_off ";
  for (const char* run : {"0", "1", "2", "3", "4"}) {
    for (const std::string& point : of_run) full += point + "_run" + run + " ";
  }
  EXPECT_EQ(names({}), full);
  EXPECT_EQ(names({.quick = true}),
            "positions_as_made positions_off images_5_run0 tilt_5_deg_run0 "
            "tilt_45_deg_run0 size_of_the_board_in_the_picture_0.25_run0 "
            "size_of_the_board_in_the_picture_0.85_run0 coverage_0_run0 "
            "coverage_1_run0 squares_0.012_m_run0 squares_0.045_m_run0 "
            "rolling_shutter_0_s_run0 rolling_shutter_0.033_s_run0 "
            "warp_0.004_m_run0 print_stretch_0.01_run0 board_chessboard_a4_run0 "
            "board_aprilgrid_a4_run0 board_circles_a4_run0 board_acircles_a4_run0 "
            "lens_model_12_images_run0 strawberries_tilted_up_to_4_deg_run0 "
            "strawberries_tilted_up_to_10_deg_run0 "
            "strawberries_tilted_up_to_45_deg__close_run0 "
            "strawberries_tilted_up_to_10_deg__paper_bent_by_2_mm_run0 "
            "focus_held_run0 focus_breathes_run0 ");
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
    EXPECT_GT(names.size(), 15U);
    for (const StudyPoint& point : study_points(quick)) {
      std::vector<std::string> sets = study_sets();
      sets.insert(sets.end(), point.sets.begin(), point.sets.end());
      sets.insert(sets.end(), point.sensor_sets.begin(), point.sensor_sets.end());
      EXPECT_NO_THROW(run_config(boards_row(), sets)) << point.name();
    }
  }
}

TEST(Studies, EachPointIsInOneGroupThatTakesItsPhotographs) {
  for (const bool quick : {false, true}) {
    std::multiset<std::string> grouped, all;
    std::size_t groups = 0;
    for (const StudyGroup& group : study_groups(quick)) {
      ++groups;
      ASSERT_EQ(group.sensor_of_point.size(), group.points.size());
      ASSERT_EQ(group.sensor_views.size(), group.sensors.size());
      EXPECT_TRUE(std::is_sorted(group.sensor_views.rbegin(), group.sensor_views.rend()));
      for (std::size_t p = 0; p < group.points.size(); ++p) {
        const StudyPoint& point = group.points[p];
        grouped.insert(point.name());
        const std::size_t sensor = group.sensor_of_point[p];
        EXPECT_LE(point.views, group.sensor_views.at(sensor)) << point.name();
        EXPECT_LE(group.sensor_views.at(sensor), group.views);
        // The group's keys and its sensor's say the same as the point's own.
        std::vector<std::string> own = study_sets(), of_group = group.sets;
        for (const auto* more : {&point.sets, &point.sensor_sets})
          own.insert(own.end(), more->begin(), more->end());
        of_group.insert(of_group.end(), group.sensors[sensor].begin(), group.sensors[sensor].end());
        EXPECT_EQ(resolved_toml(run_config(boards_row(), own)),
                  resolved_toml(run_config(boards_row(), of_group)))
            << point.name();
      }
    }
    for (const StudyPoint& point : study_points(quick)) all.insert(point.name());
    EXPECT_EQ(grouped, all);
    EXPECT_LT(groups, all.size());
  }
}

ScoreRow pooled_row(const StudyPoint& point, const std::string& method, double value) {
  ScoreRow row;
  row.suite = "calibration";
  row.scene = point.axis;
  row.case_name = point.name();
  row.method = method;
  row.metric = "fruit.position";
  row.value = value;
  row.n = 5;
  return row;
}

TEST(Studies, CrossingsLieWhereLinesCross) {
  std::vector<ScoreRow> rows;
  for (const StudyPoint& point : study_points(false)) {
    if (point.axis == "knock") {
      rows.push_back(pooled_row(point, "fresh, 30 photographs", 3));
      rows.push_back(pooled_row(point, "fresh, 12 photographs", 100));
      rows.push_back(pooled_row(point, "fresh, 5 photographs", 0.5));
      rows.push_back(pooled_row(point, "as the device reports", 1 + 2 * point.x));
    }
    if (point.axis == "images") {
      rows.push_back(pooled_row(point, "ceres opencv5", 30 / point.x));
      rows.push_back(pooled_row(point, "as the device reports", 3));
    }
  }
  const std::vector<ScoreRow> crossings = crossing_rows(rows);
  ASSERT_EQ(crossings.size(), 4U);
  EXPECT_EQ(crossings[0].method, "fresh, 5 photographs");
  EXPECT_EQ(crossings[0].value, 0);  // from the start
  EXPECT_EQ(crossings[1].status, ScoreStatus::not_solved);
  EXPECT_TRUE(std::isnan(crossings[1].value));
  EXPECT_NEAR(crossings[2].value, 1, 1e-12);
  EXPECT_EQ(crossings[2].unit, "px");
  EXPECT_EQ(crossings[3].value, 12);  // 30 / 8 > 3 > 30 / 12
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
