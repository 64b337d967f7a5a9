// calibration/boards/partial_circles.h and seed_board_target.h through find_target.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/boards/partial_circles.h"
#include "calibration/boards/seed_board_target.h"
#include "calibration/boards/target_detection.h"
#include "tests/calibration/boards/synthetic_board.h"
#include "tests/calibration/boards/synthetic_target.h"

namespace cousin {
namespace {

using synthetic::shoot_target;
using synthetic::TargetShot;
using synthetic::tilted;

Camera camera_vga() {
  return {.model = LensModel::opencv5,
          .width_px = 640,
          .height_px = 480,
          .fx_px = 700,
          .fy_px = 702,
          .cx_px = 315.3,
          .cy_px = 243.8,
          .distortion = {-0.12, 0.05, 0.0005, -0.0003, 0}};
}

CalibrationTarget circles() { return {TargetKind::circles, 8, 6, 0.030, 0.3, ""}; }
CalibrationTarget staggered() { return {TargetKind::asymmetric_circles, 4, 11, 0.020, 0.42, ""}; }

double worst_px(const TargetView& view, const TargetShot& shot) {
  double worst = 0;
  for (const TargetObservation& o : view.points) {
    const auto at = shot.true_px.find(o.id);
    if (at == shot.true_px.end()) return 1e9;
    worst = std::max(worst, (o.pixel_px - at->second).norm());
  }
  return worst;
}

TEST(PartialCircles, ACornerAndMoreDiscsThanAColumnHasSayWhichAreSeen) {
  // The upper left of the board; its right and lower parts are outside the picture.
  const TargetShot shot =
      shoot_target(circles(), camera_vga(), tilted(0.3, 0.2, 0.7, 0.1, {0.025, 0.05}), {}, Rng(1));
  const TargetView view = find_target(shot.light, circles());
  ASSERT_EQ(view.status, TargetStatus::half_turn_unknown) << view.reason;
  EXPECT_GE(view.points.size(), 24U);
  EXPECT_LT(view.points.size(), 48U);
  EXPECT_LT(worst_px(view, shot), 0.1);
}

TEST(PartialCircles, ACornerThatAQuarterTurnWouldShowAsWellIsRefused) {
  // Six discs by five, where a column has six, too: nothing tells rows from columns.
  const TargetShot shot =
      shoot_target(circles(), camera_vga(), tilted(0.3, 0.2, 0.7, 0.1, {0.06, 0.05}), {}, Rng(1));
  const TargetView view = find_target(shot.light, circles());
  EXPECT_EQ(view.status, TargetStatus::too_few_points) << view.reason;
  EXPECT_NE(view.reason.find("4 ways"), std::string::npos) << view.reason;
}

TEST(PartialCircles, ThreeSidesOfStaggeredRowsSayWhichDiscsAreSeen) {
  const TargetShot shot =
      shoot_target(staggered(), camera_vga(), tilted(0.27, 0.2, 0.7, 0.05, {0, 0.06}), {}, Rng(1));
  ASSERT_LT(shot.true_px.size(), 40U);
  const TargetView view = find_target(shot.light, staggered());
  ASSERT_EQ(view.status, TargetStatus::ok) << view.reason;
  EXPECT_GE(view.points.size(), 16U);
  EXPECT_LT(worst_px(view, shot), 0.1);
}

TEST(PartialCircles, TheMiddleOfAGridIsRefusedWithTheNumberOfPlaces) {
  for (const CalibrationTarget& target : {circles(), staggered()}) {
    const TargetShot shot =
        shoot_target(target, camera_vga(), tilted(0.14, 0.2, 0.7, 0.1), {}, Rng(1));
    const TargetView view = find_target(shot.light, target);
    EXPECT_EQ(view.status, TargetStatus::too_few_points) << view.reason;
    EXPECT_NE(view.reason.find("ways"), std::string::npos) << view.reason;
    EXPECT_TRUE(view.points.empty());
  }
}

TEST(PartialCircles, APartOfALargerGridIsNoneOfThisOne) {
  const TargetShot shot =
      shoot_target(circles(), camera_vga(), tilted(0.3, 0.2, 0.7, 0.1, {0.06, 0.05}), {}, Rng(1));
  CalibrationTarget small = circles();
  small.columns = 3;
  small.rows = 3;
  EXPECT_FALSE(is_usable(find_target(shot.light, small)));
}

TEST(PartialCircles, AnEvenNumberOfStaggeredRowsHidesAHalfTurn) {
  CalibrationTarget even = staggered();
  even.rows = 10;
  EXPECT_TRUE(is_half_turn_symmetric(TargetGrid(even)));
  EXPECT_FALSE(is_half_turn_symmetric(TargetGrid(staggered())));
  EXPECT_TRUE(is_half_turn_symmetric(TargetGrid(circles())));
  const TargetShot shot = shoot_target(even, camera_vga(), tilted(0.45, 0.3, 0.7, 0.1), {}, Rng(1));
  const TargetView view = find_target(shot.light, even);
  EXPECT_EQ(view.status, TargetStatus::half_turn_unknown) << view.reason;
  EXPECT_EQ(view.points.size(), 40U);
  EXPECT_LT(worst_px(view, shot), 0.1);
}

CalibrationTarget seed_target() {
  const SeedBoard board;
  return {TargetKind::seed_board,
          board.squares,
          board.squares,
          board.square_m,
          board.marker_m / board.square_m,
          ""};
}

TEST(SeedBoardTarget, IsFoundWithoutKnowingTheLens) {
  const Camera camera = synthetic::phone_camera(1280);
  for (const double azimuth : {0.3, 2.0}) {
    const Pose pose = synthetic::orbit(0.25, 1.0, azimuth);
    const synthetic::View taken{camera, pose, pose};
    const Image<Rgb8> picture = synthetic::photograph(taken, SeedBoard{}, {}, {}, Rng(2));
    const TargetView view = find_target(light_of(picture), seed_target());
    ASSERT_EQ(view.status, TargetStatus::ok) << view.reason;
    // 14 x 14 corners less those in markers' blocks.
    EXPECT_GT(view.points.size(), 0.7 * static_cast<double>(target_points(seed_target()).size()));
    double squares = 0;
    for (const TargetPoint& p : target_points(seed_target())) {
      const auto at = std::find_if(view.points.begin(), view.points.end(),
                                   [&](const auto& o) { return o.id == p.id; });
      if (at == view.points.end()) continue;
      const Eigen::Vector2d truth = synthetic::true_pixel(taken, {p.at_m.x(), p.at_m.y(), 0});
      squares += (at->pixel_px - truth).squaredNorm();
    }
    EXPECT_LT(std::sqrt(squares / (2.0 * static_cast<double>(view.points.size()))), 0.08);
  }
}

TEST(SeedBoardTarget, WithoutMarkersAQuarterTurnIsUnknown) {
  CalibrationTarget plain = seed_target();
  plain.mark_share = 0;
  const TargetView view = find_target(Image<float>(200, 200, 0.5F), plain);
  EXPECT_FALSE(is_usable(view));
  EXPECT_NE(view.reason.find("quarter turn"), std::string::npos);
  EXPECT_FALSE(is_usable(find_target(Image<float>(200, 200, 0.5F), seed_target())));
  EXPECT_THROW((void)find_seed_board(Image<float>(200, 200, 0.5F), circles()),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
