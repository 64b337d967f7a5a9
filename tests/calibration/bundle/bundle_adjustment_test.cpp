#include "calibration/bundle/bundle_adjustment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calibration/boards/planar_pose.h"
#include "calibration/bundle/bundle_problem.h"
#include "calibration/solve/observation_cost.h"
#include "sim/types/rng.h"
#include "tests/calibration/bundle/plant_capture.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Cameras of three lens models.
std::vector<Camera> lenses_of_three_kinds() {
  std::vector<Camera> lenses(3, phone());
  lenses[0].model = LensModel::pinhole;
  lenses[0].distortion = {};
  lenses[2].model = LensModel::kannala_brandt4;
  lenses[2].distortion = {0.02, -0.01, 0.003, -0.001};
  return lenses;
}

TEST(ObserveZoomed, IsTheLensWithItsFocalLengthsMultiplied) {
  constexpr double kZoom = 1.03, kStep = 1e-6;
  const Vector6d pose_numbers = pose_vector(look_at({0.3, -0.2, 0.4}, {0, 0, 0.02}));
  const PosedFrame pose(pose_numbers.data());
  const Vector3d point(0.03, 0.02, 0.05);
  for (const Camera& camera : lenses_of_three_kinds()) {
    const LensShape shape = shape_of(camera);
    const Eigen::VectorXd lens = lens_parameters(camera);
    const auto pixel = [&](const Eigen::VectorXd& of, double zoom, const Vector6d& from,
                           const Vector3d& at) {
      ObservationValue value;
      EXPECT_TRUE(observe_zoomed(shape, of.data(), zoom, PosedFrame(from.data()), at, value,
                                 nullptr, nullptr));
      return value.pixel_px;
    };
    Eigen::VectorXd zoomed = lens;
    zoomed.head<2>() *= kZoom;
    EXPECT_LT(
        (pixel(lens, kZoom, pose_numbers, point) - pixel(zoomed, 1, pose_numbers, point)).norm(),
        1e-9);
    // Derivatives against central differences: errors of step^2 and of rounding over the step.
    RowMatrix d_lens(2, lens.size());
    ObservationValue value;
    Vector2d d_zoom;
    ASSERT_TRUE(
        observe_zoomed(shape, lens.data(), kZoom, pose, point, value, d_lens.data(), &d_zoom));
    const auto differs = [&](const Vector2d& high, const Vector2d& low, const Vector2d& given) {
      return ((high - low) / (2 * kStep) - given).norm() / std::max(1.0, given.norm());
    };
    EXPECT_LT(differs(pixel(lens, kZoom + kStep, pose_numbers, point),
                      pixel(lens, kZoom - kStep, pose_numbers, point), d_zoom),
              1e-5);
    for (Eigen::Index k = 0; k < lens.size(); ++k) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(lens.size(), k);
      EXPECT_LT(differs(pixel(lens + step, kZoom, pose_numbers, point),
                        pixel(lens - step, kZoom, pose_numbers, point), d_lens.col(k)),
                1e-5)
          << k;
    }
    for (int k = 0; k < 6; ++k) {
      const Vector6d step = kStep * Vector6d::Unit(k);
      EXPECT_LT(
          differs(pixel(lens, kZoom, pose_numbers + step, point),
                  pixel(lens, kZoom, pose_numbers - step, point), value.d_rig_from_points.col(k)),
          1e-5)
          << k;
    }
    for (int k = 0; k < 3; ++k) {
      const Vector3d step = kStep * Vector3d::Unit(k);
      EXPECT_LT(differs(pixel(lens, kZoom, pose_numbers, point + step),
                        pixel(lens, kZoom, pose_numbers, point - step), value.d_point.col(k)),
                1e-5)
          << k;
    }
  }
}

#ifdef COUSIN_NO_CERES
TEST(BundleAdjustment, SaysThatItIsNotBuilt) {
  const auto result = adjust_bundle(plant_capture(4, 20, 0, false, 1).truth);
  EXPECT_EQ(result.status, CalibrationStatus::not_built);
}
#else

TEST(BundleAdjustment, ExactTracksGiveTheLensExactly) {
  const PlantCapture capture = plant_capture(24, 150, 0, false, 1);
  const auto result = adjust_bundle(disturbed(capture.truth, 1));
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  EXPECT_LT(result.rms_px, 1e-7);
  EXPECT_NEAR(result.lenses[0].fx_px, 1080, 1e-3);
  EXPECT_NEAR(result.lenses[0].cx_px, 643, 1e-3);
  EXPECT_NEAR(result.lenses[0].distortion[0], 0.05, 1e-6);
  EXPECT_EQ(result.gauge, BundleGauge::similarity);
}

TEST(BundleAdjustment, APointThatRejectionLeavesToOneImageHasNoPlace) {
  const PlantCapture capture = plant_capture(16, 80, 0.2, false, 4);
  BundleAdjustmentInput start = disturbed(capture.truth, 4);
  // Two images that see something else each: no place fits both.
  const auto odd = static_cast<int>(start.points_in_world_m.size());
  start.points_in_world_m.push_back(start.points_in_world_m.front());
  for (const int image : {0, 6}) {
    const auto seen = std::find_if(
        start.observations.begin(), start.observations.end(),
        [&](const BundleObservation& o) { return o.image == image && o.point == (image ? 0 : 1); });
    ASSERT_NE(seen, start.observations.end());
    BundleObservation wrong = *seen;
    wrong.point = odd;
    wrong.pixel_px.y() += image ? 60 : -60;
    start.observations.push_back(wrong);
  }
  const auto result = adjust_bundle(start, {.reject_sigmas = 6});
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  EXPECT_TRUE(result.rejected[start.observations.size() - 1]);
  EXPECT_TRUE(result.rejected[start.observations.size() - 2]);
  EXPECT_TRUE(result.points_in_world_m.back().hasNaN());
  EXPECT_TRUE(result.points_in_world_m.front().allFinite());
}

// What is known of the points to 2 mm, images tell to 0.4: most of what is measured is known
// before.
TEST(BundleAdjustment, TheFactorOfTheSightingsCountsWhatIsKnownOfThePoints) {
  BundleAdjustmentConfig fixed;
  fixed.fixed = {"lens"};
  double squares = 0;
  constexpr int kRuns = 40;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    PlantCapture capture = plant_capture(2, 10, 1, false, 300 + run);
    Rng rng = Rng(run).fork("known");
    BundleAdjustmentInput start = capture.truth;
    for (int p = 0; p < 10; ++p) {
      const Vector3d off(normal(rng), normal(rng), normal(rng));
      Vector3d& at = start.points_in_world_m[static_cast<std::size_t>(p)];
      at += 0.002 * off;
      start.known_points.push_back({p, at, 0.002});
    }
    // Of one that no image shows nothing is learned.
    start.points_in_world_m.emplace_back(0, 0, 5);
    start.known_points.push_back({10, {0, 0, 5}, 1e-5});
    const auto result = adjust_bundle(start, fixed);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
    squares += result.sigma_px * result.sigma_px / kRuns;
  }
  // 28 freedoms a run: the mean's deviation is sqrt(2 / 28 / 40) = 0.042.
  EXPECT_NEAR(squares, 1, 3 * 0.042);
}

TEST(BundleAdjustment, DeviationsCoverTheTruth) {
  double squares = 0;
  int count = 0, inside = 0;
  for (std::uint64_t run = 0; run < 12; ++run) {
    const PlantCapture capture = plant_capture(12, 150, 0.5, false, 100 + run);
    // So few sightings leave the image's corners open: deviations are to be right all the same.
    BundleAdjustmentConfig any_deviation;
    any_deviation.max_deviation_share = 1;
    const auto result = adjust_bundle(disturbed(capture.truth, run), any_deviation);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
    const Camera truth = phone();
    const std::array<double, 9> values = {
        truth.fx_px,         truth.fy_px,         truth.cx_px,
        truth.cy_px,         truth.distortion[0], truth.distortion[1],
        truth.distortion[2], truth.distortion[3], truth.distortion[4]};
    for (int k = 0; k < 9; ++k) {
      const double z = (result.values[k] - values[static_cast<std::size_t>(k)]) /
                       std::sqrt(result.covariance(k, k));
      squares += z * z;
      inside += std::abs(z) < 1.96;
      ++count;
    }
  }
  // Mean of z^2 is 1; its deviation, with nine correlated parameters a run, at most sqrt(2 / 12).
  EXPECT_NEAR(squares / count, 1, 3 * std::sqrt(2.0 / 12));
  EXPECT_GT(inside, 0.85 * count);
}

TEST(BundleAdjustment, ParallelViewsOfAFlatBenchDoNotFixTheLens) {
  const PlantCapture capture = plant_capture(25, 120, 0.3, true, 5);
  const auto result = adjust_bundle(disturbed(capture.truth, 5));
  EXPECT_EQ(result.status, CalibrationStatus::not_determined) << result.lenses[0].fx_px;
  EXPECT_THAT(result.not_determined, testing::Contains("lens0.fx_px"));
  // With the lens given it is a plain problem.
  BundleAdjustmentInput start = disturbed(capture.truth, 5);
  start.lenses = capture.truth.lenses;
  BundleAdjustmentConfig fixed;
  fixed.fixed = {"lens"};
  EXPECT_EQ(adjust_bundle(start, fixed).status, CalibrationStatus::ok);
}

TEST(BundleAdjustment, SightingsInTheMiddleOfTheImagesDoNotFixTheDistortion) {
  const PlantCapture capture = plant_capture(25, 400, 0.5, false, 7);
  const Camera lens = phone();
  BundleAdjustmentInput middle = disturbed(capture.truth, 7);
  std::erase_if(middle.observations, [&](const BundleObservation& seen) {
    return (seen.pixel_px - Vector2d(lens.cx_px, lens.cy_px)).norm() > 0.12 * lens.width_px;
  });
  const auto open = adjust_bundle(middle);
  EXPECT_EQ(open.status, CalibrationStatus::not_determined) << open.reason;
  EXPECT_THAT(open.not_determined, testing::Contains("lens0.k1"));
  // With all of the image it is fixed.
  const auto whole = adjust_bundle(disturbed(capture.truth, 7));
  EXPECT_EQ(whole.status, CalibrationStatus::ok) << whole.reason;
  EXPECT_THAT(whole.not_determined, testing::IsEmpty());
}

TEST(BundleAdjustment, WrongMatchesAreRejected) {
  PlantCapture capture = plant_capture(16, 80, 0.3, false, 6);
  Rng rng = Rng(6).fork("wrong");
  std::vector<bool> wrong;
  for (BundleObservation& seen : capture.truth.observations) {
    wrong.push_back(uniform(rng) < 0.05);
    if (wrong.back()) seen.pixel_px += Vector2d(uniform(rng, 8, 40), uniform(rng, -40, -8));
  }
  BundleAdjustmentConfig config;
  config.reject_sigmas = 4;
  const auto result = adjust_bundle(disturbed(capture.truth, 6), config);
  ASSERT_EQ(result.status, CalibrationStatus::ok) << result.reason;
  int missed = 0, good_gone = 0;
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    missed += wrong[i] && !result.rejected[i];
    good_gone += !wrong[i] && result.rejected[i];
  }
  EXPECT_EQ(missed, 0);
  EXPECT_LT(good_gone, 0.01 * static_cast<double>(wrong.size()));
  EXPECT_NEAR(result.sigma_px, 0.3, 0.02);
}

/// As matches of SIFT leave them: each point in two to five images that follow one another, a tenth
/// of the sightings off by far more than the rest.
PlantCapture short_tracks(std::uint64_t seed) {
  constexpr int kImages = 20;
  PlantCapture capture = plant_capture(kImages, 150, 0.25, false, seed);
  Rng rng = Rng(seed).fork("tracks");
  std::vector<BundleObservation> kept;
  for (BundleObservation seen : capture.truth.observations) {
    if ((seen.image - seen.point % kImages + kImages) % kImages >= 2 + seen.point % 4) continue;
    if (uniform(rng) < 0.1) seen.pixel_px += 1.5 * Vector2d(normal(rng), normal(rng));
    kept.push_back(seen);
  }
  capture.truth.observations = std::move(kept);
  return capture;
}

TEST(BundleAdjustment, ContradictingSightingsUnderARedescendingLossDoNotKeepItFromConverging) {
  BundleAdjustmentConfig config;
  config.loss = RobustLoss::cauchy;
  config.loss_px = 0.5;
  config.focal_prior_share = 0.02;
  config.centre_prior_px = 10;
  config.distortion_prior = 0.02;
  config.tolerance = 1e-9;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const BundleAdjustmentInput truth = short_tracks(seed).truth;
    const auto result = adjust_bundle(disturbed(truth, seed), config);
    ASSERT_EQ(result.status, CalibrationStatus::ok) << seed << " " << result.reason;
    // It is the same minimum as from the truth, not one of the many in which sightings hold each
    // other far away from where they belong: a few points may sit in another valley.
    const auto from_truth = adjust_bundle(truth, config);
    EXPECT_EQ(from_truth.status, CalibrationStatus::ok) << seed << " " << from_truth.reason;
    EXPECT_LT(result.cost_px2, 1.03 * from_truth.cost_px2) << seed;
  }
}

// The ray of one image passes through another camera's centre, and that camera sees the point
// somewhere else: only its centre itself explains both.
TEST(BundleAdjustment, ACostThatOnlyCreepsHasSettledAndOneThatFallsHasNot) {
  const auto falling_by = [](double a_step, std::size_t steps) {
    std::vector<double> costs = {2000};
    for (std::size_t i = 0; i < steps; ++i) costs.push_back(880 - a_step * static_cast<double>(i));
    return costs;
  };
  EXPECT_TRUE(cost_has_settled(falling_by(2.5e-6, 300)));  // as measured on a model of COLMAP
  EXPECT_FALSE(cost_has_settled(falling_by(2e-5, 300)));
  EXPECT_FALSE(cost_has_settled(falling_by(2.5e-6, 40)));  // too few steps to tell
  std::vector<double> over_a_ridge = falling_by(2.5e-6, 290);
  over_a_ridge.back() -= 0.4;
  EXPECT_FALSE(cost_has_settled(over_a_ridge));
  EXPECT_FALSE(cost_has_settled({}));
}

TEST(BundleAdjustment, APointThatEndsAtACamerasCentreGoes) {
  BundleAdjustmentInput input = plant_capture(12, 60, 0.2, false, 6).truth;
  const BundleAdjustmentConfig config = {.loss = RobustLoss::cauchy, .loss_px = 1};
  const BundleAdjustmentResult without = adjust_bundle(input, config);
  ASSERT_EQ(without.status, CalibrationStatus::ok) << without.reason;
  const Lens lens(input.lenses[0]);
  const Vector3d eye = centre_in_world_m(input.camera_from_world[0]);
  const auto seen = lens.project(input.camera_from_world[6] * eye);
  ASSERT_TRUE(seen);
  const auto wrong = static_cast<int>(input.points_in_world_m.size());
  input.points_in_world_m.push_back(0.9 * eye);
  input.observations.push_back({0, wrong, {200, 600}, 1});
  input.observations.push_back({6, wrong, *seen, 1});
  const BundleAdjustmentResult with = adjust_bundle(input, config);
  ASSERT_EQ(with.status, CalibrationStatus::ok) << with.reason;
  EXPECT_FALSE(with.points_in_world_m[60].allFinite());
  EXPECT_TRUE(with.rejected.end()[-1]);
  EXPECT_NEAR(with.lenses[0].fx_px, without.lenses[0].fx_px, 1e-3);
  for (std::size_t p = 0; p < 60; ++p)
    EXPECT_LT((with.points_in_world_m[p] - without.points_in_world_m[p]).norm(), 1e-6);
}

TEST(BundleAdjustment, PointsWithNearlyParallelRaysAreLeftOut) {
  PlantCapture capture = plant_capture(8, 40, 0.1, false, 7);
  // A point far behind the plant, seen under a fraction of a degree.
  capture.truth.points_in_world_m.push_back(Vector3d(0, 200, 20));
  const Lens lens(capture.truth.lenses[0]);
  for (int i = 0; i < 8; ++i) {
    const auto pixel = lens.project(capture.truth.camera_from_world[static_cast<std::size_t>(i)] *
                                    capture.truth.points_in_world_m.back());
    if (pixel) capture.truth.observations.push_back({i, 40, *pixel, 1});
  }
  ASSERT_LT(parallax_rad(capture.truth, 40), 0.01);
  BundleAdjustmentConfig config;
  config.min_parallax_rad = 1.5 * std::numbers::pi / 180;
  const auto result = adjust_bundle(capture.truth, config);
  EXPECT_TRUE(std::isnan(result.points_in_world_m.back().x()));
  EXPECT_FALSE(std::isnan(result.points_in_world_m.front().x()));
}

TEST(BundleAdjustment, ImagesThatFocusAnewGetTheirFocalLengths) {
  BundleAdjustmentInput input = plant_capture(12, 80, 0, false, 4).truth;
  const Vector2d centre_px(input.lenses[0].cx_px, input.lenses[0].cy_px);
  std::vector<double> zoom;
  Rng rng = Rng(4).fork("zoom");
  for (std::size_t i = 0; i < input.camera_from_world.size(); ++i)
    zoom.push_back(1 + 0.003 * normal(rng));
  for (BundleObservation& seen : input.observations) {
    const double z = zoom[static_cast<std::size_t>(seen.image)];
    seen.pixel_px = centre_px + z * (seen.pixel_px - centre_px);
    seen.sigma_px = 1e-3;  // so that what is known of the zoom before bears on nothing
  }
  const BundleAdjustmentResult shared = adjust_bundle(input);
  ASSERT_EQ(shared.status, CalibrationStatus::ok) << shared.reason;
  EXPECT_GT(shared.rms_px, 0.02);
  EXPECT_EQ(shared.zoom, std::vector<double>(zoom.size(), 1));
  const BundleAdjustmentResult own = adjust_bundle(input, {.zoom_share = 0.003});
  ASSERT_EQ(own.status, CalibrationStatus::ok) << own.reason;
  EXPECT_LT(own.rms_px, 1e-4);
  for (std::size_t i = 0; i < zoom.size(); ++i)
    EXPECT_NEAR(own.zoom[i] * own.lenses[0].fx_px / (zoom[i] * input.lenses[0].fx_px), 1, 1e-4);
}

TEST(BundleAdjustment, TheSameBytesTwice) {
  const BundleAdjustmentInput start = disturbed(plant_capture(10, 60, 0.3, false, 8).truth, 8);
  const auto a = adjust_bundle(start), b = adjust_bundle(start);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.covariance, b.covariance);
}
#endif

TEST(BundleAdjustment, RefusesWhatIsNoBundle) {
  BundleAdjustmentInput input = plant_capture(4, 20, 0, false, 9).truth;
  input.observations.front().image = 7;
  auto result = adjust_bundle(input);
  EXPECT_EQ(result.status, CalibrationStatus::bad_input);
  EXPECT_THAT(result.reason, testing::HasSubstr("image 7"));
  input = plant_capture(4, 20, 0, false, 9).truth;
  input.known_distances = {{3, 3, 1, 1e-3}};
  EXPECT_EQ(adjust_bundle(input).status, CalibrationStatus::bad_input);
  input.known_distances.clear();
  input.camera_from_world.resize(1);
  input.lens_of_image.resize(1);
  EXPECT_THAT(adjust_bundle(input).reason, testing::HasSubstr("at least 2"));
}

}  // namespace
}  // namespace cousin
