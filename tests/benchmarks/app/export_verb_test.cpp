// A dataset handed over to other programs and taken back, as a user does it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const char* const kFormats[] = {"bop", "coco",   "yolo", "colmap", "nerfstudio",
                                "tum", "opencv", "ros",  "kalibr", "mrcal"};

/// Three trays of four cells, two small photographs each, with all that labels need.
Words labelled_trays() {
  return Words{"render", "seedlings", "--scenes", "3", "--out", "data"} +
         Words{"--truth", "visibility,instance,keypoints", "--set", "day=9"} + tiny_tray();
}

TEST(AppExport, HelpSaysWhatEachFormatGives) {
  const std::string help = Program().run({"export", "--help"}).out;
  for (const char* format : kFormats) EXPECT_THAT(help, HasSubstr("\n  " + std::string(format)));
  EXPECT_THAT(help, AllOf(HasSubstr("gltf"), HasSubstr("--undistort"), HasSubstr("--true-cameras"),
                          HasSubstr("--split"), HasSubstr("visible_fraction")));
  EXPECT_THAT(Program().run({"import", "--help"}).out,
              AllOf(HasSubstr("colmap"), HasSubstr("tum"), HasSubstr("nerfstudio"),
                    HasSubstr("rgbd"), HasSubstr("stereo"), HasSubstr("--length-unit")));
}

TEST(AppExport, EveryFormatOfASeedlingDatasetIsMadeAndComesBack) {
  const Program program;
  ASSERT_EQ(program.run(labelled_trays()).code, 0);
  for (const std::string format : kFormats) {
    // The phone's lens has what some formats do not hold; its poses are the truth's alone.
    const Outcome exported = program.run({"export", "data", "--format", format, "--undistort",
                                          "--true-cameras", "--out", format, "--json"});
    ASSERT_EQ(exported.code, 0) << format << exported.err;
    EXPECT_EQ(nlohmann::json::parse(exported.out)["pictures"], 6) << format;
  }
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");  // exports stay outside
  const nlohmann::json coco =
      nlohmann::json::parse(read_file(program.path("coco/annotations/train.json")));
  EXPECT_EQ(coco["categories"][0]["name"], "watermelon");
  EXPECT_GT(coco["annotations"].size(), 0U);
  EXPECT_FALSE(coco["categories"][0]["keypoints"].empty());

  for (const std::string format : {"colmap", "nerfstudio", "tum"}) {
    const Outcome imported =
        program.run({"import", format + "/000001", "--format", format, "--out", "back_" + format});
    ASSERT_EQ(imported.code, 0) << imported.err;
    EXPECT_EQ(read_capture(program.path("back_" + format + "/000000")).frames.size(), 2U);
    EXPECT_EQ(program.run({"verify", "back_" + format}).code, 0);
  }
  // A capture without truth is handed over too, with the cameras that it reports.
  const Outcome again = program.run({"export", "back_tum", "--format", "colmap", "--out", "again"});
  EXPECT_EQ(again.code, 0) << again.err;
}

TEST(AppExport, RefusalsNameTheFormatTheLensAndWhatHelps) {
  const Program program;
  ASSERT_EQ(program.run(labelled_trays()).code, 0);
  const auto refused = [&](const Words& more) {
    const Outcome outcome = program.run(Words{"export", "data", "--out", "no"} + more);
    EXPECT_NE(outcome.code, 0);
    return outcome.err;
  };
  EXPECT_THAT(refused({"--format", "voc"}),
              AllOf(HasSubstr("--format \"voc\" is not one of bop"), HasSubstr("gltf, blend")));
  EXPECT_THAT(refused({"--format", "bop"}), HasSubstr("--undistort"));
  EXPECT_THAT(refused({"--format", "colmap"}), HasSubstr("--true-cameras"));
  EXPECT_THAT(refused({"--format", "yolo", "--task", "cut"}), HasSubstr("detect, segment, pose"));
  EXPECT_THAT(refused({"--format", "coco", "--split", "1,1,1"}), HasSubstr("add up to 1"));
  EXPECT_THAT(refused({"--format", "coco", "--masks", "png"}), HasSubstr("rle, polygon"));
}

}  // namespace
}  // namespace cousin
