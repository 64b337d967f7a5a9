// Somebody's boxes against a dataset: what is right, missed, another class, nothing.
#include "benchmarks/tools/detections/score_detections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/tools/detections/detections_report.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/small_dataset.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::HasSubstr;

/// The message of wrong usage; "" if there is none.
template <class Work>
std::string refusal_of(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// Two scenes of two pictures, each of an "apple" and a "zea" (small_dataset.h).
class ScoreDetections : public testing::Test {
 protected:
  ScoreDetections() {
    write_small_dataset(folder_.path(), {.scenes = 2});
    truth_ = read_true_pictures(folder_.path());
  }
  /// Every object as it is, with a score.
  FoundFile perfect(double score = 0.9) const {
    FoundFile found;
    found.has_masks = true;
    for (std::size_t i = 0; i < truth_.pictures.size(); ++i) {
      for (const TrueObject& object : truth_.pictures[i].objects) {
        found.of_picture[i].push_back(
            {object.category == "apple" ? 1 : 2, score, object.box, object.mask});
        ++found.count;
      }
    }
    return found;
  }
  DetectionScores score(const FoundFile& found, const DetectionScoreConfig& config = {}) const {
    return score_detections(truth_, found, config, {});
  }
  static double value(const DetectionScores& scores, const std::string& case_name,
                      const std::string& metric) {
    for (const ScoreRow& row : scores.rows) {
      if (row.case_name == case_name && row.metric == metric) return row.value;
    }
    ADD_FAILURE() << "no row " << case_name << " " << metric;
    return std::nan("");
  }
  TemporaryFolder folder_;
  TruePictures truth_;
};

TEST_F(ScoreDetections, TheDatasetHasItsPicturesObjectsAndNames) {
  ASSERT_EQ(truth_.pictures.size(), 4U);
  EXPECT_THAT(truth_.categories, testing::ElementsAre("apple", "zea"));
  ASSERT_EQ(truth_.pictures[1].objects.size(), 2U);
  EXPECT_EQ(truth_.pictures[1].objects[0].visible_fraction, 0.5);
  EXPECT_EQ(truth_.pictures[1].objects[0].box.x, 9);
  EXPECT_EQ(truth_.names.at("000001_000000").place, 2U);
  EXPECT_EQ(truth_.names.at("1000001").place, 3U);
  EXPECT_FALSE(truth_.names.contains("000000")) << "two scenes have such a frame";
}

TEST_F(ScoreDetections, ClassesAreOfALabelIfAsked) {
  const TemporaryFolder labelled;
  write_small_dataset(labelled.path(), {.has_labels = true});
  const TruePictures own = read_true_pictures(labelled.path());
  EXPECT_THAT(own.categories, testing::ElementsAre("apple", "zea"));
  const TruePictures maturity = read_true_pictures(labelled.path(), "maturity");
  EXPECT_THAT(maturity.categories, testing::ElementsAre("high", "low"));
  EXPECT_EQ(maturity.pictures[0].objects[0].category, "low");
  FoundFile found;
  found.of_picture[0].push_back({2, 0.9, maturity.pictures[0].objects[0].box, {}});
  const DetectionScores scores = score_detections(maturity, found, {}, {});
  EXPECT_EQ(value(scores, "is low, found as low", "confusion"), 1);
  const auto recall_by_maturity = [&](const std::string& maturity_name) {
    for (const ScoreRow& row : scores.rows) {
      if (row.metric == "recall.maturity" && row.case_name.ends_with(maturity_name))
        return row.value;
    }
    return -1.0;
  };
  EXPECT_EQ(recall_by_maturity("low"), 0.5);
  EXPECT_EQ(recall_by_maturity("high"), 0);
}

TEST_F(ScoreDetections, PicturesOfAnotherSensorCountIfTheFileNamesOne) {
  const TemporaryFolder stereo;
  write_small_dataset(stereo.path(), {.has_right = true});
  TruePictures truth = read_true_pictures(stereo.path());
  ASSERT_EQ(truth.pictures.size(), 4U);
  EXPECT_EQ(truth.pictures[2].name, "000000_000000_right");
  EXPECT_EQ(truth.pictures[2].objects[0].box.x, 10);
  EXPECT_EQ(truth.names.at("000001_right").place, 3U);
  EXPECT_EQ(truth.names.at("1000000000001").place, 3U);
  FoundFile found;
  found.of_picture[3].push_back({1, 0.9, truth.pictures[3].objects[0].box, {}});
  EXPECT_EQ(leave_out_sensors(truth, found), 0U);
  EXPECT_EQ(value(score_detections(truth, found, {}, {}), "all classes", "recall"), 1.0 / 8);
  found.of_picture.clear();
  found.of_picture[1].push_back({1, 0.9, truth.pictures[1].objects[0].box, {}});
  EXPECT_EQ(leave_out_sensors(truth, found), 2U);
  EXPECT_EQ(truth.pictures.size(), 2U);
  EXPECT_EQ(value(score_detections(truth, found, {}, {}), "all classes", "recall"), 1.0 / 4);
}

TEST_F(ScoreDetections, WhatIsAllRightScoresOne) {
  const DetectionScores scores = score(perfect());
  for (const char* metric : {"AP50", "AP75", "AP50_95", "mask_AP50", "mask_AP50_95"})
    EXPECT_EQ(value(scores, "mean of classes", metric), 1) << metric;
  for (const char* metric : {"precision", "recall", "f1", "f1_best"})
    EXPECT_EQ(value(scores, "all classes", metric), 1) << metric;
  EXPECT_EQ(value(scores, "visible 0.5 to 0.75", "recall.visible"), 1);
  EXPECT_EQ(value(scores, "is apple, found as apple", "confusion"), 4);
  EXPECT_EQ(scores.outcomes[0].errors(), 0U);
}

TEST_F(ScoreDetections, MissedWrongAndOtherClassesAreCounted) {
  FoundFile found = perfect();
  found.of_picture[0][0].score = 0.1;                          // an apple below the confidence
  found.of_picture[1][1].category = 1;                         // a zea as an apple
  found.of_picture[2].push_back({1, 0.8, {30, 2, 5, 5}, {}});  // nothing is there
  const DetectionScores scores = score(found);
  EXPECT_EQ(value(scores, "is apple, found as nothing", "confusion"), 1);
  EXPECT_EQ(value(scores, "is zea, found as apple", "confusion"), 1);
  EXPECT_EQ(value(scores, "is nothing, found as apple", "confusion"), 1);
  EXPECT_NEAR(value(scores, "all classes", "recall"), 6.0 / 8, 1e-12);
  EXPECT_NEAR(value(scores, "all classes", "precision"), 6.0 / 8, 1e-12);
  EXPECT_EQ(scores.outcomes[0].errors(), 1U);
  EXPECT_EQ(scores.outcomes[1].errors(), 1U);  // found, as another class
  EXPECT_EQ(scores.outcomes[2].errors(), 1U);
  // Apples: scores .9 .9 .9 right, .9 (a zea) and .8 wrong, .1 right: by hand.
  const double apples = value(scores, "class apple", "AP50.of_class");
  EXPECT_GT(apples, 0.75);
  EXPECT_LT(apples, 1);
}

TEST_F(ScoreDetections, OnlyAveragePrecisionStopsAtAHundredDetectionsOfAPicture) {
  FoundFile found;
  for (int i = 0; i < 150; ++i) found.of_picture[0].push_back({1, 0.9, {30, 2, 2, 2}, {}});
  found.of_picture[0].push_back({1, 0.5, truth_.pictures[0].objects[0].box, {}});
  const DetectionScores scores = score(found);
  EXPECT_EQ(value(scores, "is nothing, found as apple", "confusion"), 150);
  EXPECT_EQ(value(scores, "is apple, found as apple", "confusion"), 1);
  EXPECT_EQ(value(scores, "class apple", "AP50.of_class"), 0);
}

TEST_F(ScoreDetections, OverlapsAreBoundedByTheMemoryLimit) {
  const FoundFile found = perfect();
  set_memory_limit(100);
  EXPECT_THAT(error_of([&] { score(found); }), HasSubstr("their overlaps with the objects"));
  set_memory_limit(0);
}

TEST_F(ScoreDetections, ClassesOfTheFileAreNamedOrRefused) {
  FoundFile found = perfect();
  for (auto& [picture, objects] : found.of_picture) {
    for (FoundObject& object : objects) object.category = object.category == 1 ? 7 : 0;
  }
  EXPECT_THAT(
      refusal_of([&] { score(found); }),
      testing::AllOf(HasSubstr("class 7"), HasSubstr("1 apple, 2 zea"), HasSubstr("--class-map")));
  const DetectionScores named = score(found, {.classes = class_map_from_string("7=apple,0=zea")});
  EXPECT_EQ(value(named, "mean of classes", "AP50"), 1);
  EXPECT_THAT(refusal_of([&] { class_map_from_string("7apple"); }), HasSubstr("NUMBER=NAME"));
  EXPECT_THAT(refusal_of([&] { class_map_from_string("7=a,7=b"); }), HasSubstr("another class"));
}

TEST_F(ScoreDetections, NothingFoundHasNoPrecisionAndNoRecall) {
  const DetectionScores scores = score({});
  EXPECT_EQ(value(scores, "mean of classes", "AP50"), 0);
  EXPECT_EQ(value(scores, "all classes", "recall"), 0);
  EXPECT_TRUE(std::isnan(value(scores, "all classes", "precision")));
}

TEST_F(ScoreDetections, ThePageShowsTheWorstPicturesAndWhatWasMissed) {
  FoundFile found = perfect();
  found.of_picture[1].clear();
  const DetectionScores scores = score(found);
  const ReportInput report = detections_report(truth_, found, scores, {}, {.scores = scores.rows});
  ASSERT_EQ(report.images.size(), 1U);
  EXPECT_EQ(report.images[0].name, "000000_000001");
  EXPECT_THAT(report.summary, HasSubstr("6 of 8 objects in 4 pictures were found"));
  EXPECT_EQ(report.tables.back().lines.size(), 2U);
  EXPECT_FALSE(make_report(report).empty());
}

}  // namespace
}  // namespace cousin
