// Datasets of depth cameras, and scenes for other programs, as a user makes them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Two views of an empty board by a small D405.
Words tiny_d405() {
  return {"--set", "views=2",
          "--set", "seeds=0",
          "--set", "rig=d405",
          "--set", "rig.columns=424",
          "--set", "rig.color_columns=160",
          "--set", "rig.color_rows=120",
          "--set", "rig.color_focal_px=95",
          "--set", "render.irradiance_samples=16",
          "--set", "render.edge_samples=16",
          "--set", "render.board_texel_m=0.005",
          "--set", "render.max_bounces=0"};
}

std::set<std::string> folders(const fs::path& scene) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(scene)) {
    if (entry.is_directory()) names.insert(entry.path().filename().string());
  }
  return names;
}

TEST(AppDepthDataset, HoldsAllThatTheRigHasAndShardsMakeTheSame) {
  const Program program;
  const Words render = Words{"render", "seeds"} + tiny_d405();
  const Outcome whole = program.run(render + Words{"--out", "whole"});
  ASSERT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(folders(program.path("whole/000000")),
            (std::set<std::string>{"rgb", "ir_left", "ir_right", "depth", "truth"}));
  EXPECT_EQ(folders(program.path("whole/000000/truth")),
            (std::set<std::string>{"models", "noise_free_depth", "invalid_reason"}));
  EXPECT_EQ(program.run({"verify", "whole"}).code, 0);
  // The index is written by the first shard, before the second view is there.
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "0/2"}).code, 0);
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "1/2"}).code, 0);
  auto files = contents(program.path("data"));
  EXPECT_EQ(files.erase("manifest.0-of-2.json") + files.erase("manifest.1-of-2.json"), 2U);
  EXPECT_EQ(files, contents(program.path("whole")));
}

TEST(AppDepthDataset, OfDepthAloneHasNothingElseAndMethodsSayWhatTheyMiss) {
  const Program program;
  const Outcome rendered =
      program.run(Words{"render", "seeds", "--streams", "depth", "--out", "d"} + tiny_d405());
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  EXPECT_EQ(folders(program.path("d/000000")), (std::set<std::string>{"depth", "truth"}));
  const Outcome ours = program.run({"perceive", "d", "--out", "est"});
  EXPECT_EQ(ours.code, 3);
  EXPECT_THAT(ours.err, HasSubstr("the capture has no colour images"));
  const Outcome depth_only =
      program.run({"perceive", "d", "--out", "est", "--method", "depth_only"});
  EXPECT_EQ(depth_only.code, 2);
  EXPECT_THAT(depth_only.err, HasSubstr("knows_pose=true"));
}

TEST(AppDepthDataset, WhatARigDoesNotHaveIsRefused) {
  const Program program;
  const auto refusal = [&](const Words& words) {
    const Outcome outcome = program.run(words);
    EXPECT_EQ(outcome.code, 2) << words.back();
    return outcome.err;
  };
  EXPECT_THAT(refusal({"render", "seeds", "--streams", "depth"}),
              HasSubstr("rig phone_video_720p has no depth; it has color"));
  EXPECT_THAT(refusal({"render", "seeds", "--streams", "colour"}),
              HasSubstr("\"colour\" is not one of color, raw, infrared, depth, all"));
  EXPECT_THAT(refusal({"render", "seeds", "--truth", "invalid_reason"}),
              HasSubstr("\"invalid_reason\" is not what this capture has"));
  EXPECT_THAT(refusal({"run", "seeds", "--method", "sensor_depth", "--plan"}),
              HasSubstr("method sensor_depth reads color,depth; rig phone_video_720p has color"));
  EXPECT_THAT(refusal(Words{"render", "seeds", "--set", "depth_by=model"} + tiny_d405()),
              HasSubstr("needs a projector"));
}

TEST(AppExport, NamesWhatItCannotDo) {
  const Program program;
  const Outcome rendered =
      program.run(Words{"render", "seeds", "--streams", "depth", "--out", "d"} + tiny_d405());
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const Outcome format = program.run({"export", "d", "--format", "pcd"});
  EXPECT_EQ(format.code, 2);
  EXPECT_THAT(format.err, AllOf(HasSubstr("--format \"pcd\" is not one of bop, coco, yolo"),
                                HasSubstr("gltf, blend")));
  const Outcome no_pictures = program.run({"export", "d", "--format", "coco"});
  EXPECT_EQ(no_pictures.code, 3);
  EXPECT_THAT(no_pictures.err, HasSubstr("--truth visibility,instance"));
  const Outcome absent = program.run({"export", "absent", "--format", "gltf"});
  EXPECT_EQ(absent.code, 3);
  fs::rename(program.path("d/000000/truth"), program.path("truth"));
  const Outcome no_truth = program.run({"export", "d", "--format", "gltf"});
  EXPECT_EQ(no_truth.code, 3);
  EXPECT_THAT(no_truth.err, AllOf(HasSubstr("d/000000: there is no truth/"), HasSubstr("gltf")));
}

/// With Blender or without: a file that starts as such files do, or a message that says what to
/// install.
TEST(AppExport, WritesTheSceneOrSaysWhatIsMissing) {
  const Program program;
  ASSERT_EQ(
      program.run(Words{"render", "seeds", "--streams", "depth", "--out", "d"} + tiny_d405()).code,
      0);
  const Outcome exported = program.run({"export", "d", "--format", "gltf", "--out", "g"});
  if (exported.code != 0) {
    EXPECT_EQ(exported.code, 3) << exported.err;
    EXPECT_THAT(exported.err, HasSubstr("apt install blender"));
    GTEST_SKIP() << "Blender is not installed";
  }
  EXPECT_THAT(exported.err, HasSubstr("the print of \"board\""));
  EXPECT_EQ(read_file(program.path("g/000000.glb")).substr(0, 4), "glTF");
  EXPECT_EQ(contents(program.path("g")).size(), 1U);  // nothing else is left
}

}  // namespace
}  // namespace cousin
