#include "perception/sfm/self_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "tests/perception/sfm/plant_views.h"

namespace cousin {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A start without distortion whose focal length is 1 % off.
Camera rough_lens() {
  Camera lens = plant_lens();
  lens.fx_px *= 1.01;
  lens.fy_px *= 1.01;
  lens.cx_px = 639.5;
  lens.cy_px = 359.5;
  lens.distortion = {};
  return lens;
}

SelfCalibration calibrated(const PlantViewsConfig& config, std::uint64_t seed) {
  return self_calibrate(plant_views(config, seed).model, rough_lens());
}

bool is_built() {
  return calibrated({.images = 8, .points = 30}, 1).status != CalibrationStatus::not_built;
}

double value(const SelfCalibration& result, const std::string& name) {
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    if (result.parameters[i] == name) return result.values[static_cast<Eigen::Index>(i)];
  }
  return std::nan("");
}

TEST(SelfCalibration, TheTrueLensLiesWithinItsIntervals) {
  if (!is_built()) GTEST_SKIP() << "built without Ceres";
  const Camera truth = plant_lens();
  const std::array<std::pair<const char*, double>, 6> expected = {{{"fx_px", truth.fx_px},
                                                                   {"fy_px", truth.fy_px},
                                                                   {"cx_px", truth.cx_px},
                                                                   {"cy_px", truth.cy_px},
                                                                   {"k1", truth.distortion[0]},
                                                                   {"p1", truth.distortion[2]}}};
  constexpr int kRuns = 60;
  int within = 0, all = 0;
  // So few tracks leave the image's corners open: the intervals are to be right all the same.
  SelfCalibrationConfig any_deviation;
  any_deviation.adjust.max_deviation_share = 1;
  for (int run = 0; run < kRuns; ++run) {
    const SelfCalibration result = self_calibrate(
        plant_views({.images = 12, .points = 150}, static_cast<std::uint64_t>(100 + run)).model,
        rough_lens(), any_deviation);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
    for (const auto& [name, true_value] : expected) {
      within += std::abs(value(result, name) - true_value) < 1.96 * deviation(result, name);
      ++all;
    }
  }
  // Parameters of one run are dependent: 60 independent draws at 95 % have a standard error of
  // 2.8 %; allow three.
  EXPECT_NEAR(static_cast<double>(within) / all, 0.95, 3 * 0.028);
}

TEST(SelfCalibration, FrameAndUnitOfTheModelDoNotMatter) {
  if (!is_built()) GTEST_SKIP() << "built without Ceres";
  const PlantViews views = plant_views({}, 1);
  const SelfCalibration result = self_calibrate(views.model, rough_lens());
  SfmModel other = views.model;
  const WorldSimilarity away{1e4, Eigen::Quaterniond(0.1, 0.7, 0.2, -0.4).normalized(), {2, 3, -5}};
  for (Pose& pose : other.camera_from_world) pose = moved(pose, away);
  for (SfmPoint& point : other.points) point.in_world_m = away * point.in_world_m;
  const SelfCalibration same = self_calibrate(other, rough_lens());
  for (const char* name : {"fx_px", "cx_px", "k1"}) {
    // Two ways to the same minimum end within a thousandth of its deviation.
    EXPECT_NEAR(value(same, name), value(result, name), 1e-3 * deviation(result, name)) << name;
    EXPECT_NEAR(deviation(same, name), deviation(result, name), 1e-3 * deviation(result, name));
  }
}

TEST(SelfCalibration, ViewsAllAroundAndTurnedHaveNoWeakness) {
  if (!is_built()) GTEST_SKIP() << "built without Ceres";
  const SelfCalibration result = calibrated({}, 2);
  EXPECT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  EXPECT_THAT(result.weaknesses, IsEmpty());
  SelfCalibrationConfig plain;
  plain.adjust.loss = RobustLoss::none;
  const SelfCalibration squares = self_calibrate(plant_views({}, 2).model, rough_lens(), plain);
  EXPECT_NEAR(squares.sigma_px, 0.3, 0.03);  // the noise; 1 / sqrt(2 N) of 2000 sightings is 1.6 %
  EXPECT_LT(result.sigma_px, squares.sigma_px) << "a loss counts large residuals down";
}

TEST(SelfCalibration, LookingStraightDownOnAFlatBenchLeavesTheFocalLengthOpen) {
  if (!is_built()) GTEST_SKIP() << "built without Ceres";
  const SelfCalibration result = calibrated({.path = CameraPath::nadir_flat}, 3);
  EXPECT_EQ(result.status, CalibrationStatus::not_determined);
  EXPECT_THAT(result.not_determined, Contains("fx_px"));
  EXPECT_THAT(result.weaknesses, Contains(CalibrationWeakness::flat_scene));
  EXPECT_THAT(result.weaknesses, Contains(CalibrationWeakness::parallel_views));
  EXPECT_THAT(result.weaknesses, Contains(CalibrationWeakness::no_roll));
  EXPECT_THAT(result.reason, HasSubstr("flat_scene"));
}

TEST(SelfCalibration, MovingTowardsTheSceneIsNamed) {
  if (!is_built()) GTEST_SKIP() << "built without Ceres";
  const SelfCalibration result = calibrated({.path = CameraPath::forward}, 4);
  EXPECT_EQ(result.status, CalibrationStatus::not_determined);
  EXPECT_THAT(result.weaknesses, Contains(CalibrationWeakness::forward_motion));
  EXPECT_THAT(result.weaknesses, Not(Contains(CalibrationWeakness::flat_scene)));
}

TEST(SelfCalibration, ACameraThatHardlyMovesIsNamed) {
  if (!is_built()) GTEST_SKIP() << "built without Ceres";
  const SelfCalibration result = calibrated({.path = CameraPath::still}, 5);
  EXPECT_NE(result.status, CalibrationStatus::ok);
  EXPECT_THAT(result.weaknesses, Contains(CalibrationWeakness::little_parallax));
  EXPECT_FALSE(result.reason.empty());
}

TEST(SelfCalibration, TheGeometryOfAllPathsIsMeasuredAsItWasMade) {
  const auto geometry = [](CameraPath path) {
    BundleAdjustmentInput input;
    const PlantViews views = plant_views({.path = path}, 6);
    input.camera_from_world = views.camera_from_world;
    input.points_in_world_m = views.points_in_world_m;
    return view_geometry(input);
  };
  // Upright cameras have x axes that lie level: no turn.
  EXPECT_NEAR(geometry(CameraPath::upright).roll_rad, 0, 1e-9);
  // 0.6 sin(...) has a root mean square of 0.42 rad.
  EXPECT_NEAR(geometry(CameraPath::around).roll_rad, 0.42, 0.1);
  // Cameras of one vertical plane only pitch: their x axes are one, whatever the up direction.
  BundleAdjustmentInput meridian;
  for (int i = 0; i < 10; ++i) {
    const double pitch = 0.35 + 0.1 * i, wobble = i % 2 == 0 ? 1e-4 : -1e-4;
    meridian.camera_from_world.push_back(
        {Eigen::Quaterniond(Eigen::AngleAxisd(wobble, Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX())),
         {0, 0, 1}});
  }
  EXPECT_LT(view_geometry(meridian).roll_rad, 1e-3);
  EXPECT_NEAR(geometry(CameraPath::nadir_flat).axes_rad, 0, 1e-12);
  EXPECT_NEAR(geometry(CameraPath::nadir_flat).flatness, 0, 1e-7);
  EXPECT_NEAR(geometry(CameraPath::forward).forward, 1, 1e-9);
  EXPECT_LT(geometry(CameraPath::nadir_flat).forward, 1e-9);
}

TEST(SelfCalibration, WrongNumbersAreRefusedAndTooLittleIsSaid) {
  SelfCalibrationConfig config;
  config.min_flatness = 2;
  EXPECT_THROW(self_calibrate(BundleAdjustmentInput{}, config), std::invalid_argument);
  const SelfCalibration none = self_calibrate(BundleAdjustmentInput{});
  EXPECT_EQ(none.status, CalibrationStatus::bad_input);
  EXPECT_FALSE(none.reason.empty());
}

}  // namespace
}  // namespace cousin
