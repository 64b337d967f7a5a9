#include "perception/sfm/sfm_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "calibration/boards/planar_pose.h"
#include "sim/types/rng.h"
#include "tests/perception/sfm/plant_views.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

SfmEstimate refined(const PlantViews& views, const SfmConfig& config = {}) {
  return refine_sfm(views.model, views.frames, views.lens, views.corners, views.board, config);
}

bool is_built() {
  const PlantViews views = plant_views({.images = 6, .points = 20}, 1);
  return refined(views).status != SfmStatus::not_built;
}

#define SKIP_WITHOUT_CERES() \
  if (!is_built()) GTEST_SKIP() << "built without Ceres"

double centre_rms_m(const PlantViews& views, const SfmEstimate& estimate) {
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    if (estimate.poses[i].status != PoseStatus::ok) continue;
    squares += (centre_in_world_m(estimate.poses[i].camera_from_world) -
                centre_in_world_m(views.camera_from_world[i]))
                   .squaredNorm();
    ++count;
  }
  return std::sqrt(squares / count);
}

TEST(SfmPoses, WithoutNoiseTheBoardGivesTruePosesInMetres) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = plant_views({.noise_px = 0, .corner_noise_px = 0}, 1);
  for (const SfmScale scale : {SfmScale::adjusted, SfmScale::squares}) {
    const SfmEstimate estimate = refined(views, {.scale = scale});
    ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
    EXPECT_EQ(estimate.gauge, BundleGauge::metric);
    EXPECT_EQ(estimate.poses.size(), 18U);
    EXPECT_EQ(estimate.poses[3].frame, 13);
    // What the solver's tolerance leaves of 0.4 m.
    EXPECT_LT(centre_rms_m(views, estimate), 1e-7);
    EXPECT_NEAR(estimate.metres_per_unit, 1 / views.model_from_world.scale, 1e-7);
    EXPECT_NEAR(estimate.lens.fx_px, views.lens.fx_px, 1e-3);
    EXPECT_LT(estimate.poses[3].rms_px, 1e-4);
    EXPECT_EQ(estimate.points.size(), views.model.points.size());
  }
}

TEST(SfmPoses, TheBoardInTheAdjustmentBeatsOneFactor) {
  SKIP_WITHOUT_CERES();
  double adjusted = 0, squares = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const PlantViews views = plant_views({}, seed);
    adjusted += centre_rms_m(views, refined(views));
    squares += centre_rms_m(views, refined(views, {.scale = SfmScale::squares}));
  }
  EXPECT_LT(adjusted, squares);
}

/// The lens given is exact: priors about it would predict more than is there.
SfmConfig without_priors() {
  SfmConfig config;
  config.adjust.focal_prior_share = config.adjust.centre_prior_px = config.adjust.distortion_prior =
      0;
  config.corner_floor_px = 0;
  config.board_sigma_m = 1e-6;
  return config;
}

/// Squares of poses' errors over what was predicted of them, and of their part along the line to
/// the board's middle.
struct NormalisedSquares {
  double sum = 0, along = 0;
  int poses = 0;
};
void add_errors(const PlantViews& views, const SfmEstimate& estimate, NormalisedSquares& squares) {
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    const FramePose& pose = estimate.poses[i];
    const Eigen::AngleAxisd turn(
        (pose.camera_from_world * inverse(views.camera_from_world[i])).rotation);
    Eigen::Matrix<double, 6, 1> error;
    error.head<3>() = turn.angle() * turn.axis();
    error.tail<3>() =
        pose.camera_from_world.translation_m - views.camera_from_world[i].translation_m;
    squares.sum += error.dot(pose.covariance.ldlt().solve(error));
    const Vector3d along = views.camera_from_world[i].translation_m.normalized();
    squares.along += std::pow(along.dot(error.tail<3>()), 2) /
                     along.dot(pose.covariance.bottomRightCorner<3, 3>() * along);
    ++squares.poses;
  }
}

TEST(SfmPoses, ErrorsOfPosesAreAsLargeAsPredicted) {
  SKIP_WITHOUT_CERES();
  NormalisedSquares squares;
  constexpr int kRuns = 20;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const PlantViews views = plant_views({.images = 12, .points = 150}, seed);
    const SfmEstimate estimate = refined(views, without_priors());
    ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
    add_errors(views, estimate, squares);
  }
  // Mean square of normalised errors. The images of a run share its lens, so that runs count: 20
  // of them with 6 to 72 freedoms leave a standard error of 2 to 13 %; allow 35 %.
  EXPECT_NEAR(squares.sum / (6 * squares.poses), 1, 0.35);
}

TEST(SfmPoses, ErrorsOfImagesThatFocusOnTheirOwnAreAsLargeAsPredicted) {
  SKIP_WITHOUT_CERES();
  // Nothing is known of the lens before; or it is off by as much as its priors say.
  for (const bool has_priors : {false, true}) {
    SfmConfig config = without_priors();
    if (has_priors) config.adjust = SfmConfig().adjust;
    config.focal = SfmFocal::per_image;
    config.focal_jitter = 0.003;
    NormalisedSquares squares;
    double focal = 0;
    constexpr int kRuns = 12;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
      PlantViews views =
          plant_views({.images = 18, .points = 150, .noise_px = 0.1, .focal_spread = 0.003}, seed);
      double mean_fx_px = 0;
      for (const Camera& own : views.lenses)
        mean_fx_px += own.fx_px / static_cast<double>(views.lenses.size());
      Rng rng = Rng(seed).fork("lens");
      views.lens.fx_px *= 1 + config.adjust.focal_prior_share * normal(rng);
      views.lens.fy_px *= 1 + config.adjust.focal_prior_share * normal(rng);
      views.lens.cx_px += config.adjust.centre_prior_px * normal(rng);
      views.lens.cy_px += config.adjust.centre_prior_px * normal(rng);
      const SfmEstimate estimate = refined(views, config);
      ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
      EXPECT_NEAR(estimate.feature_sigma_px, 0.1, 0.02);
      add_errors(views, estimate, squares);
      ASSERT_EQ(estimate.lens_parameters.front(), "fx_px");
      focal += std::pow(estimate.lens.fx_px - mean_fx_px, 2) / estimate.lens_covariance(0, 0);
    }
    // As above. Along the line of sight, where focal lengths and distances trade, one freedom a
    // pose: 12 to 216 of them, so a standard error of 10 to 40 %; allow 60 %.
    EXPECT_NEAR(squares.sum / (6 * squares.poses), 1, 0.4) << has_priors;
    EXPECT_NEAR(squares.along / squares.poses, 1, 0.6) << has_priors;
    // One freedom a run.
    EXPECT_NEAR(focal / kRuns, 1, 3 * std::sqrt(2.0 / kRuns)) << has_priors;
  }
}

TEST(SfmPoses, WhatIsKnownOfTheLensCountsAsMuchAsItIsWorth) {
  SKIP_WITHOUT_CERES();
  SfmConfig config;
  config.adjust.focal_prior_share = 2e-3;
  config.adjust.centre_prior_px = config.adjust.distortion_prior = 0;
  config.adjust.fixed = {"k2", "k3"};  // with so few tracks a free lens may fold
  for (const SfmScale scale : {SfmScale::none, SfmScale::squares}) {
    config.scale = scale;
    double squares = 0;
    constexpr int kRuns = 24;
    for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
      PlantViews views = plant_views({.images = 10, .points = 40}, seed);
      const double truth_px = views.lens.fx_px;
      Rng rng = Rng(seed).fork("lens");
      views.lens.fx_px *= 1 + 2e-3 * normal(rng);
      views.lens.fy_px *= 1 + 2e-3 * normal(rng);
      const SfmEstimate estimate = refined(views, config);
      ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
      ASSERT_EQ(estimate.lens_parameters.front(), "fx_px");
      const double sigma_px = std::sqrt(estimate.lens_covariance(0, 0));
      EXPECT_LT(sigma_px, 2e-3 * truth_px);  // the images tell something, too
      squares += std::pow((estimate.lens.fx_px - truth_px) / sigma_px, 2);
    }
    // Mean of 24 squared normalised errors: 1, with a deviation of sqrt(2 / 24).
    EXPECT_NEAR(squares / kRuns, 1, 3 * std::sqrt(2.0 / kRuns));
  }
}

TEST(SfmPoses, ImagesWithoutAPlaceAreNamed) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = plant_views({.lost = {2, 7}}, 2);
  const SfmEstimate estimate = refined(views, {.place_by_board = false});
  EXPECT_EQ(estimate.status, SfmStatus::partly_registered);
  EXPECT_THAT(estimate.lost, ElementsAre(12, 17));
  EXPECT_THAT(estimate.reason, HasSubstr("2 of 18 frames found no place: 12 17"));
  EXPECT_EQ(estimate.poses[2].status, PoseStatus::not_converged);
  EXPECT_EQ(estimate.poses[3].status, PoseStatus::ok);
  // 100 points at 0.3 px and 0.4 m: 0.1 mm a coordinate of a camera; allow five times that.
  EXPECT_LT(centre_rms_m(views, estimate), 5e-4);
}

TEST(SfmPoses, ImagesWithoutAPlaceAreGivenOneByTheBoard) {
  SKIP_WITHOUT_CERES();
  PlantViews views = plant_views({.lost = {2, 7, 11}}, 2);
  views.corners[11].corners.resize(5);
  const SfmEstimate estimate = refined(views);
  EXPECT_EQ(estimate.status, SfmStatus::partly_registered);
  EXPECT_THAT(estimate.reason, HasSubstr("1 of 18 frames found no place: 21"));
  EXPECT_THAT(estimate.lost, ElementsAre(21));
  EXPECT_THAT(estimate.by_board, ElementsAre(12, 17));
  EXPECT_EQ(estimate.poses[2].status, PoseStatus::ok);
  EXPECT_GT(estimate.poses[2].corner_count, 100);
  // As for the images that were placed before.
  EXPECT_LT(centre_rms_m(views, estimate), 5e-4);
  const SfmEstimate one_factor = refined(views, {.scale = SfmScale::squares});
  EXPECT_THAT(one_factor.lost, ElementsAre(12, 17, 21));
}

/// The views, some of them as if the board had been taken for itself turned about its normal.
PlantViews with_turned(PlantViews views, const std::vector<int>& images,
                       double turn_rad = std::numbers::pi) {
  const WorldSimilarity turn{1, Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ())),
                             Vector3d::Zero()};
  const WorldSimilarity& away = views.model_from_world;
  for (const int i : images) {
    const auto at = static_cast<std::size_t>(i);
    const Pose turned = moved(views.camera_from_world[at], turn);
    views.model.camera_from_world[at] = moved(turned, away);
    const Lens lens(views.lens);
    // Each of their sightings is of another grain, where the wrong place wants it.
    for (SfmPoint& point : views.model.points) {
      for (SfmSighting& seen : point.sightings) {
        if (seen.image != i) continue;
        const auto pixel = lens.project(views.model.camera_from_world[at] * point.in_world_m);
        if (pixel) seen.pixel_px = *pixel;
      }
    }
  }
  return views;
}

TEST(SfmPoses, ImagesThatTheBoardContradictsAreTakenOut) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = with_turned(plant_views({}, 9), {4, 13});
  const SfmEstimate estimate = refined(views);
  EXPECT_THAT(estimate.contradicted, ElementsAre(14, 23));
  EXPECT_THAT(estimate.by_board, ElementsAre(14, 23));
  EXPECT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
  EXPECT_LT(centre_rms_m(views, estimate), 5e-4);
  const SfmEstimate lost = refined(views, {.place_by_board = false});
  EXPECT_EQ(lost.status, SfmStatus::partly_registered);
  EXPECT_THAT(lost.lost, ElementsAre(14, 23));
  // Believed, they are far off.
  const SfmEstimate believed = refined(views, {.max_board_turn_rad = 3.2});
  EXPECT_GT(centre_rms_m(views, believed), 0.1);
}

TEST(SfmPoses, AnImageThatContradictedOnesLeaveWithoutTracksIsLostAlone) {
  SKIP_WITHOUT_CERES();
  PlantViews views = plant_views({}, 9);
  std::swap(views.corners[4], views.corners[13]);  // their tracks are right, their boards are not
  int shared = 0;
  for (SfmPoint& point : views.model.points) {  // image 7 shares points with these two alone
    const auto sees = [&](int image) {
      return std::any_of(point.sightings.begin(), point.sightings.end(),
                         [&](const SfmSighting& seen) { return seen.image == image; });
    };
    const bool theirs = sees(4) && sees(7) && sees(13) && shared++ < 40;
    std::erase_if(point.sightings, [&](const SfmSighting& seen) {
      return theirs ? seen.image != 4 && seen.image != 7 && seen.image != 13 : seen.image == 7;
    });
  }
  ASSERT_GT(shared, 40);
  const SfmEstimate estimate = refined(views, {.place_by_board = false});
  EXPECT_THAT(estimate.contradicted, ElementsAre(14, 23));
  EXPECT_EQ(estimate.status, SfmStatus::partly_registered) << estimate.reason;
  EXPECT_THAT(estimate.lost, ElementsAre(14, 17, 23));
  EXPECT_LT(centre_rms_m(views, estimate), 5e-4);
}

TEST(SfmPoses, AnImageWhoseTracksAreSomeDegreesOffIsWhereItsBoardIs) {
  SKIP_WITHOUT_CERES();
  // 6 cm off, and less than what is denied before: its corners are hundreds of deviations away.
  const PlantViews views = with_turned(plant_views({}, 9), {4}, 0.15);
  const SfmEstimate estimate = refined(views);
  EXPECT_THAT(estimate.contradicted, testing::IsEmpty());
  ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
  EXPECT_LT(centre_rms_m(views, estimate), 5e-4);
}

TEST(SfmPoses, AModelThatTheBoardContradictsAsAWholeIsNone) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = with_turned(plant_views({}, 9), {0, 1, 2, 3, 4, 5, 6, 7, 8});
  const SfmEstimate estimate = refined(views);
  EXPECT_EQ(estimate.status, SfmStatus::contradicted);
  EXPECT_FALSE(has_poses(estimate.status));
  EXPECT_THAT(estimate.reason,
              HasSubstr("of 18 placed images that show the board, at most 9 agree"));
  for (const FramePose& pose : estimate.poses) EXPECT_NE(pose.status, PoseStatus::ok);
}

TEST(SfmPoses, WithoutABoardPosesAreGoodUpToASimilarity) {
  SKIP_WITHOUT_CERES();
  PlantViews views = plant_views({.noise_px = 0}, 3);
  views.corners.clear();
  const SfmEstimate estimate = refined(views);
  EXPECT_EQ(estimate.status, SfmStatus::no_scale);
  EXPECT_EQ(estimate.gauge, BundleGauge::similarity);
  EXPECT_THAT(estimate.reason, HasSubstr("there is no board"));
  EXPECT_TRUE(std::isnan(estimate.metres_per_unit));
  std::vector<Vector3d> estimated, expected;
  for (std::size_t i = 0; i < views.frames.size(); ++i) {
    estimated.push_back(centre_in_world_m(estimate.poses[i].camera_from_world));
    expected.push_back(centre_in_world_m(views.camera_from_world[i]));
  }
  EXPECT_LT(fit_similarity(expected, estimated).rms_m, 1e-7);
  EXPECT_EQ(refined(views, {.scale = SfmScale::none}).status, SfmStatus::ok);
}

TEST(SfmPoses, ABoardSeenTooLittleGivesNoScale) {
  SKIP_WITHOUT_CERES();
  PlantViews views = plant_views({}, 4);
  for (FrameCorners& frame : views.corners) frame.corners.resize(3);
  const SfmEstimate estimate = refined(views);
  EXPECT_EQ(estimate.status, SfmStatus::no_scale);
  EXPECT_THAT(estimate.reason, HasSubstr("corners of the board were placed, at least 8"));
  for (FrameCorners& frame : views.corners) frame.status = BoardStatus::not_seen;
  EXPECT_THAT(refined(views).reason, HasSubstr("0 corners"));
}

TEST(SfmPoses, TheScaleBySquaresLiesWithinItsInterval) {
  SKIP_WITHOUT_CERES();
  // Sides that share a corner have errors that partly cancel: the deviation is an upper bound.
  int within = 0;
  constexpr int kRuns = 20;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const PlantViews views = plant_views({.images = 12, .points = 60}, seed);
    const SfmEstimate estimate = refined(views, {.scale = SfmScale::squares});
    ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
    EXPECT_GT(estimate.scale_sigma_share, 0);
    // The model as it was handed over was exact: what the adjustment changed is part of the scale.
    const double off = estimate.metres_per_unit * views.model_from_world.scale - 1;
    within += std::abs(off) < 1.96 * estimate.scale_sigma_share ? 1 : 0;
  }
  EXPECT_GE(within, kRuns * 85 / 100);
}

TEST(SfmPoses, ImagesThatFocusOnTheirOwnAreAdjustedSo) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = plant_views({.points = 150, .noise_px = 0.1, .focal_spread = 0.003}, 5);
  SfmConfig config;
  config.focal_jitter = 0.003;
  const double shared = centre_rms_m(views, refined(views, config));
  config.focal = SfmFocal::per_image;
  const SfmEstimate own = refined(views, config);
  ASSERT_EQ(own.status, SfmStatus::ok) << own.reason;
  EXPECT_LT(centre_rms_m(views, own), 0.5 * shared);
  double squares = 0;
  for (std::size_t i = 0; i < own.poses.size(); ++i) {
    squares += std::pow(own.poses[i].camera.fx_px / views.lenses[i].fx_px - 1, 2) /
               static_cast<double>(own.poses.size());
  }
  EXPECT_LT(std::sqrt(squares), 0.001);  // a third of what they differ by
}

TEST(SfmPoses, ImagesThatFocusOnTheirOwnKeepTheScaleAndItsDeviation) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = plant_views({.points = 150, .noise_px = 0.1, .focal_spread = 0.003}, 5);
  SfmConfig config{.scale = SfmScale::squares, .focal = SfmFocal::per_image};
  config.focal_jitter = 0.003;
  const SfmEstimate own = refined(views, config);
  ASSERT_EQ(own.status, SfmStatus::ok) << own.reason;
  EXPECT_EQ(own.gauge, BundleGauge::metric);
  EXPECT_GT(own.scale_sigma_share, 0);
  for (const FramePose& pose : own.poses) {
    // Along the line to the board's middle, which the scale moves a camera on.
    const Vector3d t = pose.camera_from_world.translation_m;
    const Vector3d along = t.normalized();
    const double sigma_m = std::sqrt(along.dot(pose.covariance.bottomRightCorner<3, 3>() * along));
    EXPECT_GT(sigma_m, own.scale_sigma_share * t.norm());
  }
  config.focal = SfmFocal::shared;
  EXPECT_LT(centre_rms_m(views, own), centre_rms_m(views, refined(views, config)));
}

TEST(SfmPoses, AnImageOfTooFewSightingsIsLostAlone) {
  SKIP_WITHOUT_CERES();
  PlantViews views = plant_views({}, 9);
  int left = 3;  // of the sightings of image 4
  for (SfmPoint& point : views.model.points) {
    std::erase_if(point.sightings,
                  [&](const SfmSighting& seen) { return seen.image == 4 && left-- <= 0; });
  }
  std::erase_if(views.model.points, [](const SfmPoint& p) { return p.sightings.size() < 2; });
  const SfmEstimate estimate = refined(views, {.scale = SfmScale::none});
  EXPECT_EQ(estimate.status, SfmStatus::partly_registered) << estimate.reason;
  EXPECT_THAT(estimate.lost, ElementsAre(14));
  EXPECT_EQ(estimate.poses[3].status, PoseStatus::ok);
  EXPECT_EQ(estimate.poses[4].status, PoseStatus::not_converged);
}

TEST(SfmPoses, ALensThatTheImagesLeaveOpenIsSaid) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = plant_views({.path = CameraPath::nadir_flat}, 6);
  SfmConfig config{.scale = SfmScale::none};
  config.adjust.focal_prior_share = config.adjust.centre_prior_px = config.adjust.distortion_prior =
      0;
  const SfmEstimate estimate = refined(views, config);
  EXPECT_EQ(estimate.status, SfmStatus::not_determined);
  EXPECT_FALSE(has_poses(estimate.status));
  EXPECT_THAT(estimate.not_determined, testing::Contains("fx_px"));
  EXPECT_THAT(estimate.reason, HasSubstr("fx_px"));
  for (const FramePose& pose : estimate.poses) EXPECT_NE(pose.status, PoseStatus::ok);
}

// What COLMAP made of the same sightings says nothing beside them.
TEST(SfmPoses, TheModelsOwnLensIsNoKnowledge) {
  SKIP_WITHOUT_CERES();
  const PlantViews views = plant_views({.path = CameraPath::nadir_flat}, 6);
  const auto estimate = [&](const std::optional<Camera>& lens) {
    return refine_sfm(views.model, views.frames, lens, views.corners, views.board,
                      {.scale = SfmScale::none});
  };
  EXPECT_EQ(estimate(views.lens).status, SfmStatus::ok);
  const SfmEstimate without = estimate(std::nullopt);
  EXPECT_EQ(without.status, SfmStatus::not_determined);
  EXPECT_THAT(without.not_determined, testing::Contains("fx_px"));
}

TEST(SfmPoses, AnImageThatNoTrackShowsHasNoResidual) {
  PlantViews views = plant_views({.images = 8, .points = 40, .noise_px = 0.3}, 3);
  for (SfmPoint& point : views.model.points)
    std::erase_if(point.sightings, [](const auto& seen) { return seen.image == 2; });
  const SfmEstimate estimate = refined(views, paper_sfm_config());
  ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
  EXPECT_TRUE(std::isnan(estimate.poses.at(2).rms_px));
  EXPECT_GT(estimate.poses.at(3).rms_px, 0);
}

TEST(SfmPoses, WithoutOurAdjustmentPosesAreThoseOfTheModel) {
  const PlantViews views = plant_views({.noise_px = 0, .corner_noise_px = 0}, 7);
  const SfmEstimate estimate = refined(views, paper_sfm_config());
  ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
  EXPECT_LT(centre_rms_m(views, estimate), 1e-9);
  EXPECT_NEAR(estimate.metres_per_unit, 1 / views.model_from_world.scale, 1e-9);
}

TEST(SfmPoses, WhatDoesNotFitTogetherIsRefused) {
  EXPECT_THROW(validate(SfmConfig{.adjust = {.zoom_share = 0.003}}), std::invalid_argument);
  const PlantViews views = plant_views({.images = 4, .points = 20}, 8);
  EXPECT_THROW(refined(views, {.scale = SfmScale::adjusted, .refine = false}),
               std::invalid_argument);
  EXPECT_THROW(refined(views, {.board_sigma_m = -1}), std::invalid_argument);
  Corners fewer = views.corners;
  fewer.pop_back();
  EXPECT_THROW(refine_sfm(views.model, views.frames, views.lens, fewer, views.board),
               std::invalid_argument);
  Capture capture;
  capture.frames.resize(2);
  EXPECT_THROW(estimate_poses_sfm(capture), std::invalid_argument);
}

TEST(SfmPoses, WithoutTheProgramTheStatusSaysSo) {
  Capture capture;
  for (int i = 0; i < 3; ++i) {
    Frame frame{.id = i};
    frame.sensors.push_back({.reported = plant_lens(), .color = Image<Rgb8>(1280, 720)});
    capture.frames.push_back(std::move(frame));
  }
  SfmConfig config;
  config.colmap.program = "/no/such/colmap";
  const SfmEstimate estimate = estimate_poses_sfm(capture, config);
  EXPECT_EQ(estimate.status, SfmStatus::not_built);
  EXPECT_THAT(estimate.reason, HasSubstr("COLMAP was not found"));
  EXPECT_THAT(estimate.lost, ElementsAre(0, 1, 2));
  EXPECT_EQ(estimate.poses.size(), 3U);
  EXPECT_EQ(estimate_poses_sfm(Capture{}, config).status, SfmStatus::too_few_images);
}

}  // namespace
}  // namespace cousin
