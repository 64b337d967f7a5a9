// Traits of boxes against what is true under the middle of each.
#include "benchmarks/loop/score_boxes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "benchmarks/loop/box_truth.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Two specimens, ids 3 and 5, as squares in two views at 0.35 and 0.45 m; the second is seen in
/// the first view alone, with a hole in its middle.
SceneTruth two_squares() {
  SceneTruth truth;
  ObjectModel model;
  model.name = "square";
  model.mesh.vertices_m = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}};
  model.mesh.triangles = {{0, 1, 2}};
  truth.scene.models = {model};
  for (const int id : {3, 5}) {
    Instance instance;
    instance.id = id;
    instance.name = "fruit " + std::to_string(id);
    instance.category = "ripe";
    instance.is_specimen = true;
    truth.scene.instances.push_back(instance);
  }
  for (int frame = 0; frame < 2; ++frame) {
    TrueView view;
    view.frame = frame;
    view.camera = Camera{LensModel::pinhole, 40, 30, 50, 50, 19.5, 14.5, {}, {}};
    truth.views.push_back(view);
    TruthImages images;
    images.instance = Image<std::int32_t>(40, 30);
    images.depth_m = Image<float>(40, 30, 1.0F);
    const auto put = [&](int id, int x0, int y0, float depth_m) {
      for (int y = y0; y < y0 + 9; ++y) {
        for (int x = x0; x < x0 + 9; ++x) {
          images.instance(x, y) = id;
          images.depth_m(x, y) = depth_m;
        }
      }
    };
    put(3, 2, 3, 0.35F);
    if (frame == 0) {
      put(5, 20, 15, 0.45F);
      for (int y = 18; y < 21; ++y) {
        for (int x = 23; x < 26; ++x) images.instance(x, y) = 0;
      }
      images.instance(24, 17) = 5;
    }
    truth.images.push_back(images);
  }
  return truth;
}

/// Boxes of all that a sensor sees, each with its true point.
Estimate perfect(const SceneTruth& truth, std::size_t sensor = 0) {
  Estimate estimate;
  for (const TrueBox& box : true_boxes_of(truth, sensor)) {
    DetectedBox found;
    found.frame = box.frame;
    found.sensor = static_cast<int>(sensor);
    found.id = 100 + static_cast<int>(estimate.boxes.size());
    found.low_px = box.low_px;
    found.high_px = box.high_px;
    estimate.boxes.push_back(found);
    SpecimenTraits traits;
    traits.frame = box.frame;
    traits.instance = found.id;
    traits.status = TraitStatus::ok;
    traits.traits = {{"point_x", "m", box.point_m.x(), 0.001},
                     {"point_y", "m", box.point_m.y(), 0.001},
                     {"point_z", "m", box.point_m.z(), 0.001},
                     {"distance", "m", box.point_m.norm(), 0.001}};
    estimate.traits.push_back(traits);
  }
  return estimate;
}

double value_of(const SeedsScores& scores, const std::string& metric,
                const std::string& case_name = "run") {
  for (const ScoreRow& row : scores.rows) {
    if (row.metric == metric && row.case_name == case_name) return row.value;
  }
  return ScoreRow::kNone;
}

TEST(BoxTruth, ThePointIsUnderTheMiddleOrAtTheNearestPixelThatShowsIt) {
  const std::vector<TrueBox> boxes = true_boxes_of(two_squares());
  ASSERT_EQ(boxes.size(), 3U);
  EXPECT_EQ(boxes[0].specimen, 0);
  EXPECT_EQ(boxes[0].pixels, 81);
  EXPECT_EQ(boxes[0].low_px, Eigen::Vector2d(1.5, 2.5));
  EXPECT_EQ(boxes[0].high_px, Eigen::Vector2d(10.5, 11.5));
  EXPECT_NEAR(
      (boxes[0].point_m - Eigen::Vector3d(0.35 * (6 - 19.5) / 50, 0.35 * (7 - 14.5) / 50, 0.35))
          .norm(),
      0, 1e-7);
  // (24, 19) shows something else; (24, 17) is the nearest of the three that are two pixels off.
  EXPECT_EQ(boxes[1].specimen, 1);
  EXPECT_NEAR(boxes[1].point_m.x(), 0.45 * (24 - 19.5) / 50, 1e-7);
  EXPECT_NEAR(boxes[1].point_m.y(), 0.45 * (17 - 14.5) / 50, 1e-7);
  EXPECT_EQ(boxes[2].frame, 1);
}

TEST(BoxTruth, PlacesOfAFruitAreInTheCamera) {
  SceneTruth truth = two_squares();
  Instance& fruit = truth.scene.instances[0];
  fruit.world_from_object.translation_m = {0, 0.1, 0.4};
  fruit.world_from_object.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  truth.scene.models[0].keypoints = {
      {"tip", {0, 0, -0.02}}, {"calyx_centre", {0, 0, 0.02}}, {"cut_point", {0.001, 0, 0.035}}};
  for (TrueView& view : truth.views) view.camera_from_world.translation_m = {0.05, 0, 0};
  for (TrueView& view : truth.views) view.camera_from_world_end = view.camera_from_world;
  const TrueBox box = true_boxes_of(truth)[0];
  EXPECT_LT((box.centre_m - Eigen::Vector3d(0.05, 0.1, 0.4)).norm(), 1e-12);
  EXPECT_LT((box.axis - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12);
  EXPECT_LT((box.calyx_m - Eigen::Vector3d(0.05, 0.08, 0.4)).norm(), 1e-12);
  EXPECT_LT((box.cut_m - Eigen::Vector3d(0.051, 0.065, 0.4)).norm(), 1e-12);
  truth.scene.models[0].keypoints.clear();
  EXPECT_FALSE(true_boxes_of(truth)[0].cut_m.allFinite());
}

TEST(ScoreBoxes, PerfectPointsHaveNoErrorAndEachBoxItsRows) {
  const SceneTruth truth = two_squares();
  const SeedsScores scores = score_boxes(truth, perfect(truth), {});
  EXPECT_EQ(value_of(scores, "boxes.found"), 3);
  EXPECT_EQ(value_of(scores, "boxes.missed"), 0);
  EXPECT_EQ(value_of(scores, "boxes.spurious"), 0);
  EXPECT_NEAR(value_of(scores, "point.error_3d"), 0, 1e-12);
  EXPECT_NEAR(value_of(scores, "distance.rmse_by_distance", "0.3 to 0.4 m"), 0, 1e-12);
  ASSERT_EQ(scores.specimens.size(), 12U);
  EXPECT_EQ(scores.specimens[4].instance, 5);
  EXPECT_EQ(scores.specimens[4].frame, 0);
  EXPECT_EQ(scores.specimens[4].cultivar, "ripe");
}

TEST(ScoreBoxes, EachSensorThatHasBoxesIsScoredByItsOwnTruth) {
  SceneTruth truth = two_squares();
  const Estimate first = perfect(truth);
  const std::size_t rows_of_first = score_boxes(truth, first, {}).rows.size();
  SensorViews right{"right", truth.views, truth.images};
  std::swap(right.images[0], right.images[1]);  // what it sees differs
  truth.other_sensors = {{"depth", truth.views}, right};
  // No box is of the second camera: nobody looked there.
  EXPECT_EQ(score_boxes(truth, first, {}).rows.size(), rows_of_first);
  Estimate both = first;
  const Estimate second = perfect(truth, 2);
  for (DetectedBox box : second.boxes) {
    box.id += 1000;
    both.boxes.push_back(box);
  }
  for (SpecimenTraits traits : second.traits) {
    traits.instance += 1000;
    both.traits.push_back(traits);
  }
  both.boxes.pop_back();
  both.traits.back().traits[0].value += 0.01;  // of a box that is not there
  const SeedsScores scores = score_boxes(truth, both, {});
  EXPECT_EQ(value_of(scores, "boxes.found"), 3);
  EXPECT_EQ(value_of(scores, "boxes.spurious"), 0);
  EXPECT_EQ(value_of(scores, "boxes.found", "right, run"), 2);
  EXPECT_EQ(value_of(scores, "boxes.missed", "right, run"), 1);
  EXPECT_NEAR(value_of(scores, "distance.rmse_by_distance", "right, 0.3 to 0.4 m"), 0, 1e-12);
  EXPECT_EQ(scores.specimens.size(), 12U);
}

TEST(ScoreBoxes, ErrorsMissedAndSpuriousBoxesAreCounted) {
  const SceneTruth truth = two_squares();
  Estimate estimate = perfect(truth);
  estimate.traits[0].traits[2].value += 0.003;          // z of the first
  estimate.boxes[1].low_px.x() -= 20;                   // overlaps its fruit by less than half
  estimate.traits[2].status = TraitStatus::not_solved;  // matched and not measured
  const SeedsScores scores = score_boxes(truth, estimate, {});
  EXPECT_EQ(value_of(scores, "boxes.found"), 2);
  EXPECT_EQ(value_of(scores, "boxes.missed"), 1);
  EXPECT_EQ(value_of(scores, "boxes.spurious"), 1);
  EXPECT_EQ(value_of(scores, "boxes.measured"), 1);
  EXPECT_NEAR(value_of(scores, "point.error_3d"), 0.003, 1e-12);
  EXPECT_NEAR(value_of(scores, "point_z.mae_by_distance", "0.3 to 0.4 m"), 0.003, 1e-12);
  int solved = 0;
  for (const SpecimenRow& row : scores.specimens) solved += row.status == ScoreStatus::ok;
  EXPECT_EQ(solved, 4);
}

/// Each specimen weighs 0.2 kg; in the first view 3 is free and 5 is half hidden.
SceneTruth two_weights() {
  SceneTruth truth = two_squares();
  for (Instance& instance : truth.scene.instances) instance.traits = {{"mass", "kg", 0.2}};
  for (TruthImages& images : truth.images) {
    InstanceVisibility first{3, 81, 81, 1, 2, 3, 9, 9, 2, 3, 9, 9};
    InstanceVisibility second{5, 160, 80, 0.5, 20, 15, 9, 9, 20, 15, 9, 9};
    images.visibility = {first, second};
  }
  return truth;
}

TEST(ScoreBoxes, SizesAreThoseOfTheSpecimenByHowMuchIsHidden) {
  const SceneTruth truth = two_weights();
  Estimate estimate = perfect(truth);
  for (SpecimenTraits& traits : estimate.traits) traits.traits = {{"mass", "kg", 0.21, 0.01}};
  estimate.traits[1].traits[0].value = 0.17;
  const SeedsScores scores = score_boxes(truth, estimate, {}, {});
  EXPECT_EQ(value_of(scores, "boxes.measured"), 3);
  EXPECT_EQ(value_of(scores, "boxes.there", "unoccluded"), 2);
  EXPECT_NEAR(value_of(scores, "mass.mape", "unoccluded"), 0.05, 1e-9);
  EXPECT_NEAR(value_of(scores, "mass.mape", "hidden 40 to 70 %"), 0.15, 1e-9);
  EXPECT_EQ(value_of(scores, "mass.coverage_95", "hidden 40 to 70 %"), 0);
  ASSERT_EQ(scores.specimens.size(), 3U);
  EXPECT_EQ(scores.specimens[1].cultivar, "ripe, hidden 40 to 70 %");
  EXPECT_EQ(scores.specimens[1].unit, "kg");
  static constexpr std::string_view kArea[] = {"area"};
  EXPECT_THAT([&] { score_boxes(truth, estimate, {}, kArea); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("\"area\" is not one of fruit 3")));
}

TEST(ScoreBoxes, PointsAndPlacesAreScoredSideBySide) {
  SceneTruth truth = two_weights();
  truth.scene.models[0].keypoints = {{"cut_point", {0, 0, 0.03}}};
  Estimate estimate = perfect(truth);
  const std::vector<TrueBox> boxes = true_boxes_of(truth);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (int k = 0; k < 3; ++k)
      estimate.traits[i].traits.push_back(
          {std::string("cut_") + "xyz"[k], "m", boxes[i].cut_m[k] + (k == 2 ? 0.004 : 0), 0.004});
  }
  static constexpr std::string_view kWanted[] = {"point_x", "point_y", "point_z", "distance",
                                                 "cut_x",   "cut_y",   "cut_z",   "mass"};
  const SeedsScores scores = score_boxes(truth, estimate, {}, kWanted);
  EXPECT_EQ(value_of(scores, "point.error_3d"), 0);
  EXPECT_EQ(value_of(scores, "boxes.measured"), 3);
  EXPECT_NEAR(value_of(scores, "cut.error_3d", "unoccluded"), 0.004, 1e-12);
  // Pickers ask for half of a fruit in sight. No box has a mass: it is not scored.
  EXPECT_NEAR(value_of(scores, "cut.error_3d", "hidden above 50 %"), 0.004, 1e-12);
  EXPECT_TRUE(std::isnan(value_of(scores, "mass.measured", "unoccluded")));
  ASSERT_EQ(scores.specimens.size(), 3U * 7U);
  EXPECT_EQ(scores.specimens[0].cultivar, "ripe");
  EXPECT_EQ(scores.specimens[4].cultivar, "ripe, unoccluded");
}

TEST(ScoreBoxes, WhatTheImageCutsIsACaseOfItsOwn) {
  SceneTruth truth = two_weights();
  truth.images[0].visibility[0].box_x = 0;
  const std::vector<TrueBox> boxes = true_boxes_of(truth);
  EXPECT_EQ(box_case(boxes[0], 3, truth.images[0]), "cut by the image");
  EXPECT_EQ(box_case(boxes[1], 5, truth.images[0]), "hidden 40 to 70 %");
  TrueBox far = boxes[1];
  far.point_m.z() = 1.2;
  EXPECT_EQ(box_case(far, 5, truth.images[0]), "farther than 1 m");
  far.point_m.z() = 0.2;
  EXPECT_EQ(box_case(far, 5, truth.images[0]), "nearer than 0.3 m");
  EXPECT_EQ(box_case(far, 99, truth.images[0]), "");
}

TEST(ScoreBoxes, WithoutTrueImagesAndInOtherUnitsItIsRefused) {
  SceneTruth truth = two_squares();
  Estimate estimate = perfect(truth);
  estimate.traits[0].traits[0].unit = "rad";
  EXPECT_THAT([&] { score_boxes(truth, estimate, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("box 100: point_x is in rad")));
  truth.images.clear();
  EXPECT_THAT([&] { score_boxes(truth, estimate, {}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("--truth depth,instance")));
}

}  // namespace
}  // namespace cousin
