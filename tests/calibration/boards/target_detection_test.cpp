// calibration/boards/target_detection.h: every kind of print found, placed, and refused where it is
// another.
#include "calibration/boards/target_detection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/boards/target_grid.h"
#include "tests/calibration/boards/synthetic_target.h"

namespace cousin {
namespace {

using synthetic::shoot_target;
using synthetic::TargetImageConfig;
using synthetic::TargetShot;
using synthetic::tilted;

Camera camera_640() {
  return {.model = LensModel::opencv5,
          .width_px = 640,
          .height_px = 480,
          .fx_px = 700,
          .fy_px = 702,
          .cx_px = 315.3,
          .cy_px = 243.8,
          .distortion = {-0.12, 0.05, 0.0005, -0.0003, 0}};
}

CalibrationTarget chessboard() { return {TargetKind::chessboard, 10, 7, 0.025, 0, ""}; }
CalibrationTarget charuco() { return {TargetKind::charuco, 9, 7, 0.025, 0.73, "DICT_4X4_50"}; }
CalibrationTarget april_grid() { return {TargetKind::april_grid, 6, 5, 0.030, 0.3, ""}; }
CalibrationTarget circles() { return {TargetKind::circles, 8, 6, 0.030, 0.3, ""}; }
CalibrationTarget staggered() { return {TargetKind::asymmetric_circles, 4, 11, 0.020, 0.42, ""}; }

struct Errors {
  double rms_px = 0, worst_px = 0;  ///< per coordinate; of a point
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  double inside_95 = 0;  ///< share within the predicted ellipse
  int count = 0;
};

Errors errors_of(const TargetView& view, const TargetShot& shot) {
  Errors e;
  for (const TargetObservation& o : view.points) {
    const Eigen::Vector2d off = o.pixel_px - shot.true_px.at(o.id);
    e.rms_px += off.squaredNorm();
    e.worst_px = std::max(e.worst_px, off.norm());
    e.mean_px += off;
    // Chi-square of two degrees: 95 % within 5.991.
    e.inside_95 += off.dot(o.covariance_px2.inverse() * off) < 5.991;
    ++e.count;
  }
  if (e.count > 0) {
    e.rms_px = std::sqrt(e.rms_px / (2 * e.count));
    e.mean_px /= e.count;
    e.inside_95 /= e.count;
  }
  return e;
}

/// An even number of rows: its two layouts differ.
CalibrationTarget even_charuco() { return {TargetKind::charuco, 8, 6, 0.03, 0.7, "DICT_4X4_50"}; }

TEST(FindTarget, EitherLayoutOfACharucoBoardIsFoundAndTheOtherRefused) {
  const CalibrationTarget target = even_charuco();
  for (const CharucoLayout layout : {CharucoLayout::current, CharucoLayout::legacy}) {
    const Pose pose = tilted(0.45, 0.3, 0.5, 0.1, {0, 0});
    const TargetShot shot =
        shoot_target(target, camera_640(), pose, {.layout = layout, .samples = 3}, Rng(1));
    const bool is_legacy = layout == CharucoLayout::legacy;
    const LayoutVotes votes = layout_votes(shot.light, target);
    EXPECT_GT(is_legacy ? votes.legacy : votes.current, 30);
    EXPECT_GT(is_legacy ? votes.legacy - votes.current : votes.current - votes.legacy, 12);
    const TargetView view = find_target(shot.light, target, {}, layout);
    EXPECT_EQ(view.status, TargetStatus::ok) << view.reason;
    EXPECT_EQ(view.points.size(), 7U * 5U);
    for (const TargetObservation& o : view.points)
      EXPECT_LT((o.pixel_px - shot.true_px.at(o.id)).norm(), 0.1) << o.id;
    const TargetView other = find_target(
        shot.light, target, {}, is_legacy ? CharucoLayout::current : CharucoLayout::legacy);
    EXPECT_EQ(other.status, TargetStatus::wrong_target);
    EXPECT_THAT(other.reason, ::testing::HasSubstr(is_legacy ? "legacy" : "current"));
  }
}

TEST(FindTarget, FindsEveryKindAndNumbersItsPoints) {
  struct Case {
    CalibrationTarget target;
    double distance_m;
    TargetStatus status;
  };
  for (const Case& c : {Case{chessboard(), 0.42, TargetStatus::ok},
                        {charuco(), 0.4, TargetStatus::ok},
                        {april_grid(), 0.42, TargetStatus::ok},
                        {circles(), 0.46, TargetStatus::half_turn_unknown},
                        {staggered(), 0.42, TargetStatus::ok}}) {
    for (const double tilt : {0.0, 0.35, 0.6}) {
      const TargetShot shot =
          shoot_target(c.target, camera_640(), tilted(c.distance_m, tilt, 0.7, 0.1), {}, Rng(1));
      const TargetView view = find_target(shot.light, c.target);
      const std::string name = std::string(to_string(c.target.kind)) + " " + std::to_string(tilt);
      EXPECT_EQ(view.status, c.status) << name << ": " << view.reason;
      const Errors e = errors_of(view, shot);
      EXPECT_EQ(e.count, static_cast<int>(target_points(c.target).size())) << name;
      // 12 x 12 samples of a pixel, and the lens's bend within a window or across a disc.
      const bool has_discs =
          c.target.kind == TargetKind::circles || c.target.kind == TargetKind::asymmetric_circles;
      EXPECT_LT(e.worst_px, 0.05) << name;
      EXPECT_LT(e.rms_px, has_discs ? 0.018 : 0.012) << name;
      EXPECT_TRUE(std::is_sorted(
          view.points.begin(), view.points.end(),
          [](const TargetObservation& a, const TargetObservation& b) { return a.id < b.id; }));
    }
  }
}

TEST(FindTarget, CornersAreUnbiasedNearTheBoundAndCoveredAsPredicted) {
  const TargetImageConfig clean{.blur_px = 1, .noise = 0, .samples = 16};
  constexpr double kNoise = 0.01;
  double bias_sum = 0;
  int inside = 0, count = 0;
  double ratio_sum = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (int v = 0; v < 6; ++v) {
    const Pose pose = tilted(0.42 + 0.02 * v, 0.12 * v, 1.1 * v, 0.2 * v - 0.5);
    const TargetShot shot = shoot_target(chessboard(), camera_640(), pose, clean, Rng(1));
    for (int draw = 0; draw < 5; ++draw) {
      TargetShot noisy = shot;
      Rng rng = Rng(3).fork(static_cast<std::uint64_t>(v)).fork(static_cast<std::uint64_t>(draw));
      for (float& p : noisy.light) p += static_cast<float>(kNoise * 0.8 * normal(rng));
      const TargetView view = find_target(noisy.light, chessboard());
      ASSERT_TRUE(is_usable(view)) << view.reason;
      for (const TargetObservation& o : view.points) {
        const Eigen::Vector2d at = shot.true_px.at(o.id), off = o.pixel_px - at;
        // The window's bound: the clean picture's own gradients, all else known.
        Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
        const int cx = static_cast<int>(std::lround(at.x())),
                  cy = static_cast<int>(std::lround(at.y()));
        for (int y = cy - 5; y <= cy + 5; ++y) {
          for (int x = cx - 5; x <= cx + 5; ++x) {
            const Eigen::Vector2d g(
                0.5 * static_cast<double>(shot.light(x + 1, y) - shot.light(x - 1, y)),
                0.5 * static_cast<double>(shot.light(x, y + 1) - shot.light(x, y - 1)));
            information += g * g.transpose();
          }
        }
        const Eigen::Matrix2d whitened = information / (kNoise * kNoise * 0.64);
        ratio_sum += off.dot(whitened * off) / 2;
        inside += off.dot(o.covariance_px2.inverse() * off) < 5.991;
        mean += off;
        ++count;
      }
    }
  }
  mean /= count;
  bias_sum = mean.norm();
  EXPECT_GT(count, 1500);
  EXPECT_LT(bias_sum, 0.01);
  EXPECT_LT(std::sqrt(ratio_sum / count), 1.5);
  // 1600 points: the share's deviation is 0.5 %; five of those about 95 %.
  EXPECT_NEAR(inside / static_cast<double>(count), 0.95, 0.028);
}

TEST(FindTarget, AToneCurveMovesNoCorner) {
  TargetShot shot =
      shoot_target(chessboard(), camera_640(), tilted(0.42, 0.4, 0.3, 0.2), {}, Rng(1));
  for (float& v : shot.light) v = std::pow(v, 1 / 1.8F);
  const TargetView view = find_target(shot.light, chessboard());
  ASSERT_TRUE(is_usable(view)) << view.reason;
  EXPECT_LT(errors_of(view, shot).rms_px, 0.012);
}

TEST(FindTarget, PartsOfMarkerBoardsAreViews) {
  for (const CalibrationTarget& target : {charuco(), april_grid()}) {
    const TargetShot shot =
        shoot_target(target, camera_640(), tilted(0.3, 0.4, 0.7, 0.3, {0.09, -0.06}), {}, Rng(1));
    const int all = static_cast<int>(target_points(target).size());
    ASSERT_LT(static_cast<int>(shot.true_px.size()), all);
    const TargetView view = find_target(shot.light, target);
    ASSERT_EQ(view.status, TargetStatus::ok) << view.reason;
    const Errors e = errors_of(view, shot);
    EXPECT_GT(e.count, 0.7 * static_cast<double>(shot.true_px.size()));
    EXPECT_LT(e.worst_px, 0.06);
  }
}

TEST(FindTarget, ACornerBeyondTheBorderIsNotSoughtAmongAMarkersOwn) {
  // A row of corners has left the picture; corners of the markers' bits are still in it.
  int taken = 0;
  for (const Pose& pose : {tilted(0.288, 0.257, 4.403, 1.774, {-0.034, -0.0477}),
                           tilted(0.36, 0.82, 0.974, 3.326, {-0.0907, 0.0298})}) {
    const TargetShot shot =
        shoot_target(charuco(), camera_640(), pose, {.noise = 0.01, .samples = 3}, Rng(1));
    const auto count_outside = [&](const TargetDetectionConfig& config) {
      const TargetView view = find_target(shot.light, charuco(), config);
      EXPECT_EQ(view.status, TargetStatus::ok) << view.reason;
      return std::count_if(view.points.begin(), view.points.end(),
                           [&](const auto& o) { return !shot.true_px.contains(o.id); });
    };
    taken += static_cast<int>(count_outside({.max_misplaced = 1}));
    EXPECT_EQ(count_outside({}), 0);
  }
  EXPECT_GT(taken, 0) << "these poses show nothing";
}

TEST(FindTarget, AnAprilGridOfSmallTagsIsFound) {
  // Tags of 35 pixels, 11 between them: outlines are a pixel or two off.
  for (int k = 0; k < 4; ++k) {
    const TargetShot shot =
        shoot_target(april_grid(), camera_640(), tilted(0.6, 0.2 + 0.1 * k, 0.7 * k, 0.4 * k),
                     {.noise = 0.01}, Rng(1));
    const TargetView view = find_target(shot.light, april_grid());
    ASSERT_EQ(view.status, TargetStatus::ok) << k << ": " << view.reason;
    const Errors e = errors_of(view, shot);
    EXPECT_GT(e.count, 0.9 * static_cast<double>(shot.true_px.size()));
    EXPECT_LT(e.worst_px, 0.2);
  }
}

TEST(DropMisplaced, TakesWhatItsNeighboursDenyAndKeepsAPlaneThroughALens) {
  const TargetGrid grid(charuco());
  const Camera camera = camera_640();
  const Pose pose = tilted(0.35, 0.6, 0.4, 0.2);
  FoundPixels found;
  for (const TargetPoint& p : grid.points())
    found.push_back(project(camera, pose * Eigen::Vector3d(p.at_m.x(), p.at_m.y(), 0)));
  const FoundPixels whole = found;
  EXPECT_EQ(drop_misplaced(grid, found, 0.05), 0);
  // An outermost corner, as drop_strays still has it among its neighbours.
  *found.front() += Eigen::Vector2d(7, -5);
  FoundPixels by_strays = found;
  EXPECT_EQ(drop_strays(grid, by_strays, 0.25), 0);
  EXPECT_EQ(drop_misplaced(grid, found, 0.1), 1);
  EXPECT_FALSE(found.front());
  EXPECT_EQ(count_found(found), count_found(whole) - 1);
}

TEST(FindTarget, APartOfAChessboardIsRefused) {
  const TargetShot shot =
      shoot_target(chessboard(), camera_640(), tilted(0.3, 0.2, 0.7, 0.1, {0.08, 0}), {}, Rng(1));
  const TargetView view = find_target(shot.light, chessboard());
  EXPECT_EQ(view.status, TargetStatus::too_few_points) << view.reason;
  EXPECT_TRUE(view.points.empty());
}

TEST(FindTarget, UpsideDownBoardsKeepTheirNumbersWhereThePrintTells) {
  for (const CalibrationTarget& target : {chessboard(), charuco(), april_grid(), staggered()}) {
    const TargetShot shot =
        shoot_target(target, camera_640(), tilted(0.45, 0.3, 0.7, 3.0), {}, Rng(1));
    const TargetView view = find_target(shot.light, target);
    ASSERT_EQ(view.status, TargetStatus::ok) << to_string(target.kind) << view.reason;
    EXPECT_LT(errors_of(view, shot).worst_px, 0.05) << to_string(target.kind);
  }
}

TEST(FindTarget, ABoardThatHidesAHalfTurnIsNumberedFromItsUpperEnd) {
  CalibrationTarget target = chessboard();
  target.columns = 9;  // 8 x 6 inner corners
  for (const double roll : {0.1, 3.2}) {
    const TargetShot shot =
        shoot_target(target, camera_640(), tilted(0.42, 0.3, 0.7, roll), {}, Rng(1));
    const TargetView view = find_target(shot.light, target);
    ASSERT_EQ(view.status, TargetStatus::half_turn_unknown) << view.reason;
    EXPECT_LT(view.points.front().pixel_px.y(), view.points.back().pixel_px.y());
  }
}

TEST(FindTarget, RefusesABoardOfAnotherSize) {
  for (CalibrationTarget target : {chessboard(), charuco(), circles(), staggered()}) {
    const TargetShot shot =
        shoot_target(target, camera_640(), tilted(0.46, 0.3, 0.7, 0.1), {}, Rng(1));
    target.columns -= target.kind == TargetKind::asymmetric_circles ? 1 : 2;
    const TargetView view = find_target(shot.light, target);
    EXPECT_EQ(view.status, TargetStatus::wrong_target)
        << to_string(target.kind) << ": " << view.reason;
    EXPECT_FALSE(view.reason.empty());
  }
}

TEST(FindTarget, RefusesAMirroredPicture) {
  for (const CalibrationTarget& target : {charuco(), april_grid()}) {
    const TargetShot shot =
        shoot_target(target, camera_640(), tilted(0.42, 0.3, 0.7, 0.1), {}, Rng(1));
    Image<float> mirrored = shot.light;
    for (int y = 0; y < mirrored.height(); ++y) {
      const auto row = mirrored.row(y);
      std::reverse(row.begin(), row.end());
    }
    EXPECT_FALSE(is_usable(find_target(mirrored, target))) << to_string(target.kind);
  }
}

TEST(FindTarget, FindsNothingInNoiseAndInSmallImages) {
  Image<float> noise(320, 240);
  Rng rng(5);
  for (float& v : noise) v = 0.5F + 0.1F * static_cast<float>(normal(rng));
  for (const CalibrationTarget& target :
       {chessboard(), charuco(), april_grid(), circles(), staggered()}) {
    const TargetView view = find_target(noise, target);
    EXPECT_FALSE(is_usable(view));
    EXPECT_FALSE(view.reason.empty());
    EXPECT_FALSE(is_usable(find_target(Image<float>(5, 5), target)));
  }
  EXPECT_THROW((void)find_target(noise, {TargetKind::charuco, 9, 7, 0.025, 0.73, "DICT_9X9"}),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
