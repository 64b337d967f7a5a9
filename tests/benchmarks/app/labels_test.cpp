// Somebody's labelled photographs become a dataset, and a detector is scored on them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "tests/benchmarks/app/program.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class AppLabels : public testing::Test {
 protected:
  AppLabels() {
    for (const char* name : {"a", "b"}) {
      const fs::path image = program_.path("mine/images") / (std::string(name) + ".png");
      fs::create_directories(image.parent_path());
      write_png(image, Image<Rgb8>(40, 20, Rgb8{90, 120, 40}));
      write_file(program_.path("mine/labels") / (std::string(name) + ".txt"),
                 "1 0.5 0.5 0.25 0.5\n");
    }
    write_file(program_.path("mine/data.yaml"), "train: images\nnames: [leaf, berry]\n");
  }
  Program program_;
};

TEST_F(AppLabels, ADetectorIsScoredOnThem) {
  const Outcome import = program_.run({"import", "mine", "--format", "yolo", "--out", "data"});
  ASSERT_EQ(import.code, 0) << import.err;
  EXPECT_THAT(import.err, HasSubstr("2 frames, 2 labels"));
  write_file(program_.path("found/a.txt"), "1 0.5 0.5 0.25 0.5 0.9\n");
  const Outcome score = program_.run({"score", "data", "found"});
  ASSERT_EQ(score.code, 0) << score.err;
  EXPECT_THAT(score.err, HasSubstr("1 of 2 objects in 2 pictures were found"));
  const std::string rows = read_file(program_.path("out/found_scores/scores.csv"));
  EXPECT_THAT(rows, AllOf(HasSubstr("all classes,found,recall,0.5"),
                          testing::Not(HasSubstr("recall.visible"))));
  // The same again changes nothing; another source is refused.
  EXPECT_EQ(program_.run({"import", "mine", "--format", "yolo", "--out", "data"}).code, 0);
  EXPECT_EQ(program_
                .run({"import", "mine/images", "--format", "folder", "--intrinsics", "40,40,20,10",
                      "--out", "data"})
                .code,
            2);
}

/// COCO's numbers begin where they like, and files are called as they like.
TEST_F(AppLabels, ACocoFileOfItsOwnNumbersIsRight) {
  write_file(program_.path("mine/images/set.json"),
             R"({"categories": [{"id": 0, "name": "fruit"}, {"id": 4, "name": "berry"}],
                 "images": [{"id": 5, "file_name": "a.png"}, {"id": 3, "file_name": "b.png"}],
                 "annotations": [{"image_id": 5, "category_id": 4, "bbox": [2, 3, 10, 5]},
                                 {"image_id": 3, "category_id": 4, "bbox": [8, 3, 10, 5]}]})");
  ASSERT_EQ(program_.run({"import", "mine/images", "--format", "coco", "--out", "coco"}).code, 0);
  const auto score = [&](const std::string& a, const std::string& b) {
    const std::string of = R"("category_id": 4, "score": 1, "bbox": )";
    write_file(program_.path("found.json"), "[{\"image_id\": " + a + ", " + of +
                                                "[2, 3, 10, 5]}, {\"image_id\": " + b + ", " + of +
                                                "[8, 3, 10, 5]}]");
    const Outcome outcome = program_.run({"score", "coco", "found.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return read_file(program_.path("out/found_scores/scores.csv"));
  };
  EXPECT_THAT(score("5", "3"), HasSubstr("class berry,found.json,AP50.of_class,1,"));
  EXPECT_THAT(score("\"a\"", "\"b.png\""), HasSubstr("class berry,found.json,AP50.of_class,1,"));
}

TEST_F(AppLabels, NumbersThatAreNamesAreFoundAndANameOfTwoPicturesIsRefused) {
  for (const char* name : {"2", "10"}) {
    write_png(program_.path("mine/images") / (std::string(name) + ".png"),
              Image<Rgb8>(40, 20, Rgb8{90, 120, 40}));
    write_file(program_.path("mine/labels") / (std::string(name) + ".txt"), "1 0.5 0.5 0.25 0.5\n");
  }
  ASSERT_EQ(program_.run({"import", "mine", "--format", "yolo", "--out", "data"}).code, 0);
  write_file(program_.path("found.json"),
             R"([{"image_id": 10, "category_id": 2, "bbox": [15, 5, 10, 10], "score": 1},
                 {"image_id": "2", "category_id": 2, "bbox": [15, 5, 10, 10], "score": 1}])");
  const Outcome numbers = program_.run({"score", "data", "found.json"});
  ASSERT_EQ(numbers.code, 0) << numbers.err;
  EXPECT_THAT(numbers.err, HasSubstr("2 of 4 objects in 4 pictures were found"));
  fs::create_directories(program_.path("mine/images/more"));
  write_png(program_.path("mine/images/more/a.png"), Image<Rgb8>(40, 20, Rgb8{90, 120, 40}));
  ASSERT_EQ(program_.run({"import", "mine", "--format", "yolo", "--out", "two"}).code, 0);
  write_file(program_.path("found/a.txt"), "1 0.5 0.5 0.25 0.5 0.9\n");
  const Outcome twice = program_.run({"score", "two", "found"});
  EXPECT_EQ(twice.code, 3);
  EXPECT_THAT(twice.err, HasSubstr("the dataset has several of this name"));
}

TEST_F(AppLabels, WhatHasNoUseIsRefused) {
  const Outcome lens = program_.run(
      {"import", "mine", "--format", "yolo", "--intrinsics", "40,40,20,10", "--out", "data"});
  EXPECT_EQ(lens.code, 2);
  EXPECT_THAT(lens.err, HasSubstr("--intrinsics"));
  const Outcome none = program_.run({"import", "mine/images", "--format", "coco"});
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("no .json of annotations"));
}

TEST(AppLabelsReal, AnnotationsOfRoboflowScoredAgainstThemselvesAreAllFound) {
  const fs::path source = real_data() / "images/strawberry_masks_roboflow/train";
  if (!fs::exists(source)) GTEST_SKIP() << "no real captures at " << real_data();
  const Program program;
  ASSERT_EQ(program.run({"import", source.string(), "--format", "coco", "--out", "data"}).code, 0);
  using Json = nlohmann::json;
  Json found = Json::parse(read_file(program.path("data/000000/labels/boxes.json")));
  const Json names = Json::parse(read_file(program.path("data/000000/labels/pictures.json")));
  const Json &pictures = names["pictures"], &numbers = names["category_ids"];
  for (Json& entry : found) {
    const std::string file = pictures.at(entry["image_id"].get<std::size_t>())["file"];
    entry["image_id"] = fs::path(file).stem().string();
    entry["category_id"] = numbers.at(entry["category_id"].get<std::size_t>() - 1);
  }
  write_file(program.path("same.json"), found.dump());
  const Outcome score = program.run({"score", "data", "same.json"});
  ASSERT_EQ(score.code, 0) << score.err;
  const std::string rows = read_file(program.path("out/same_scores/scores.csv"));
  EXPECT_THAT(rows, AllOf(HasSubstr("mean of classes,same.json,AP50,1,"),
                          HasSubstr("mean of classes,same.json,mask_AP50,1,")));
}

}  // namespace
}  // namespace cousin
