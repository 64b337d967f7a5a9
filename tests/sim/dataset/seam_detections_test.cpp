// boxes.json, keypoints.json, fits.json: all comes back, and what means something else is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/dataset/seam_io.h"
#include "sim/dataset/seam_json.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Boxes two_boxes() {
  DetectedBox plain;
  plain.frame = 3;
  plain.sensor = 1;
  plain.id = 7;
  plain.score = 0.25;
  plain.low_px = {-0.5, 2};
  plain.high_px = {9.75, 12.125};
  DetectedBox with_mask;
  with_mask.id = 8;
  with_mask.instance = 4;
  with_mask.category = 2;
  with_mask.high_px = {1.5, 1.5};
  with_mask.image_px = {40, 30};
  with_mask.mask_at_px = {5, 6};
  with_mask.mask = Image<std::uint8_t>(2, 2, 255);
  with_mask.mask(1, 1) = 0;
  return {plain, with_mask};
}

TEST(SeamDetections, BoxesAndTheirMasksComeBack) {
  const TemporaryFolder folder;
  write_boxes(folder.path(), two_boxes(), 2);
  const Boxes read =
      read_boxes(folder.path(), {.scene = 2, .size_px = {{{3, 1}, {40, 30}}, {{0, 0}, {40, 30}}}});
  const Boxes written = two_boxes();
  ASSERT_EQ(read.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read[i].frame, written[i].frame);
    EXPECT_EQ(read[i].sensor, written[i].sensor);
    EXPECT_EQ(read[i].id, written[i].id);
    EXPECT_EQ(read[i].instance, written[i].instance);
    EXPECT_EQ(read[i].category, written[i].category);
    EXPECT_EQ(read[i].score, written[i].score);
    EXPECT_EQ(read[i].low_px, written[i].low_px);
    EXPECT_EQ(read[i].high_px, written[i].high_px);
    EXPECT_EQ(read[i].mask, written[i].mask);
    EXPECT_EQ(read[i].mask_at_px, written[i].mask_at_px);
  }
}

std::string boxes_error(const std::string& entry, const DetectionImages& images = {}) {
  return error_of([&] { boxes_from_json("[" + entry + "]", "boxes.json", images); });
}

TEST(SeamDetections, WhatABoxMayLeaveOutHasItsMeaning) {
  const Boxes boxes = boxes_from_json(
      R"([{"image_id": 5000002, "category_id": 1, "bbox": [0, 0, 2, 3]},
          {"image_id": 5000002, "category_id": 1, "bbox": [0, 0, 2, 3]}])",
      "boxes.json");
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_EQ(boxes[1].frame, 2);
  EXPECT_EQ(boxes[1].sensor, 0);
  EXPECT_EQ(boxes[1].id, 1);
  EXPECT_EQ(boxes[1].instance, -1);
  EXPECT_EQ(boxes[1].score, 1);
  EXPECT_EQ(boxes[1].low_px, Eigen::Vector2d(-0.5, -0.5));
  EXPECT_EQ(boxes[1].high_px, Eigen::Vector2d(1.5, 2.5));
}

TEST(SeamDetections, BoxesNameWhatIsWrong) {
  const std::string box = R"("image_id": 1, "category_id": 1, "bbox": [0, 0, 2, 3])";
  EXPECT_THAT(boxes_error("{" + box + R"(, "unit": "mm"})"), HasSubstr("unit"));
  EXPECT_THAT(boxes_error("{" + box + R"(, "score": 1.5})"),
              HasSubstr("boxes.json: /0/score = 1.5"));
  EXPECT_THAT(boxes_error("{" + box + R"(, "iscrowd": 1})"), HasSubstr("marks a crowd"));
  EXPECT_THAT(boxes_error("{" + box + R"(, "sensor": -1})"), HasSubstr("/0/sensor"));
  EXPECT_THAT(boxes_error("{" + box + R"(, "id": 3}, {)" + box + R"(, "id": 3})"),
              HasSubstr("an id that occurs twice"));
  EXPECT_THAT(boxes_error(R"({"image_id": 1, "category_id": 1, "bbox": [0, 0, -2, 3]})"),
              HasSubstr("negative width"));
  EXPECT_THAT(boxes_error("{" + box + "}", {.scene = 1}), HasSubstr("not of scene 1"));
  EXPECT_THAT(
      boxes_error("{" + box + R"(, "sensor": 1})", {.scene = 0, .size_px = {{{1, 0}, {8, 8}}}}),
      HasSubstr("frame 1, sensor 1, of which the capture has no colour image"));
  EXPECT_THAT(error_of([] { boxes_from_json(R"({"annotations": []})", "boxes.json"); }),
              HasSubstr("a file of COCO annotations; boxes are"));
}

TEST(SeamDetections, KeypointsComeBackWithTheirSigmas) {
  KeypointDetection detection;
  detection.frame = 1;
  detection.sensor = 1;
  detection.instance = 2;
  detection.points.resize(3);
  detection.points[1] = {KeypointStatus::seen, {4.25, -1}, 0.125};
  detection.points[2] = {KeypointStatus::hidden, {1e5, 3}, std::nan("")};
  const TemporaryFolder folder;
  write_keypoints(folder.path(), {detection}, 0);
  const Keypoints read = read_keypoints(folder.path());
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].sensor, 1);
  EXPECT_EQ(read[0].instance, 2);
  ASSERT_EQ(read[0].points.size(), 3U);
  EXPECT_EQ(read[0].points[0].status, KeypointStatus::missing);
  EXPECT_TRUE(std::isnan(read[0].points[0].pixel_px.x()));
  EXPECT_EQ(read[0].points[1].status, KeypointStatus::seen);
  EXPECT_EQ(read[0].points[1].pixel_px, Eigen::Vector2d(4.25, -1));
  EXPECT_EQ(read[0].points[1].sigma_px, 0.125);
  EXPECT_EQ(read[0].points[2].status, KeypointStatus::hidden);
  EXPECT_TRUE(std::isnan(read[0].points[2].sigma_px));
}

TEST(SeamDetections, KeypointsNameWhatIsWrong) {
  const auto error = [](const std::string& points, const std::string& more = "") {
    return error_of([&] {
      keypoints_from_json(
          R"([{"image_id": 1, "category_id": 1, "keypoints": )" + points + more + "}]",
          "keypoints.json");
    });
  };
  EXPECT_THAT(error("[1, 2]"), HasSubstr("x, y, v for each point"));
  EXPECT_THAT(error("[1, 2, 3]"), HasSubstr("not 0, 1 or 2"));
  EXPECT_THAT(error("[1e9, 2, 2]"), HasSubstr("outside [-1e6, 1e6]"));
  EXPECT_THAT(error("[1, 2, 2]", R"(, "cousin": {"sigma_px": [1, 2]})"),
              HasSubstr("one entry for each point"));
  EXPECT_THAT(error("[1, 2, 2]", R"(, "cousin": {"sigma_px": [-1]})"), HasSubstr("is negative"));
}

TEST(SeamFits, ParametersAndCovarianceComeBackInSiUnits) {
  const Fits fits = fits_from_json(
      R"({"fits": [{"instance": 1, "model": "sphere", "status": "ok", "parameters":
          [{"name": "radius", "unit": "mm", "value": 12.5}, {"name": "tilt", "unit": "deg", "value": 90}],
          "covariance": [4, 1, 1, 9]},
          {"instance": 2, "model": "line", "status": "too_few_points", "reason": "3 points",
           "parameters": []}]})",
      "fits.json");
  ASSERT_EQ(fits.size(), 2U);
  EXPECT_EQ(fits[0].parameters[0].unit, "m");
  EXPECT_NEAR(fits[0].parameters[0].value, 0.0125, 1e-15);
  EXPECT_NEAR(fits[0].parameters[1].value, 1.5707963267948966, 1e-12);
  EXPECT_NEAR(fits[0].covariance(0, 0), 4e-6, 1e-18);
  EXPECT_NEAR(fits[0].covariance(0, 1), 1e-3 * 3.141592653589793 / 180, 1e-15);
  EXPECT_EQ(fits[1].status, FitStatus::too_few_points);
  const TemporaryFolder folder;
  write_fits(folder.path(), fits);
  const Fits again = read_fits(folder.path());
  EXPECT_EQ(again[0].covariance, fits[0].covariance);
  EXPECT_EQ(again[0].parameters[1].value, fits[0].parameters[1].value);
  EXPECT_EQ(again[1].reason, "3 points");
  EXPECT_EQ(fits_from_json(R"({"fits": [{"instance": 1, "model": "none", "status": "degenerate",
                              "parameters": [], "covariance": []}]})",
                           "fits.json")
                .size(),
            1U);
}

TEST(SeamFits, NameWhatIsWrong) {
  const auto error = [](const std::string& unit, const std::string& covariance) {
    return error_of([&] {
      fits_from_json(
          R"({"fits": [{"instance": 1, "model": "sphere", "status": "ok", "parameters": )"
          R"([{"name": "a", "unit": ")" +
              unit +
              R"(", "value": 1}, )"
              R"({"name": "b", "unit": "1", "value": null}], "covariance": )" +
              covariance + "}]}",
          "fits.json");
    });
  };
  EXPECT_THAT(error("furlong", "null"),
              AllOf(HasSubstr("fits.json: /fits/0/parameters/0/unit"), HasSubstr("furlong")));
  EXPECT_THAT(error("m", "[1, 2, 3]"), HasSubstr("covariance"));
  EXPECT_THAT(error("m", "[1, 0.5, 0.4, 1]"), HasSubstr("is not symmetric"));
  EXPECT_THAT(error("m", "[1, 2, 2, 1]"), HasSubstr("not positive semi-definite"));
  EXPECT_THAT(error("m", "[-1, 0, 0, 1]"), HasSubstr("negative variance"));
  EXPECT_EQ(error("m", "[1, 1, 1, 1]"), "");  // fully correlated
  EXPECT_EQ(error("m", "[0, 0, 0, 1]"), "");  // known
}

}  // namespace
}  // namespace cousin
