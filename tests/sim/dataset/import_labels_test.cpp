// Somebody's labelled photographs: COCO's annotations, YOLO's text.
#include "sim/dataset/import_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/seam_io.h"
#include "sim/imaging/image_io.h"
#include "tests/places/places.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ImportLabels : public testing::Test {
 protected:
  void picture(const std::string& name, int width_px, int height_px) const {
    write_png(path(name), Image<Rgb8>(width_px, height_px, Rgb8{90, 120, 40}));
  }
  void text(const std::string& name, const std::string& content) const {
    write_file(path(name), content);
  }
  fs::path path(const std::string& name) const {
    fs::create_directories((folder_.path() / name).parent_path());
    return folder_.path() / name;
  }
  fs::path root() const { return folder_.path(); }

  /// Two pictures of different sizes, and classes by list.
  void small_yolo() const {
    picture("images/train/a.png", 40, 20);
    picture("images/train/b.png", 20, 30);
    text("labels/train/a.txt", "1 0.5 0.5 0.25 0.5\n0 0.1 0.2 0.3 0.2 0.3 0.6 0.1 0.6\n");
    text("data.yaml", "path: .\ntrain: images/train\nval: images/train\nnames: [leaf, berry]\n");
  }
  void small_coco(const std::string& annotations) const {
    picture("a.png", 40, 20);
    text("set.json",
         R"({"info": {"year": "2022"}, "licenses": [],
             "categories": [{"id": 7, "name": "berry", "supercategory": "fruit"},
                            {"id": 3, "name": "leaf"}],
             "images": [{"id": 12, "file_name": "a.png", "width": 40, "height": 20}],
             "annotations": [)" +
             annotations + "]}");
  }
  template <class Import>
  void expect_refused(Import import, const std::string& what) const {
    EXPECT_THAT([&] { import(root()); },
                testing::ThrowsMessage<std::runtime_error>(HasSubstr(what)));
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(ImportLabels, YoloHasBoxesAndPolygonsInSharesOfEachImage) {
  small_yolo();
  const LabelledPhotographs all = import_yolo(root());
  EXPECT_THAT(all.categories, ElementsAre("leaf", "berry"));
  ASSERT_EQ(all.capture.frames.size(), 2U);
  EXPECT_EQ(all.capture.frames[1].sensors[0].reported.height_px, 30);
  EXPECT_EQ(all.labels.pictures[1].file, "images/train/b.png");
  EXPECT_THAT(all.capture.warnings, ElementsAre(HasSubstr("1 images have no label file")));
  const Boxes& boxes = all.labels.boxes;
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_EQ(boxes[0].category, 2);
  EXPECT_EQ(boxes[0].low_px, Eigen::Vector2d(14.5, 4.5));  // 20 - 5, 10 - 5, from pixel centres
  EXPECT_EQ(boxes[0].high_px, Eigen::Vector2d(24.5, 14.5));
  EXPECT_TRUE(boxes[0].mask.empty());
  EXPECT_EQ(boxes[1].category, 1);
  EXPECT_EQ(std::count(boxes[1].mask.begin(), boxes[1].mask.end(), 255), 8 * 8);
  const Eigen::Vector2i at = Eigen::Vector2i(4, 4) - boxes[1].mask_at_px;
  EXPECT_EQ(boxes[1].mask(at.x(), at.y()), 255);  // the corner that is nearest to the image's
}

TEST_F(ImportLabels, YoloReadsMappingsRoboflowsFoldersAndNoFileAtAll) {
  picture("train/images/a.png", 40, 20);
  text("train/labels/a.txt", "0 0.5 0.5 0.25 0.5\r\n");
  text("data.yaml", "train: ../train/images\nval: \nnc: 1\nnames:\n  0: berry\n");
  EXPECT_EQ(import_yolo(root()).labels.boxes.size(), 1U);
  picture("bare/images/a.png", 40, 20);
  text("bare/labels/a.txt", "4 0.5 0.5 0.25 0.5\n");
  const LabelledPhotographs bare = import_yolo(root() / "bare");
  EXPECT_EQ(bare.categories.size(), 5U);
  EXPECT_EQ(bare.categories.back(), "class 4");
}

TEST_F(ImportLabels, YoloReadsQuotesFoldersBelowAndMarksOfByteOrder) {
  const std::string mark = "\xEF\xBB\xBF";
  picture("images/a.png", 40, 20);
  picture("images/deep/er/a.png", 40, 20);
  text("labels/a.txt", mark + "0 0.5 0.5 0.25 0.5\n\n");
  text("labels/deep/er/a.txt", "1 0.5 0.5 0.25 0.5\n");
  text("data.yaml", mark + "train: [\"images\"]\nval: valid\nnames: ['leaf', \"berry\"]\n");
  const LabelledPhotographs all = import_yolo(root());
  EXPECT_THAT(all.categories, ElementsAre("leaf", "berry"));
  ASSERT_EQ(all.labels.pictures.size(), 2U);
  EXPECT_EQ(all.labels.pictures[1].file, "images/deep/er/a.png");
  EXPECT_EQ(all.labels.boxes.size(), 2U);
  EXPECT_THAT(all.capture.warnings, testing::Contains(HasSubstr("not read: valid")));
}

TEST_F(ImportLabels, YoloReadsNothingOutsideItsFolder) {
  picture("other/images/a.png", 40, 20);
  text("other/labels/a.txt", "0 0.5 0.5 0.25 0.5\n");
  picture("set/images/a.png", 40, 20);
  text("set/data.yaml", "path: ../other\ntrain: images\nnames: [leaf]\n");
  fs::create_directories(path("set/labels"));
  fs::create_symlink(path("other/labels/a.txt"), path("set/labels/a.txt"));
  const auto import_set = [](const fs::path& root) { import_yolo(root / "set"); };
  expect_refused(import_set, "a link that leads out");
  text("set/data.yaml", "train: ../other/images\nnames: [leaf]\n");
  expect_refused(import_set, "leads out of");
}

TEST_F(ImportLabels, APolygonThatCoversNoPixelsMiddleIsOnePixel) {
  small_yolo();
  text("labels/train/a.txt", "0 0.251 0.251 0.252 0.251 0.252 0.252\n");
  const LabelledPhotographs all = import_yolo(root());
  ASSERT_EQ(all.labels.boxes.size(), 1U);
  EXPECT_EQ(std::count(all.labels.boxes[0].mask.begin(), all.labels.boxes[0].mask.end(), 255), 1);
}

TEST_F(ImportLabels, WhatIsOutsideTheImageIsCutOffOrCounted) {
  small_yolo();
  text("labels/train/a.txt", "0 0 0.5 0.5 0.5\n0 1.5 0.5 0.2 0.2\n");
  const LabelledPhotographs all = import_yolo(root());
  ASSERT_EQ(all.labels.boxes.size(), 1U);
  EXPECT_EQ(all.labels.boxes[0].low_px.x(), -0.5);
  EXPECT_EQ(all.labels.boxes[0].high_px.x(), 9.5);
  EXPECT_THAT(all.capture.warnings, testing::Contains(HasSubstr("1 labels are left out")));
}

TEST_F(ImportLabels, YoloNamesFileAndLineOfWhatItCannotRead) {
  small_yolo();
  const auto line = [&](const std::string& content, const std::string& what) {
    text("labels/train/a.txt", content);
    expect_refused(import_yolo, what);
  };
  line("0 0.5 0.5 0.25 0.5 0.9\n", "a.txt: line 1: has 6 numbers");
  line("0 0.5 0.5 0.25 0.5\n0 0.5 nan 0.25 0.5\n", "a.txt: line 2");
  line("-1 0.5 0.5 0.25 0.5\n", "a.txt: line 1");
  line("0 0.5 0.5 -0.25 0.5\n", "negative width");
  line("2 0.5 0.5 0.25 0.5\n", "class 2 of a label is none of the 2 names");
  text("data.yaml", "train: nowhere\nnames: [leaf]\n");
  expect_refused(import_yolo, "nowhere: no such folder below");
  text("labels/train/a.txt", "0 0.5 0.5 0.25 0.5\n");
  text("data.yaml", "train: images/train\nnames: [leaf, leaf]\n");
  expect_refused(import_yolo, "stands twice");
  text("data.yaml", "train: images/train\nnc: 3\nnames: [leaf, berry]\n");
  expect_refused(import_yolo, "nc = 3, and there are 2 names");
  text("data.yaml", "train: images/train\nnames: ['leaf, old', berry]\n");
  expect_refused(import_yolo, "quotes about a comma");
  text("data.yaml", "train: images/train\nnames: {0: leaf, 1: berry}\n");
  expect_refused(import_yolo, "one name a line");
  text("data.yaml", "train: images/train\nkpt_shape: [5, 3]\nnames: [leaf]\n");
  expect_refused(import_yolo, "keypoints are not read");
  text("data.yaml", "train: images/train\nnames:\n  0: leaf\n  2: berry\n");
  expect_refused(import_yolo, "there is no class 1");
}

TEST_F(ImportLabels, CocosNumbersBecomePlacesAndItsMasksAreRead) {
  small_coco(
      R"({"id": 1, "image_id": 12, "category_id": 7, "bbox": [2, 3, 10, 5], "area": 50,
          "segmentation": [[2, 3, 12, 3, 12, 8, 2, 8]], "iscrowd": 0},
         {"id": 2, "image_id": 12, "category_id": 3, "bbox": [0, 0, 4, 4]},
         {"id": 3, "image_id": 12, "category_id": 3, "bbox": [0, 0, 9, 9], "iscrowd": 1,
          "segmentation": {"size": [20, 40], "counts": [0, 800]}})");
  const LabelledPhotographs all = import_coco(root());
  EXPECT_THAT(all.categories, ElementsAre("leaf", "berry"));  // by their numbers
  EXPECT_EQ(all.labels.pictures[0].id, "12");
  EXPECT_THAT(all.labels.category_ids, ElementsAre(3, 7));
  const Boxes& boxes = all.labels.boxes;
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_EQ(boxes[0].category, 2);
  EXPECT_EQ(boxes[0].low_px, Eigen::Vector2d(1.5, 2.5));
  EXPECT_EQ(std::count(boxes[0].mask.begin(), boxes[0].mask.end(), 255), 50);
  EXPECT_THAT(all.capture.warnings, testing::Contains(HasSubstr("1 regions that mark a crowd")));
}

TEST_F(ImportLabels, CocoNamesTheEntryThatItCannotRead) {
  const auto entry = [&](const std::string& annotation, const std::string& what) {
    small_coco(annotation);
    expect_refused(import_coco, what);
  };
  entry(R"({"image_id": 13, "category_id": 7, "bbox": [0, 0, 1, 1]})", "/annotations/0/image_id");
  entry(R"({"image_id": 12, "category_id": 8, "bbox": [0, 0, 1, 1]})",
        "/annotations/0/category_id");
  entry(R"({"image_id": 12, "category_id": 7, "bbox": [0, 0, -1, 1]})", "negative width");
  small_coco("");
  picture("a.png", 20, 40);  // turned since
  expect_refused(import_coco, "20x40 pixels; its labels are of 40x20");
  fs::remove(path("a.png"));
  expect_refused(import_coco, "/images/0/file_name");
}

TEST_F(ImportLabels, LabelsComeBackFromADataset) {
  small_yolo();
  const LabelledPhotographs all = import_yolo(root());
  const fs::path scene = root() / "000000";
  EXPECT_FALSE(has_labels(scene));
  write_labels(scene, all.labels, 0);
  EXPECT_TRUE(has_labels(scene));
  const PhotographLabels back =
      read_labels(scene, {.scene = 0, .size_px = {{{0, 0}, {40, 20}}, {{1, 0}, {20, 30}}}});
  ASSERT_EQ(back.boxes.size(), 2U);
  EXPECT_EQ(back.pictures[0].file, "images/train/a.png");
  EXPECT_TRUE(back.category_ids.empty());
  EXPECT_EQ(std::count(back.boxes[1].mask.begin(), back.boxes[1].mask.end(), 255), 64);
  EXPECT_THAT(
      [] { pictures_from_json(R"({"pictures": [{"frame": -1, "file": "", "id": ""}]})", "p"); },
      testing::ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("p: /pictures/0/frame"))));
}

TEST(ImportLabelsReal, StrawberriesOfRoboflowAreRead) {
  const fs::path folder = real_data() / "images/strawberry_masks_roboflow/train";
  if (!fs::exists(folder)) GTEST_SKIP() << "no real captures at " << real_data();
  const LabelledPhotographs all = import_coco(folder);
  EXPECT_EQ(all.capture.frames.size(), 102U);
  EXPECT_THAT(all.categories, ElementsAre("strawberry", "R_strawberry", "people"));
  EXPECT_GE(all.labels.boxes.size(), 102U);
  EXPECT_TRUE(std::any_of(all.labels.boxes.begin(), all.labels.boxes.end(),
                          [](const DetectedBox& box) { return !box.mask.empty(); }));
}

}  // namespace
}  // namespace cousin
