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
  const Json pictures =
      Json::parse(read_file(program.path("data/000000/labels/pictures.json")))["pictures"];
  for (Json& entry : found) {
    const std::string file = pictures.at(entry["image_id"].get<std::size_t>())["file"];
    entry["image_id"] = fs::path(file).stem().string();
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
