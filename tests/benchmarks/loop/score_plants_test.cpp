// Nodes and internodes of plants against the true ones.
#include "benchmarks/loop/score_plants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "benchmarks/loop/keypoint_noise.h"
#include "benchmarks/loop/score_boxes.h"
#include "perception/pipelines/maize.h"
#include "tests/benchmarks/loop/row_value.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kDepth_m = 0.9;

/// One plant of a root, three nodes and a tip, in both eyes of a pair at 0.9 m.
SimulatedRun one_plant() {
  SimulatedRun run;
  ObjectModel model;
  model.name = "plant";
  model.mesh.vertices_m = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}};
  model.mesh.triangles = {{0, 1, 2}};
  const std::vector<std::pair<std::string, double>> points = {
      {"root", 0}, {"node 5", 0.05}, {"node 6", 0.12}, {"node 7", 0.20}, {"tip 1", 0.3}};
  for (const auto& [name, up_m] : points) model.keypoints.push_back({name, {0, 0, up_m}});
  run.truth.scene.models = {model};
  Instance instance;
  instance.id = 4;
  instance.name = "maize 0";
  instance.category = "maize";
  instance.is_specimen = true;
  instance.traits = {{"height", "m", 0.3}};
  run.truth.scene.instances = {instance};
  const Camera camera{LensModel::pinhole, 1280, 720, 700, 700, 639.5, 359.5, {}, {}};
  run.truth.other_sensors = {{"rgb_right", {}, {}}};
  Frame frame;
  for (int eye = 0; eye < 2; ++eye) {
    TrueView view;
    view.camera = camera;
    TruthImages images;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector3d at(eye == 0 ? 0 : -0.12, 0.1 - points[k].second, kDepth_m);
      images.keypoints.push_back(
          {4, static_cast<int>(k), PointState::occluded, *project(camera, at), kDepth_m});
    }
    (eye == 0 ? run.truth.views : run.truth.other_sensors[0].views).push_back(view);
    (eye == 0 ? run.truth.images : run.truth.other_sensors[0].images).push_back(images);
    SensorReport report;
    report.name = eye == 0 ? "rgb" : "rgb_right";
    report.camera = camera;
    if (eye == 1) report.sensor_from_rig.translation_m = {-0.12, 0, 0};
    run.capture.rig.push_back(report);
    SensorFrame sensor;
    sensor.reported = camera;
    frame.sensors.push_back(sensor);
  }
  run.capture.frames = {frame};
  return run;
}

Estimate measured(const SimulatedRun& run, const MaizePipelineConfig& config = {},
                  const KeypointNoiseConfig& noise = {}) {
  const PipelineConfig pipeline(config);
  Stages stages = stages_for(pipeline, run.capture, 1);
  stages.keypoints = outside_stages(run, row_of(pipeline), noise, 1).keypoints;
  return run_pipeline(run.capture, pipeline, stages);
}

TEST(ScorePlants, TruthScoresPerfectlyAndNodesOutOfOrderChangeNothing) {
  const SimulatedRun run = one_plant();
  for (const MaizeMethod method :
       {MaizeMethod::ours, MaizeMethod::triangulation, MaizeMethod::paper}) {
    SCOPED_TRACE(to_string(method));
    const SeedsScores scores = score_plants(run.truth, measured(run, {.method = method}), {});
    EXPECT_EQ(value_of(scores.rows, "plants.found"), 1);
    EXPECT_EQ(value_of(scores.rows, "nodes.found"), 4);  // the tip is no node
    EXPECT_EQ(value_of(scores.rows, "nodes.spurious"), 0);
    EXPECT_EQ(value_of(scores.rows, "internodes.measured"), 3);
    EXPECT_EQ(value_of(scores.rows, "internodes.false"), 0);
    EXPECT_LT(value_of(scores.rows, "internode.median_error"), 1e-4);
    EXPECT_LT(value_of(scores.rows, "node.error_3d"), 1e-3);
  }
}

TEST(ScorePlants, AKnownErrorOfALengthScoresItself) {
  const SimulatedRun run = one_plant();
  Estimate estimate = measured(run);
  for (Trait& trait : estimate.traits.at(0).traits) {
    if (trait.name == "internode_2") trait.value = 0.07 + 0.005;
  }
  const SeedsScores scores = score_plants(run.truth, estimate, {});
  int seen = 0;
  for (const SpecimenRow& row : scores.specimens) {
    if (row.trait != "internode" || row.instance != 402) continue;
    ++seen;
    EXPECT_NEAR(row.truth, 0.07, 1e-12);
    EXPECT_NEAR(row.measured - row.truth, 0.005, 1e-12);
  }
  EXPECT_EQ(seen, 1);
}

TEST(ScorePlants, AMissedNodeMakesNoInternodeOfTwo) {
  const SimulatedRun run = one_plant();
  Estimate estimate = measured(run);
  const Eigen::Vector2d missed_px = run.truth.images[0].keypoints[2].pixel_px;  // node 6
  std::erase_if(estimate.keypoints.at(0).points,
                [&](const DetectedKeypoint& point) { return point.pixel_px == missed_px; });
  const PipelineConfig config(MaizePipelineConfig{});
  const Stages stages = stages_for(config, run.capture, 1);
  estimate.fits = stages.fits(run.capture, estimate);
  estimate.traits = stages.traits(run.capture, estimate);
  const SeedsScores scores = score_plants(run.truth, estimate, {});
  EXPECT_EQ(value_of(scores.rows, "nodes.missed"), 1);
  EXPECT_EQ(value_of(scores.rows, "internodes.measured"), 1);  // root to node 5
  EXPECT_EQ(value_of(scores.rows, "internodes.false"), 1);     // node 5 to node 7
}

TEST(ScorePlants, TraitsFromFilesSayByTheirNamesWhatTheyAreOf) {
  const SimulatedRun run = one_plant();
  Estimate estimate = measured(run);
  EXPECT_EQ(traits_of_estimate(estimate), TraitsOf::plants);
  // Without a height internode_1 and its like are all that is left.
  for (SpecimenTraits& plant : estimate.traits)
    std::erase_if(plant.traits, [](const Trait& trait) { return trait.name == "plant_height"; });
  EXPECT_EQ(traits_of_estimate(estimate), TraitsOf::plants);
  // Apples have fits too, and are of boxes.
  estimate.traits = {{.frame = 0}};
  estimate.traits[0].traits = {{"mass", "kg", 0.2, 0.01}};
  EXPECT_EQ(traits_of_estimate(estimate), TraitsOf::boxes);
  estimate.traits[0].frame = -1;
  EXPECT_EQ(traits_of_estimate(estimate), TraitsOf::specimens);
}

TEST(MaizePipeline, AFrameWithTooManyPointsIsNotSolvedAndSaysSo) {
  const SimulatedRun run = one_plant();
  Estimate estimate = measured(run);
  auto& points = estimate.keypoints.at(0).points;
  points.resize(300, points.back());
  const PipelineConfig config(MaizePipelineConfig{});
  const Fits fits = stages_for(config, run.capture, 1).fits(run.capture, estimate);
  ASSERT_EQ(fits.size(), 1U);
  EXPECT_NE(fits[0].status, FitStatus::ok);
  EXPECT_THAT(fits[0].reason, HasSubstr("most_points = 250"));
}

TEST(ScorePlants, AsksForKeypoints) {
  SimulatedRun run = one_plant();
  run.truth.images.clear();
  EXPECT_THAT([&] { (void)score_plants(run.truth, {}, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("keypoints")));
}

TEST(AlignedPoints, KeepTheirOrderAndEachIsOnce) {
  std::vector<TruePlant::Point> truth(3);
  for (int i = 0; i < 3; ++i) truth[static_cast<std::size_t>(i)].pixel_px = {100, 300.0 - 50 * i};
  EXPECT_EQ(aligned_points(truth, {{100, 298}, {101, 252}, {99, 199}}),
            (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(aligned_points(truth, {{100, 298}, {99, 199}}), (std::vector<int>{0, 2}));
  EXPECT_EQ(aligned_points(truth, {{100, 298}, {400, 250}, {99, 199}}),
            (std::vector<int>{0, -1, 2}));
}

TEST(DetectedKeypoints, ErrAsTheyAreAskedTo) {
  const SimulatedRun run = one_plant();
  const std::vector<std::string_view> words = {"root", "node"};
  const Keypoints truth = detected_keypoints(run, words, {}, 1);
  ASSERT_EQ(truth.size(), 2U);
  EXPECT_EQ(truth[0].points.size(), 4U);
  EXPECT_EQ(truth[0].instance, -1);
  EXPECT_EQ(truth[0].points[0].pixel_px, run.truth.images[0].keypoints[0].pixel_px);
  // Errors in common move both images' points alike, those of each image do not.
  double common = 0, own = 0, squares = 0;
  constexpr int kDraws = 500;
  for (int seed = 0; seed < kDraws; ++seed) {
    const auto off = [&](const KeypointNoiseConfig& noise, std::size_t eye) {
      const Keypoints found =
          detected_keypoints(run, words, noise, static_cast<std::uint64_t>(seed));
      return Eigen::Vector2d(found.at(eye).points[0].pixel_px - truth[eye].points[0].pixel_px);
    };
    common += (off({.common_sigma_px = 1}, 0) - off({.common_sigma_px = 1}, 1)).squaredNorm();
    own += (off({.sigma_px = 1}, 0) - off({.sigma_px = 1}, 1)).squaredNorm() / kDraws;
    squares += off({.sigma_px = 1}, 0).squaredNorm() / kDraws;
  }
  EXPECT_NEAR(common, 0, 1e-9);
  // 1000 squares of variance 1: a relative deviation of 4.5 %; allow four.
  EXPECT_NEAR(squares, 2, 0.36);
  EXPECT_NEAR(own, 4, 0.72);
  EXPECT_TRUE(detected_keypoints(run, words, {.missed = 1}, 1).empty());
}

TEST(MaizePipeline, SaysWhyAFrameIsNoPair) {
  SimulatedRun run = one_plant();
  run.capture.frames[0].sensors[1].time_s = 0.2;
  Estimate apart = measured(run);
  ASSERT_EQ(apart.traits.size(), 1U);
  EXPECT_EQ(apart.traits[0].status, TraitStatus::not_solved);
  EXPECT_THAT(apart.traits[0].reason, HasSubstr("0.200 s apart"));
  run = one_plant();
  run.capture.frames[0].sensors[0].color = Image<Rgb8>(640, 360);
  const Estimate small = measured(run);
  EXPECT_EQ(small.traits.at(0).status, TraitStatus::not_solved);
  EXPECT_THAT(small.traits[0].reason, HasSubstr("calibration is of 1280 x 720"));
  run = one_plant();
  run.capture.rig.pop_back();
  EXPECT_THAT([&] { measured(run); }, ThrowsMessage<std::invalid_argument>(HasSubstr("stereo")));
}

TEST(MaizePipeline, SwappedImagesHaveNoPlant) {
  SimulatedRun run = one_plant();
  std::swap(run.truth.images[0], run.truth.other_sensors[0].images[0]);
  for (const MaizeMethod method : {MaizeMethod::ours, MaizeMethod::paper}) {
    const Estimate estimate = measured(run, {.method = method});
    ASSERT_EQ(estimate.traits.size(), 1U);
    EXPECT_EQ(estimate.traits[0].status, TraitStatus::not_solved);
    EXPECT_THAT(estimate.traits[0].reason, HasSubstr("epipolar"));
  }
}

}  // namespace
}  // namespace cousin
