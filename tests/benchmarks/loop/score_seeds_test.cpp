#include "benchmarks/loop/score_seeds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "benchmarks/loop/attribution.h"
#include "benchmarks/loop/truth_stages.h"
#include "sim/geometry/measure.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

/// A closed box of the given size about the origin.
Mesh box_mesh(const Eigen::Vector3d& size) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices_m.emplace_back((i & 1 ? 0.5 : -0.5) * size.x(), (i & 2 ? 0.5 : -0.5) * size.y(),
                                 (i & 4 ? 0.5 : -0.5) * size.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

SceneTruth three_boxes() {
  SceneTruth truth;
  truth.scene.materials.emplace_back();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d size(0.010 + 0.001 * i, 0.006, 0.004 - 0.0002 * i);
    ObjectModel model;
    model.mesh = box_mesh(size);
    truth.scene.models.push_back(model);
    Instance seed;
    seed.id = 10 + i;
    seed.category = "zhengdan958";
    seed.is_specimen = true;
    seed.model = i;
    seed.world_from_object.translation_m = {0.02 * i, 0, 0.002};
    seed.traits = {{"length", "m", size.x()},
                   {"width", "m", size.y()},
                   {"height", "m", size.z()},
                   {"volume", "m3", size.prod()},
                   {"mass", "kg", 1e-4}};
    truth.scene.instances.push_back(seed);
  }
  return truth;
}

/// What a perfect pipeline hands over, moved and scaled as asked.
Estimate estimate_of(const SceneTruth& truth, double offset_m, double sigma_m) {
  Estimate estimate;
  for (const Instance* seed : specimens_of(truth.scene)) {
    SpecimenTraits traits;
    traits.instance = static_cast<int>(estimate.traits.size());
    traits.status = TraitStatus::ok;
    traits.centroid_in_world_m = seed->world_from_object.translation_m;
    for (const TrueTrait& t : seed->traits) {
      traits.traits.push_back(
          {t.name, t.unit, t.unit == "m" ? t.value + offset_m : t.value, sigma_m});
    }
    estimate.traits.push_back(traits);
  }
  return estimate;
}

const ScoreRow& row_of(const std::vector<ScoreRow>& rows, const std::string& case_name,
                       const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.case_name == case_name && row.metric == metric) return row;
  }
  throw std::runtime_error("no row " + case_name + " " + metric);
}

TEST(ScoreSeeds, HollowsAreWhatTheHullAddsToTheTruth) {
  SceneTruth truth = three_boxes();
  auto none = score_run(truth, estimate_of(truth, 0, 1e-5), {});
  EXPECT_NEAR(row_of(none.rows, "run", "true_hull.volume.excess").value, 0, 1e-12);
  // The top of one box goes down to its middle: a pyramid of a sixth of the volume is missing.
  Mesh& mesh = truth.scene.models[0].mesh;
  mesh.vertices_m.emplace_back(Eigen::Vector3d::Zero());
  mesh.triangles[2] = {4, 5, 8};
  mesh.triangles[3] = {5, 7, 8};
  mesh.triangles.push_back({7, 6, 8});
  mesh.triangles.push_back({6, 4, 8});
  const auto hollow = score_run(truth, estimate_of(truth, 0, 1e-5), {});
  EXPECT_NEAR(row_of(hollow.rows, "run", "true_hull.volume.excess").value, (6.0 / 5 - 1) / 3,
              1e-12);
  EXPECT_LT(row_of(hollow.rows, "run", "true_hull.area.excess").value, 0);
}

TEST(ScoreSeeds, TruthScoresPerfectly) {
  const SceneTruth truth = three_boxes();
  const SeedsScores scores = score_run(truth, estimate_of(truth, 0, 1e-5), {});
  EXPECT_EQ(row_of(scores.rows, "run", "specimens.found").value, 3);
  EXPECT_EQ(row_of(scores.rows, "run", "specimens.missed").value, 0);
  EXPECT_EQ(scores.specimens.size(), 12U);  // mass is no measured trait
  const auto rows = pooled_rows(scores.specimens, {});
  EXPECT_NEAR(row_of(rows, "zhengdan958", "length.rmse").value, 0, 1e-15);
  EXPECT_NEAR(row_of(rows, "maize", "length.slope").value, 1, 1e-9);
}

TEST(ScoreSeeds, AKnownOffsetScoresItselfAndItsCoverage) {
  const SceneTruth truth = three_boxes();
  constexpr double kOffset_m = 5e-5;
  const SeedsScores scores = score_run(truth, estimate_of(truth, kOffset_m, kOffset_m / 1.5), {});
  const auto rows = pooled_rows(scores.specimens, {});
  EXPECT_NEAR(row_of(rows, "zhengdan958", "length.rmse").value, kOffset_m, 1e-12);
  EXPECT_NEAR(row_of(rows, "zhengdan958", "length.bias").value, kOffset_m, 1e-12);
  EXPECT_EQ(row_of(rows, "zhengdan958", "length.coverage_68").value, 0);  // 1.5 sigma off
  EXPECT_EQ(row_of(rows, "zhengdan958", "length.coverage_95").value, 1);
}

TEST(ScoreSeeds, AMissedSeedIsNotSolvedAndAStrangerIsSpurious) {
  const SceneTruth truth = three_boxes();
  Estimate estimate = estimate_of(truth, 0, 1e-5);
  estimate.traits[1].centroid_in_world_m += Eigen::Vector3d(0, 0.02, 0);
  const SeedsScores scores = score_run(truth, estimate, {});
  EXPECT_EQ(row_of(scores.rows, "run", "specimens.missed").value, 1);
  EXPECT_EQ(row_of(scores.rows, "run", "specimens.spurious").value, 1);
  const auto rows = pooled_rows(scores.specimens, {});
  EXPECT_NEAR(row_of(rows, "zhengdan958", "length.solved").value, 2.0 / 3, 1e-12);
}

TEST(ScoreSeeds, ALargeSpecimenIsFoundByItsUpperSurfaceAlone) {
  SceneTruth truth = three_boxes();
  truth.scene.instances.resize(1);
  Estimate estimate = estimate_of(truth, 0, 1e-5);
  estimate.traits[0].centroid_in_world_m.z() += 0.0055;  // the centroid of a half sphere of 22 mm
  EXPECT_EQ(row_of(score_run(truth, estimate, {}).rows, "run", "specimens.found").value, 0);
  for (TrueTrait& trait : truth.scene.instances[0].traits) {
    if (trait.unit == "m") trait.value = 0.022;
  }
  EXPECT_EQ(row_of(score_run(truth, estimate, {}).rows, "run", "specimens.found").value, 1);
  EXPECT_EQ(row_of(score_run(truth, estimate, {}).rows, "run", "specimens.spurious").value, 0);
}

TEST(ScoreSeeds, WhatAnEstimateCouldNotMeasureIsUnsolvedWhereverItStands) {
  const SceneTruth truth = three_boxes();
  Estimate estimate = estimate_of(truth, 0, 1e-5);
  for (const std::size_t i : {0, 1}) estimate.traits[i].status = TraitStatus::not_solved;
  estimate.traits[1].centroid_in_world_m += Eigen::Vector3d(0, 0.02, 0);
  const SeedsScores scores = score_run(truth, estimate, {});
  EXPECT_EQ(row_of(scores.rows, "run", "specimens.found").value, 2);
  EXPECT_EQ(row_of(scores.rows, "run", "specimens.unsolved").value, 2);
  EXPECT_EQ(row_of(scores.rows, "run", "specimens.spurious").value, 0);
  const auto rows = pooled_rows(scores.specimens, {});
  EXPECT_NEAR(row_of(rows, "zhengdan958", "length.solved").value, 1.0 / 3, 1e-12);
}

TEST(ScoreSeeds, TheSphereIsNotPooledWithSeeds) {
  const SceneTruth truth = three_boxes();
  const auto seeds = score_run(truth, estimate_of(truth, 1e-5, 1e-5), {}).specimens;
  auto specimens = seeds;
  for (SpecimenRow row : seeds) {
    row.cultivar = "jimai22";
    specimens.push_back(row);
    row.cultivar = "sphere";
    row.measured += 1;
    specimens.push_back(row);
  }
  const auto rows = pooled_rows(specimens, {});
  EXPECT_NEAR(row_of(rows, "all", "length.rmse").value, 1e-5, 1e-12);
  EXPECT_GT(row_of(rows, "sphere", "length.rmse").value, 0.5);
}

TEST(ScoreSeeds, RatioOfTwoMethodsIsTheirOffsetsRatio) {
  const SceneTruth truth = three_boxes();
  SeedsScoreLabels labels;
  auto all = score_run(truth, estimate_of(truth, 2e-5, 1e-5), labels).specimens;
  labels.method = "paper";
  const auto paper = score_run(truth, estimate_of(truth, -8e-5, 1e-5), labels).specimens;
  all.insert(all.end(), paper.begin(), paper.end());
  const auto rows = paired_rows(all, "ours", "paper", {});
  EXPECT_NEAR(row_of(rows, "maize", "length.rmse_ratio").value, 0.25, 1e-9);
  // Of errors as shares of the sizes: all 6e-5 m apart, over each seed's own length.
  double share = 0;
  int count = 0;
  for (const SpecimenRow& specimen : paper) {
    if (specimen.trait != "length" || specimen.status != ScoreStatus::ok) continue;
    share += 6e-5 / specimen.truth;
    ++count;
  }
  EXPECT_NEAR(row_of(rows, "maize", "length.relative_difference").value, -share / count, 1e-9);
}

TEST(ScoreSeeds, PosesAreMatchedByTheirFrames) {
  SceneTruth truth = three_boxes();
  Estimate estimate;
  for (int i = 0; i < 12; ++i) {
    TrueView view;
    view.frame = i;
    view.camera = {LensModel::pinhole, 64, 48, 60, 60, 31.5, 23.5};
    view.camera_from_world =
        view.camera_from_world_end = {Eigen::Quaterniond::Identity(), {0.1 * i, 0, 1}};
    truth.views.push_back(view);
    estimate.poses.push_back({.frame = i,
                              .status = PoseStatus::ok,
                              .camera_from_world = view.camera_from_world,
                              .camera = view.camera});
  }
  const auto scored = [&](const char* metric) {
    for (const ScoreRow& row : score_run(truth, estimate, {}).rows) {
      if (row.metric == metric) return row.value;
    }
    return std::nan("");
  };
  std::rotate(estimate.poses.begin(), estimate.poses.begin() + 5, estimate.poses.end());
  EXPECT_LT(scored("camera.centre_rms"), 1e-12);
  estimate.poses.pop_back();
  EXPECT_LT(scored("camera.centre_rms"), 1e-12);
  EXPECT_NEAR(scored("views.posed"), 11.0 / 12, 1e-12);
  estimate.poses.back().frame = estimate.poses.front().frame;
  EXPECT_THROW(score_run(truth, estimate, {}), std::invalid_argument);
  estimate.poses.back().frame = 12;
  EXPECT_THROW(score_run(truth, estimate, {}), std::invalid_argument);
}

// A cloud of all that cameras above see is complete, though nothing of it is on the undersides.
TEST(ScoreSeeds, CloudsAreScoredAgainstWhatCouldBeSeenToo) {
  SceneTruth truth = three_boxes();
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  for (int i = 0; i < 3; ++i) {
    TrueView view;
    view.frame = i;
    view.camera = {LensModel::pinhole, 640, 480, 600, 600, 319.5, 239.5};
    view.camera_from_world =
        view.camera_from_world_end = {down, down * -Eigen::Vector3d(0.02 * i, 0, 0.3)};
    truth.views.push_back(view);
  }
  Estimate estimate;
  for (const Instance* seed : specimens_of(truth.scene)) {
    const Eigen::Vector3d at_m = seed->world_from_object.translation_m;
    const double half_x_m = 0.5 * seed->traits[0].value, half_z_m = 0.5 * seed->traits[2].value;
    for (int k = 0; k < 2500; ++k) {
      CloudPoint point;
      const Eigen::Vector3d on_top(half_x_m * (k % 50 - 24.5) / 25, 0.003 * (k / 50 - 24.5) / 25,
                                   half_z_m);
      point.position_m = (at_m + on_top).cast<float>();
      point.normal = Eigen::Vector3f(0, k < 1500 ? 0 : 1, 1).normalized();  // 45 degrees off
      estimate.clusters.cloud.push_back(point);
      estimate.clusters.instance.push_back(0);
    }
  }
  const std::vector<ScoreRow> rows = score_run(truth, estimate, {}).rows;
  const auto value = [&](const std::string& metric) {
    for (const ScoreRow& row : rows) {
      if (row.metric == metric) return row.value;
    }
    return std::nan("");
  };
  EXPECT_LT(value("cloud_seen.accuracy_mean"), 1e-6);
  EXPECT_LT(value("cloud.normal_median"), 1e-6);
  EXPECT_NEAR(value("cloud.normal_p95"), 0.25 * std::numbers::pi, 1e-5);
  EXPECT_EQ(value("cloud.normals"), 1);
  EXPECT_GT(value("surface.seen"), 0.25);  // tops, and the sides that look at the middle
  EXPECT_LT(value("surface.seen"), 0.6);
  EXPECT_LT(value("cloud.recall_500um"), 0.5);
  EXPECT_GT(value("cloud_seen.recall_500um"), 1.3 * value("cloud.recall_500um"));
  EXPECT_LT(value("cloud_seen.completeness_mean"), 0.6 * value("cloud.completeness_mean"));
  EXPECT_NEAR(value("cloud_seen.chamfer"),
              0.5 * (value("cloud_seen.accuracy_mean") + value("cloud_seen.completeness_mean")),
              1e-12);
}

TEST(Attribution, StepsAreComparedOverTheSpecimensThatAllSolve) {
  const SceneTruth truth = three_boxes();
  Estimate hard = estimate_of(truth, 1e-4, 1e-5), easy = hard;
  hard.traits.back().status = TraitStatus::not_solved;
  for (Trait& trait : easy.traits.back().traits) trait.value += 1;  // the third seed is far off
  const std::vector<SeamStep> steps = {{"none", score_run(truth, hard, {}), 1},
                                       {"corners", score_run(truth, easy, {}), 1},
                                       {"poses", score_run(truth, Estimate{}, {}), 1}};
  std::map<std::string, const ScoreRow*> rmse;
  const std::vector<ScoreRow> rows = attribution_rows(steps, kSeedTraits, {});
  for (const ScoreRow& row : rows) {
    if (row.metric == "length.rmse") rmse[row.case_name] = &row;
  }
  ASSERT_EQ(rmse.size(), 3u);
  EXPECT_EQ(rmse["truth up to none"]->n, 2);
  EXPECT_EQ(rmse["truth up to corners"]->n, 2);
  EXPECT_NEAR(rmse["truth up to corners"]->value, 1e-4, 1e-12);
  EXPECT_EQ(rmse["truth up to poses"]->status, ScoreStatus::not_solved);
}

TEST(Gate, HoldsBreaksAndRefusesNonsense) {
  ScoreRow row;
  row.metric = "length.rmse";
  row.value = 1e-4;
  const std::vector<ScoreRow> rows = {row};
  EXPECT_TRUE(broken(parse_gate("length.rmse<=0.0002"), rows).empty());
  EXPECT_EQ(broken(parse_gate("length.rmse<=0.00005"), rows).size(), 1U);
  EXPECT_TRUE(broken(parse_gate("length.rmse>=0.00005"), rows).empty());
  EXPECT_EQ(broken(parse_gate("no.such>=0"), rows).size(), 1U);
  for (const char* text : {"length", "length=1", "<=1", "length<=abc", "length<=1x"}) {
    EXPECT_THROW(parse_gate(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace cousin
