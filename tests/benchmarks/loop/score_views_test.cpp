#include "benchmarks/loop/score_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "perception/pipelines/views.h"
#include "sim/geometry/similarity.h"
#include "tests/benchmarks/loop/box_scene.h"
#include "tests/benchmarks/loop/row_value.h"

namespace cousin {
namespace {

std::vector<ScoreRow> score(const SceneTruth& truth, const Estimate& estimate,
                            PoseAlignment alignment = PoseAlignment::none) {
  return score_views(truth, estimate, alignment, !estimate.cloud.empty(),
                     {.suite = "t", .scene = "box", .method = "m"});
}

TEST(ScoreViews, ACloudIsAsFarOffAsItWasPut) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate = measured_box(truth, 0.0005F);
  estimate.poses[3].camera = reduced(estimate.poses[3].camera, 2);  // as `views` makes them
  const auto rows = score(truth, estimate);
  EXPECT_EQ(value_of(rows, "views.posed"), 1);
  EXPECT_NEAR(value_of(rows, "camera.focal_rms"), 0, 1e-12);
  EXPECT_NEAR(value_of(rows, "camera.centre_rms"), 0, 1e-9);
  // Undersides of bench and box, and the bench below the box, are seen by nobody.
  EXPECT_NEAR(value_of(rows, "surface.seen"), (1 - 0.04 + 0.2) / (2 + 0.08 + 0.24), 0.05);
  EXPECT_NEAR(value_of(rows, "specimens.surface.seen"), 5. / 6, 0.01);
  for (const std::string of : {"", "specimens."}) {
    EXPECT_NEAR(value_of(rows, of + "cloud_seen.accuracy_median"), 0.0005, 1e-6) << of;
    EXPECT_NEAR(value_of(rows, of + "cloud_seen.accuracy_mean"), 0.0005, 5e-5) << of;
    EXPECT_EQ(value_of(rows, of + "cloud_seen.precision_200um"), 0) << of;
    EXPECT_GT(value_of(rows, of + "cloud_seen.precision_1000um"), 0.99) << of;
    EXPECT_GT(value_of(rows, of + "cloud_seen.f1_5000um"), 0.95) << of;  // bench has sides
  }
  EXPECT_GT(value_of(rows, "specimens.cloud_seen.bias"), 0);
  EXPECT_LT(value_of(rows, "specimens.cloud_seen.points"), value_of(rows, "cloud_seen.points") / 2);
}

TEST(ScoreViews, WhatIsMissingCostsRecallAlone) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate = measured_box(truth, 0);
  std::erase_if(estimate.cloud,
                [](const CloudPoint& point) { return point.position_m.z() > 0.1F; });
  const auto rows = score(truth, estimate);
  EXPECT_GT(value_of(rows, "specimens.cloud_seen.precision_1000um"), 0.99);
  // Of five faces of one size, half of four is left.
  EXPECT_NEAR(value_of(rows, "specimens.cloud_seen.recall_5000um"), 0.4, 0.03);
  EXPECT_GT(value_of(rows, "cloud_seen.recall_5000um"), 0.85);
}

TEST(ScoreViews, FogFarFromSpecimensIsTheScenesAlone) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate = measured_box(truth, 0);
  const auto clear = score(truth, estimate);
  CloudPoint fog;
  for (int i = 0; i < 20000; ++i) {
    fog.position_m = {0, 0, 1 + 1e-5F * static_cast<float>(i)};
    estimate.cloud.push_back(fog);
  }
  const auto rows = score(truth, estimate);
  EXPECT_EQ(value_of(rows, "specimens.cloud_seen.accuracy_mean"),
            value_of(clear, "specimens.cloud_seen.accuracy_mean"));
  EXPECT_GT(value_of(rows, "cloud_seen.accuracy_mean"), 0.1);
  EXPECT_LT(value_of(rows, "cloud_seen.precision_5000um"), 0.8);
}

TEST(ScoreViews, AMeshIsScoredBesideTheCloud) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate;
  Surface surface;
  surface.status = SurfaceStatus::ok;
  surface.mesh = truth.scene.models[1].mesh;
  for (Eigen::Vector3d& vertex : surface.mesh.vertices_m) vertex.x() += 0.003;
  estimate.surfaces = {surface};
  const auto rows = score(truth, estimate);
  // Two of five faces that are seen stand 3 mm off, the others have slid along themselves.
  EXPECT_NEAR(value_of(rows, "specimens.mesh_seen.accuracy_mean"), 0.0012, 0.0002);
  EXPECT_NEAR(value_of(rows, "specimens.mesh_seen.precision_1000um"), 0.6, 0.03);
  EXPECT_GT(value_of(rows, "specimens.mesh_seen.f1_5000um"), 0.99);
  EXPECT_LT(value_of(rows, "mesh_seen.recall_5000um"), 0.3);  // there is no bench
}

TEST(ScoreViews, AForeignFrameAndUnitAreTakenOut) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate = measured_box(truth, 0.0005F);
  WorldSimilarity own_from_world;
  own_from_world.scale = 7;
  own_from_world.rotation = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized());
  own_from_world.shift_m = {3, -2, 1};
  for (FramePose& pose : estimate.poses)
    pose.camera_from_world = moved(pose.camera_from_world, own_from_world);
  for (CloudPoint& point : estimate.cloud)
    point.position_m = (own_from_world * point.position_m.cast<double>()).cast<float>();
  const auto raw = score(truth, estimate);
  EXPECT_GT(value_of(raw, "camera.centre_rms"), 1);
  const auto rows = score(truth, estimate, PoseAlignment::similarity);
  EXPECT_NEAR(value_of(rows, "alignment.scale"), 1. / 7, 1e-9);
  EXPECT_NEAR(value_of(rows, "camera.centre_rms"), 0, 1e-9);
  EXPECT_NEAR(value_of(rows, "specimens.cloud_seen.accuracy_median"), 0.0005, 2e-6);
}

TEST(ScoreViews, WithoutCamerasThereIsNoFrame) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate = measured_box(truth, 0);
  estimate.poses.resize(2);
  const auto rows = score(truth, estimate, PoseAlignment::similarity);
  EXPECT_TRUE(std::isnan(value_of(rows, "specimens.cloud_seen.recall_1000um")));
  for (const ScoreRow& row : rows) {
    const bool is_shape = row.metric.find("cloud") != std::string::npos;
    const bool is_place = row.metric.starts_with("camera.") && row.metric != "camera.focal_rms";
    if (is_shape || is_place || row.metric == "alignment.scale")
      EXPECT_EQ(row.status, ScoreStatus::not_solved) << row.metric;
  }
  EXPECT_NEAR(value_of(rows, "camera.focal_rms"), 0, 1e-12);
}

TEST(ScoreViews, EachNumberSaysHowManyPointsItIsOver) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate = measured_box(truth, 0.0005F);
  const std::size_t seen = estimate.cloud.size();
  for (int i = 0; i < 500; ++i) {  // on the underside, which nobody sees
    CloudPoint under;
    under.position_m = {0.0001F * static_cast<float>(i), 0, -0.03F};
    estimate.cloud.push_back(under);
  }
  const auto rows = score(truth, estimate);
  const auto n_of = [&](const std::string& metric) {
    for (const ScoreRow& row : rows) {
      if (row.metric == metric) return row.n;
    }
    return std::int64_t{-1};
  };
  EXPECT_EQ(value_of(rows, "cloud_seen.points"), static_cast<double>(seen + 500));
  EXPECT_LE(n_of("cloud_seen.accuracy_mean"), static_cast<std::int64_t>(seen));
  EXPECT_EQ(static_cast<double>(n_of("cloud_seen.recall_1000um")),
            value_of(rows, "surface.seen") * static_cast<double>(n_of("surface.seen")));
}

TEST(ScoreViews, AMeshWithoutAreaIsNoSurface) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate;
  Surface surface;
  surface.status = SurfaceStatus::ok;
  surface.mesh.vertices_m = {{0, 0, 0.1}, {0.01, 0, 0.1}, {0.02, 0, 0.1}};
  surface.mesh.triangles = {{0, 1, 2}};
  estimate.surfaces = {surface};
  EXPECT_EQ(value_of(score(truth, estimate), "specimens.mesh_seen.recall_5000um"), 0);
}

TEST(ScoreViews, WhatWasNotFoundIsRecallOfNothing) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate = measured_box(truth, 0);
  std::erase_if(estimate.cloud, [](const CloudPoint& p) {
    return std::abs(p.position_m.x()) < 0.2F && std::abs(p.position_m.y()) < 0.2F;
  });
  EXPECT_EQ(value_of(score(truth, estimate), "specimens.cloud_seen.recall_5000um"), 0);
  estimate.cloud.clear();
  estimate.surfaces = {{}};  // one that is empty
  const auto rows = score_views(truth, estimate, PoseAlignment::none, true, {});
  for (const std::string what : {"cloud_seen", "specimens.cloud_seen", "specimens.mesh_seen"})
    EXPECT_EQ(value_of(rows, what + ".recall_5000um"), 0) << what;
}

TEST(ScoreViews, ABenchIsNoPartOfASpecimensMesh) {
  const SceneTruth truth = box_on_bench();
  Estimate estimate;
  Surface surface;
  surface.status = SurfaceStatus::ok;
  surface.mesh = truth.scene.models[0].mesh;  // of two triangles a face
  estimate.surfaces = {surface};
  const auto rows = score(truth, estimate);
  EXPECT_EQ(value_of(rows, "specimens.mesh_seen.recall_5000um"), 0);
  EXPECT_GT(value_of(rows, "mesh_seen.recall_1000um"), 0.75);
}

TEST(ScoreViews, FocalLengthsAreOfTheSizeThatPhotographsHave) {
  SceneTruth truth = box_on_bench();
  for (TrueView& view : truth.views) {
    view.camera.width_px = 1920;
    view.camera.fx_px = 1500;
  }
  Estimate estimate = measured_box(truth, 0);
  estimate.cloud.clear();
  estimate.poses[1].camera.width_px = 1280;
  estimate.poses[1].camera.fx_px = 1000;
  estimate.poses[2].camera.width_px = 274;  // 1920 / 7, cut
  estimate.poses[2].camera.fx_px = 1500. / 7;
  estimate.poses[3].camera.width_px = 3840;
  estimate.poses[3].camera.fx_px = 3000;
  EXPECT_NEAR(value_of(score(truth, estimate), "camera.focal_rms"), 0, 1e-12);
}

}  // namespace
}  // namespace cousin
