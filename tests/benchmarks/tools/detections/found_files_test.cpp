// Files of detections, as COCO's and YOLO's programs write them, and what is refused.
#include "benchmarks/tools/detections/found_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/dataset/atomic_file.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

std::ptrdiff_t inside(const PlacedMask& mask) {
  return std::count(mask.mask.data(), mask.mask.data() + mask.mask.size(), 255);
}

class FoundFiles : public testing::Test {
 protected:
  FoundFile coco(const std::string& text) const {
    write_file(folder_.path() / "found.json", text);
    return read_found(folder_.path() / "found.json", names_);
  }
  std::string coco_error(const std::string& entry) const {
    return error_of([&] { coco("[" + entry + "]"); });
  }
  std::string yolo_error(const std::string& line) const {
    write_file(folder_.path() / "y/000000_000001.txt", line);
    return error_of([&] { read_found(folder_.path() / "y", names_); });
  }
  TemporaryFolder folder_;
  PictureNames names_ = {{"000000_000001", {3, 40, 30}}, {"1", {3, 40, 30}}};
};

TEST_F(FoundFiles, CocoResultsHaveBoxesMasksAndNamesOrNumbers) {
  const FoundFile found = coco(
      R"([{"image_id": 1, "category_id": 2, "bbox": [1, 2, 3, 4], "score": 0.5},
          {"image_id": "000000_000001", "category_id": 1, "score": 1, "file_name": "x",
           "segmentation": [[1, 1, 5, 1, 5, 4, 1, 4]]},
          {"image_id": "000000_000001.png", "category_id": 1, "score": 0.25, "bbox": [0, 0, 2, 1],
           "segmentation": {"size": [30, 40], "counts": [0, 1, 29, 1, 1169]}}])");
  ASSERT_EQ(found.of_picture.size(), 1U);
  const std::vector<FoundObject>& objects = found.of_picture.at(3);
  ASSERT_EQ(objects.size(), 3U);
  EXPECT_TRUE(found.has_masks);
  EXPECT_EQ(objects[0].category, 2);
  EXPECT_EQ(objects[0].box.height, 4);
  EXPECT_TRUE(objects[0].mask.mask.empty());
  EXPECT_EQ(objects[1].box.x, 1);  // of its mask
  EXPECT_EQ(objects[1].box.width, 4);
  EXPECT_EQ(inside(objects[1].mask), 12);
  EXPECT_EQ(objects[2].mask.mask.width(), 2);
}

TEST_F(FoundFiles, WhatIsNoCocoResultIsNamed) {
  EXPECT_THAT(
      coco_error(R"({"image_id": 7, "category_id": 1, "bbox": [0,0,1,1], "score": 1})"),
      AllOf(HasSubstr("found.json: /0"), HasSubstr("picture \"7\", which the dataset has not"),
            HasSubstr("000000_000001")));
  EXPECT_THAT(coco_error(R"({"image_id": 1, "category_id": 1, "bbox": [0,0,1,1]})"),
              HasSubstr("has no score"));
  EXPECT_THAT(coco_error(R"({"image_id": 1, "category_id": 1, "bbox": [0,0,1,1], "score": 2})"),
              HasSubstr("score = 2 is outside [0, 1]"));
  EXPECT_THAT(coco_error(R"({"image_id": 1, "category_id": 1, "bbox": [0,0,-1,1], "score": 1})"),
              HasSubstr("bbox"));
  EXPECT_THAT(coco_error(R"({"image_id": 1, "category_id": 1, "score": 1})"),
              HasSubstr("neither bbox nor segmentation"));
  EXPECT_THAT(coco_error(R"({"image_id": 1, "category_id": 1, "score": 1,
                     "segmentation": {"size": [40, 30], "counts": [1200]}})"),
              HasSubstr("not the picture's [height, width] = [30,40]"));
  EXPECT_THAT(coco_error("3"), HasSubstr("is no object"));
  EXPECT_THAT(coco_error(R"({"image_id": 1, "category_id": 1.5, "bbox": [0,0,1,1], "score": 1})"),
              HasSubstr("no whole number"));
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  EXPECT_THAT(coco_error(R"({"image_id": )" + deep + "}"), HasSubstr("nested too deep"));
  EXPECT_THAT(error_of([&] { coco(R"({"images": [], "annotations": []})"); }),
              HasSubstr("a file of COCO annotations"));
  EXPECT_THAT(error_of([&] { coco("["); }), HasSubstr("is not JSON"));
  set_memory_limit(100);
  EXPECT_THAT(coco_error(R"({"image_id": 1, "category_id": 1, "bbox": [0,0,1,1], "score": 1})"),
              HasSubstr("found.json: its JSON would take"));
  set_memory_limit(0);
}

TEST_F(FoundFiles, YoloLinesAreBoxesOrPolygonsWithConfidence) {
  write_file(folder_.path() / "run/labels/000000_000001.txt",
             "0 0.5 0.5 0.25 0.2 0.75\n\n1 0.1 0.1 0.3 0.1 0.3 0.2 0.1 0.2 0.5\n");
  const FoundFile found = read_found(folder_.path() / "run", names_);
  const std::vector<FoundObject>& objects = found.of_picture.at(3);
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].score, 0.75);
  EXPECT_EQ(objects[0].box.x, 15);
  EXPECT_EQ(objects[0].box.y, 12);
  EXPECT_EQ(objects[0].box.width, 10);
  EXPECT_EQ(objects[1].category, 1);
  EXPECT_NEAR(objects[1].box.width, 8, 1e-12);
  EXPECT_EQ(inside(objects[1].mask), 24);
}

TEST_F(FoundFiles, WhatIsNoDetectionOfYoloIsNamedWithItsLine) {
  EXPECT_THAT(yolo_error("0 0.5 0.5 0.25 0.2\n"),
              AllOf(HasSubstr("000000_000001.txt: line 1"), HasSubstr("it is a label")));
  EXPECT_THAT(yolo_error("0 0.5 0.5 0.25 0.2 1\n0 .1 .2 .3 .4 .5 .6\n"),
              AllOf(HasSubstr("line 2"), HasSubstr("has 7 numbers")));
  EXPECT_THAT(yolo_error("a 0.5 0.5 0.25 0.2 1\n"), HasSubstr("\"a\" is no number"));
  EXPECT_THAT(yolo_error("0.5 0.5 0.5 0.25 0.2 1\n"), HasSubstr("no whole number"));
  EXPECT_THAT(yolo_error("0 0.5 0.5 0.25 0.2 1.5\n"), HasSubstr("confidence outside [0, 1]"));
  EXPECT_THAT(yolo_error("0 0.5 0.5 -0.1 0.2 1\n"), HasSubstr("negative width"));
  EXPECT_THAT(yolo_error("0 250 0.5 0.25 0.2 1\n"), HasSubstr("not near [0, 1]"));
  fs::rename(folder_.path() / "y/000000_000001.txt", folder_.path() / "y/other.txt");
  EXPECT_THAT(error_of([&] { read_found(folder_.path() / "y", names_); }),
              HasSubstr("picture \"other\""));
  fs::remove(folder_.path() / "y/other.txt");
  EXPECT_THAT(error_of([&] { read_found(folder_.path() / "y", names_); }),
              HasSubstr("no text file of detections"));
}

}  // namespace
}  // namespace cousin
