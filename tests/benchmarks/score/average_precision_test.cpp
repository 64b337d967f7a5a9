// Average precision: by hand, and against reference values of other programs.
#include "benchmarks/score/average_precision.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/places/places.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

struct ScoredBox {
  double score = 0;
  PictureBox box;
};

using Overlap = std::function<double(const PictureBox&, const PictureBox&)>;

DetectedImage image_of(const std::vector<ScoredBox>& detections,
                       const std::vector<PictureBox>& objects,
                       const Overlap& overlap = box_overlap) {
  DetectedImage image;
  image.is_object_ignored.assign(objects.size(), 0);
  image.is_crowd.assign(objects.size(), 0);
  image.is_detection_ignored.assign(detections.size(), 0);
  for (const ScoredBox& detection : detections) {
    image.score.push_back(detection.score);
    std::vector<double>& row = image.overlap.emplace_back();
    for (const PictureBox& object : objects) row.push_back(overlap(detection.box, object));
  }
  return image;
}

TEST(AveragePrecision, ADetectionTakesWhatNoBetterOneTook) {
  const PictureBox a{0, 0, 10, 10}, b{4, 0, 10, 10};
  const DetectedImage image =
      image_of({{.5, {1, 0, 10, 10}}, {.9, {0, 0, 10, 10}}, {.4, {40, 0, 9, 9}}}, {a, b});
  const DetectionMatches coco = match_detections(image, .5);
  EXPECT_THAT(coco.order, ElementsAre(1, 0, 2));
  EXPECT_THAT(coco.object_of, ElementsAre(0, 1, -1));  // .54 of b, since a is taken
  EXPECT_THAT(coco.detection_of, ElementsAre(1, 0));
  EXPECT_THAT(match_detections(image, .5, MatchRule::pascal).object_of, ElementsAre(0, -1, -1));
  EXPECT_THAT(match_detections(image, .5, MatchRule::coco, 1).object_of, ElementsAre(0));
}

TEST(AveragePrecision, WhatIsIgnoredIsNeitherRightNorWrong) {
  DetectedImage image =
      image_of({{.9, {0, 0, 10, 10}}, {.8, {0, 0, 10, 10}}, {.7, {50, 0, 10, 10}}},
               {{0, 0, 10, 10}, {0, 0, 10, 9}});
  image.is_object_ignored = {1, 0};
  // The one that counts comes first, though the other is nearer.
  EXPECT_THAT(match_detections(image, .5).object_of, ElementsAre(1, 0, -1));
  EXPECT_THAT(match_detections(image, .5).is_ignored, ElementsAre(0, 1, 0));
  image.is_detection_ignored = {0, 0, 1};
  EXPECT_THAT(match_detections(image, .5).is_ignored, ElementsAre(0, 1, 1));
  EXPECT_EQ(average_precision(std::vector{image}, .5), 1);
  image.is_crowd = {1, 0};
  image.overlap[2] = {.9, 0};
  EXPECT_THAT(match_detections(image, .5).object_of, ElementsAre(1, 0, 0));
}

TEST(AveragePrecision, OfACurveByHand) {
  // Right, wrong, right of two objects: precision 1 up to recall .5, then 2/3.
  const std::vector<ScoredDetection> detections = {{.9, true}, {.8, false}, {.7, true}};
  EXPECT_NEAR(average_precision(detections, 2, PrecisionAt::every_point), .5 + .5 * 2 / 3, 1e-12);
  EXPECT_NEAR(average_precision(detections, 2), (51 + 50 * 2.0 / 3) / 101, 1e-12);
  EXPECT_NEAR(average_precision(detections, 2, PrecisionAt::pascal_11), (6 + 5 * 2.0 / 3) / 11,
              1e-12);
  EXPECT_EQ(average_precision(std::vector<ScoredDetection>{}, 3), 0);
  EXPECT_TRUE(std::isnan(average_precision(detections, 0)));
}

TEST(AveragePrecision, SizesThatDoNotFitAreRefused) {
  DetectedImage image = image_of({{.9, {0, 0, 1, 1}}}, {{0, 0, 1, 1}});
  image.overlap[0].push_back(1);
  EXPECT_THROW(match_detections(image, .5), std::invalid_argument);
}

TEST(AveragePrecision, BoxesOverlapByTheirArea) {
  EXPECT_NEAR(box_overlap({0, 0, 2, 2}, {1, 1, 2, 2}), 1.0 / 7, 1e-15);
  EXPECT_EQ(box_overlap({0, 0, 2, 2}, {2, 0, 2, 2}), 0);
  EXPECT_EQ(box_overlap({0, 0, 0, 0}, {0, 0, 0, 0}), 0);
}

// ---- Reference values
// ----------------------------------------------------------------------------

/// Pascal's: a box of whole pixels has its last ones too.
double pixel_overlap(const PictureBox& a, const PictureBox& b) {
  return box_overlap({a.x, a.y, a.width + 1, a.height + 1}, {b.x, b.y, b.width + 1, b.height + 1});
}

/// "object [score] x y w h" lines.
std::vector<ScoredBox> read_boxes(const fs::path& file, bool has_score) {
  std::vector<ScoredBox> boxes;
  std::ifstream in(file);
  std::string name;
  while (in >> name) {
    ScoredBox& box = boxes.emplace_back();
    if (has_score) in >> box.score;
    in >> box.box.x >> box.box.y >> box.box.width >> box.box.height;
  }
  return boxes;
}

TEST(AveragePrecision, IsThatOfAnotherProgramOnSevenImages) {
  const fs::path root = real_data() / "refs/map_voc_case1";
  if (!fs::exists(root)) GTEST_SKIP() << "no " << root;
  std::vector<DetectedImage> images;
  for (int i = 1; i <= 7; ++i) {
    const std::string name = "0000" + std::to_string(i) + ".txt";
    std::vector<PictureBox> objects;
    for (const ScoredBox& box : read_boxes(root / "gts" / name, false)) objects.push_back(box.box);
    images.push_back(image_of(read_boxes(root / "dets" / name, true), objects, pixel_overlap));
  }
  const std::vector<std::array<double, 3>> published = {{.1, .3333333333, .3371980676},
                                                        {.3, .2683982683, .2456866804},
                                                        {.5, .0303030303, .0222222222},
                                                        {.75, 0, 0}};
  for (const auto& [threshold, eleven, every] : published) {
    EXPECT_NEAR(average_precision(images, threshold, PrecisionAt::pascal_11, MatchRule::pascal),
                eleven, 1e-6);
    EXPECT_NEAR(average_precision(images, threshold, PrecisionAt::every_point, MatchRule::pascal),
                every, 1e-6);
  }
}

TEST(AveragePrecision, IsThatOfAnotherProgramOnTwelveCats) {
  const fs::path root = real_data() / "refs/map_toyexample";
  if (!fs::exists(root)) GTEST_SKIP() << "no " << root;
  const auto truth =
      nlohmann::json::parse(std::ifstream(root / "gts_coco_format/toy_example_coco.JSON"));
  std::vector<DetectedImage> images;
  for (const auto& entry : truth["images"]) {
    std::vector<PictureBox> objects;
    for (const auto& a : truth["annotations"]) {
      if (a["image_id"] != entry["id"]) continue;
      const std::vector<double> b = a["bbox"];
      objects.push_back({b[0], b[1], b[2], b[3]});
    }
    const std::string stem = fs::path(std::string(entry["file_name"])).stem();
    images.push_back(image_of(read_boxes(root / "dets_classname_abs_xywh" / (stem + ".txt"), true),
                              objects, pixel_overlap));
  }
  const std::vector<std::array<double, 3>> published = {{.5, .8864, .8958}, {.75, .4924, .5097}};
  for (const auto& [threshold, eleven, every] : published) {
    EXPECT_NEAR(average_precision(images, threshold, PrecisionAt::pascal_11, MatchRule::pascal),
                eleven, 5e-5);
    EXPECT_NEAR(average_precision(images, threshold, PrecisionAt::every_point, MatchRule::pascal),
                every, 5e-5);
  }
}

}  // namespace
}  // namespace cousin
