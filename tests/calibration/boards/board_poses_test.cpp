#include "calibration/boards/board_poses.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "calibration/boards/board_detection.h"
#include "tests/calibration/boards/synthetic_board.h"

namespace cousin {
namespace {

/// Corners of a shoot at their true places plus noise; about a tenth hidden by "seeds".
Corners true_corners(const synthetic::Shoot& shoot, const SeedBoard& board, double sigma_px,
                     Rng rng) {
  Corners corners;
  for (std::size_t i = 0; i < shoot.views.size(); ++i) {
    FrameCorners frame{static_cast<int>(i), BoardStatus::ok, {}};
    Rng noise = rng.fork(i);
    for (int row = 0; row < board.squares - 1; ++row) {
      for (int column = 0; column < board.squares - 1; ++column) {
        const bool hidden =
            row > 3 && row < 10 && column > 3 && column < 10 && (row + column) % 2 == 0;
        if (!corner_exists(board, column, row) || hidden) continue;
        const Eigen::Vector2d pixel =
            synthetic::true_pixel(shoot.views[i], corner_in_world_m(board, column, row));
        frame.corners.push_back({column, row,
                                 pixel + sigma_px * Eigen::Vector2d(normal(noise), normal(noise)),
                                 isotropic_px2(std::max(sigma_px, 1e-3))});
      }
    }
    corners.push_back(frame);
  }
  return corners;
}

struct Score {
  int posed = 0;
  double centre_rms_m = 0;
  double normalized = 0;  ///< RMS of the pose error over the predicted covariance, per component
};

[[maybe_unused]] Score score(const Poses& poses, const synthetic::Shoot& shoot) {
  Score s;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].status != PoseStatus::ok) continue;
    ++s.posed;
    const Pose truth = synthetic::middle_pose(shoot.views[i]);
    const Pose& pose = poses[i].camera_from_world;
    s.centre_rms_m += (centre_in_world_m(pose) - centre_in_world_m(truth)).squaredNorm();
    const Eigen::AngleAxisd turn((truth.rotation * pose.rotation.conjugate()).normalized());
    const double angle = std::remainder(turn.angle(), 2 * M_PI);
    Eigen::Matrix<double, 6, 1> d;
    d << angle * turn.axis(), truth.translation_m - pose.translation_m;
    s.normalized += d.dot(poses[i].covariance.ldlt().solve(d)) / 6;
  }
  s.centre_rms_m = std::sqrt(s.centre_rms_m / s.posed);
  s.normalized = std::sqrt(s.normalized / s.posed);
  return s;
}

#ifndef COUSIN_NO_CERES

TEST(BoardPoses, CamerasAreWithinAThirdOfAMillimetreAndTheirCovarianceIsHonest) {
  const SeedBoard board;
  for (const int width : {1280, 1920}) {
    synthetic::ShootConfig config;
    config.width_px = width;
    config.report_centre_error_px = width / 1280.0;
    const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(21));
    // 0.01 px is what detect_board reaches on these images.
    const Corners corners = true_corners(shoot, board, 0.01, Rng(22));
    const Poses poses = estimate_board_poses(shoot.capture, corners, board);
    const Score s = score(poses, shoot);
    EXPECT_EQ(s.posed, 60);
    EXPECT_LT(s.centre_rms_m, 0.0003) << width;
    // 360 components, though not independent: 1 within 30 %.
    EXPECT_GT(s.normalized, 0.7) << width;
    EXPECT_LT(s.normalized, 1.35) << width;
    // The focal length was reported 0.2 % off.
    EXPECT_NEAR(poses[30].camera.fx_px / shoot.views[30].camera.fx_px, 1, 0.0005);
  }
}

TEST(BoardPoses, CornersKnownBetterAlongOneLineAreUsedAsSuch) {
  // A tenfold sigma along a line that turns from view to view, as at grazing views.
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 24;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(25));
  Corners lozenges = true_corners(shoot, board, 0, Rng(26));
  Corners circles = lozenges;
  Rng noise(27);
  for (std::size_t i = 0; i < lozenges.size(); ++i) {
    const Eigen::Rotation2Dd turn(0.7 * static_cast<double>(i) + 0.4);
    const Eigen::Matrix2d axes = turn.toRotationMatrix();
    const Eigen::Vector2d sigma_px(0.3, 0.03);
    for (std::size_t k = 0; k < lozenges[i].corners.size(); ++k) {
      CornerObservation& c = lozenges[i].corners[k];
      const Eigen::Vector2d draw(normal(noise), normal(noise));
      c.pixel_px += axes * sigma_px.cwiseProduct(draw);
      c.covariance_px2 = axes * sigma_px.cwiseAbs2().asDiagonal() * axes.transpose();
      circles[i].corners[k].pixel_px = c.pixel_px;
      circles[i].corners[k].covariance_px2 = isotropic_px2(rms_sigma_px(c.covariance_px2));
    }
  }
  const Score with = score(estimate_board_poses(shoot.capture, lozenges, board), shoot);
  const Score without = score(estimate_board_poses(shoot.capture, circles, board), shoot);
  EXPECT_GT(with.normalized, 0.7);
  EXPECT_LT(with.normalized, 1.35);
  EXPECT_LT(with.centre_rms_m, 0.8 * without.centre_rms_m);
}

/// What a sheet does to corners whose middle lies `sag_m` deeper than the edges at +-x, twisted by
/// as much.
void bend(const synthetic::Shoot& shoot, const SeedBoard& board, double sag_m, Corners& corners) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (CornerObservation& corner : corners[i].corners) {
      const Eigen::Vector3d flat_m = corner_in_world_m(board, corner.column, corner.row);
      const double x = flat_m.x() / 0.05, y = flat_m.y() / 0.05;
      const Eigen::Vector3d bent_m =
          flat_m + Eigen::Vector3d(0, 0, sag_m * (x * x - 1.0 / 3 + x * y));
      corner.pixel_px += synthetic::true_pixel(shoot.views[i], bent_m) -
                         synthetic::true_pixel(shoot.views[i], flat_m);
    }
  }
}

TEST(BoardPoses, ABentSheetIsSolvedForAndPosesAreAsGoodAsOnAFlatOne) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 24;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(31));
  const Corners flat = true_corners(shoot, board, 0.01, Rng(32));
  Corners bent = flat;
  bend(shoot, board, 0.0005, bent);
  const Score of_flat = score(estimate_board_poses(shoot.capture, flat, board), shoot);
  const Score of_bent = score(estimate_board_poses(shoot.capture, bent, board), shoot);
  EXPECT_EQ(of_bent.posed, 24);
  EXPECT_LT(of_bent.centre_rms_m, 1.5 * of_flat.centre_rms_m);
  EXPECT_LT(of_bent.normalized, 1.6);
  // Taken for flat, fewer views are posed, or cameras are far off.
  BoardPosesConfig plane;
  plane.sheet_bend_m = 0;
  const Score by_plane = score(estimate_board_poses(shoot.capture, bent, board, plane), shoot);
  EXPECT_TRUE(by_plane.posed < 24 || by_plane.centre_rms_m > 2 * of_bent.centre_rms_m)
      << by_plane.posed << " " << by_plane.centre_rms_m;
}

TEST(BoardPoses, HandMotionIsWorthSolvingFor) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 24;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(23));
  const Corners corners = true_corners(shoot, board, 0.01, Rng(24));
  const Score with = score(estimate_board_poses(shoot.capture, corners, board), shoot);
  const Score without =
      score(estimate_board_poses(shoot.capture, corners, board, {.hand_speed_m_per_s = 0}), shoot);
  EXPECT_LT(with.centre_rms_m, 0.5 * without.centre_rms_m);
}

TEST(BoardPoses, TheLawOfFocusIsWorthMoreThanAPhonesFocusScale) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.distance_scale = 1.6;
  config.report_focus_error = 0.1;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(31));
  const Corners corners = true_corners(shoot, board, 0.01, Rng(32));
  const Score law = score(estimate_board_poses(shoot.capture, corners, board), shoot);
  const Score scale =
      score(estimate_board_poses(shoot.capture, corners, board, {.focus_law = false}), shoot);
  EXPECT_LT(law.centre_rms_m, 0.9 * scale.centre_rms_m);
}

TEST(BoardPoses, AFixedFocusIsLeftAsReported) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 24;
  synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(33));
  for (std::size_t i = 0; i < shoot.views.size(); ++i) {
    Camera& reported = shoot.capture.frames[i].sensors[0].reported;
    reported.fx_px = reported.fy_px = shoot.views[i].camera.fx_px = shoot.views[i].camera.fy_px =
        1080;
  }
  const Corners corners = true_corners(shoot, board, 0.01, Rng(34));
  const Poses with = estimate_board_poses(shoot.capture, corners, board);
  const Poses without = estimate_board_poses(shoot.capture, corners, board, {.focus_law = false});
  for (std::size_t i = 0; i < with.size(); ++i) {
    EXPECT_EQ(with[i].camera.fx_px, without[i].camera.fx_px);
  }
}

TEST(BoardPoses, AnExactCaptureGivesTheTruth) {
  const SeedBoard board;
  for (const LensModel model : {LensModel::pinhole, LensModel::opencv5, LensModel::opencv8,
                                LensModel::opencv12, LensModel::kannala_brandt4}) {
    synthetic::ShootConfig config;
    config.views = 9;
    config.lens = model;
    config.readout_s = 0;
    config.report_focal_error = config.report_centre_error_px = config.report_distortion_error = 0;
    config.focus_error = 0;
    const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(25));
    const Poses poses =
        estimate_board_poses(shoot.capture, true_corners(shoot, board, 0, Rng(26)), board);
    // Start and end are exact: what is left is the solver's tolerance.
    EXPECT_LT(score(poses, shoot).centre_rms_m, 1e-7) << to_string(model);
    for (const FramePose& pose : poses) EXPECT_LT(pose.rms_px, 1e-5);
  }
}

TEST(BoardPoses, WildCornersDoNotMoveTheCameras) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 12;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(27));
  Corners corners = true_corners(shoot, board, 0.01, Rng(28));
  const Score clean = score(estimate_board_poses(shoot.capture, corners, board), shoot);
  Rng rng(29);
  for (FrameCorners& frame : corners) {
    for (int i = 0; i < 5; ++i) {
      frame.corners[uniform_index(rng, frame.corners.size())].pixel_px += Eigen::Vector2d(3, -2);
    }
  }
  const Score wild = score(estimate_board_poses(shoot.capture, corners, board), shoot);
  EXPECT_EQ(wild.posed, 12);
  EXPECT_LT(wild.centre_rms_m, 1.3 * clean.centre_rms_m);
}

TEST(BoardPoses, OneViewKeepsTheReportedLensAndSaysHowUnsureItIs) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 1;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(30));
  const Poses poses =
      estimate_board_poses(shoot.capture, true_corners(shoot, board, 0.01, Rng(31)), board);
  ASSERT_EQ(poses[0].status, PoseStatus::ok);
  EXPECT_EQ(poses[0].camera, shoot.capture.frames[0].sensors[0].reported);
  EXPECT_LT(score(poses, shoot).centre_rms_m, 0.004);  // 0.2 % of 0.45 m, and the principal point
  EXPECT_LT(score(poses, shoot).normalized, 3);
}

TEST(BoardPoses, ImagesInCamerasOut) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 9;
  const synthetic::Shoot shoot = synthetic::shoot(config, board, {}, Rng(32));
  const Corners corners = detect_board(shoot.capture, board);
  const Score s = score(estimate_board_poses(shoot.capture, corners, board), shoot);
  EXPECT_EQ(s.posed, 9);
  EXPECT_LT(s.centre_rms_m, 0.0005);  // nine views know the lens less well than sixty
  EXPECT_LT(s.normalized, 2);
}

#endif  // COUSIN_NO_CERES

TEST(BoardPoses, HopelessViewsHaveAStatus) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 6;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(33));
  Corners corners = true_corners(shoot, board, 0.01, Rng(34));
  corners[0].corners.clear();
  corners[0].status = BoardStatus::not_seen;
  corners[1].corners.resize(3);
  std::erase_if(corners[2].corners, [](const CornerObservation& c) { return c.row != 4; });
  const Poses poses = estimate_board_poses(shoot.capture, corners, board);
  EXPECT_EQ(poses[0].status, PoseStatus::no_board);
  EXPECT_EQ(poses[1].status, PoseStatus::degenerate);
  EXPECT_EQ(poses[2].status, PoseStatus::degenerate);
  EXPECT_EQ(poses[4].frame, 4);
  Capture lenses = shoot.capture;
  LensModel& model = lenses.frames[5].sensors.front().reported.model;
  model = model == LensModel::opencv8 ? LensModel::opencv5 : LensModel::opencv8;
  EXPECT_THROW(estimate_board_poses(lenses, corners, board), std::invalid_argument);
  corners[3].corners[0].column = 99;
  EXPECT_THROW(estimate_board_poses(shoot.capture, corners, board), std::invalid_argument);
  corners.pop_back();
  EXPECT_THROW(estimate_board_poses(shoot.capture, corners, board), std::invalid_argument);
}

TEST(BoardPoses, ThreadsDoNotChangeAByte) {
  const SeedBoard board;
  synthetic::ShootConfig config;
  config.views = 9;
  const synthetic::Shoot shoot = synthetic::plan_shoot(config, Rng(35));
  const Corners corners = true_corners(shoot, board, 0.01, Rng(36));
  Poses reference;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Poses poses = estimate_board_poses(shoot.capture, corners, board);
    if (reference.empty()) reference = poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(poses[i].camera_from_world.rotation.coeffs(),
                reference[i].camera_from_world.rotation.coeffs());
      EXPECT_EQ(poses[i].camera_from_world.translation_m,
                reference[i].camera_from_world.translation_m);
      EXPECT_EQ(poses[i].covariance, reference[i].covariance);
      EXPECT_EQ(poses[i].camera, reference[i].camera);
    }
  }
}

}  // namespace
}  // namespace cousin
