// Depth of a pair of cameras, as a user asks for it: from files, scored against the truth.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmarks/score/scores.h"
#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(AppStereo, DepthAloneIsScoredAndAnInterruptedChainIsNot) {
  const Program program;
  const Outcome rendered = program.run(
      Words{"render", "boards", "--frames", "1", "--seed", "3", "--set", "rig=zed_hd720", "--set",
            "render.pixel_samples=1", "--truth", "depth", "--out", "data"});
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const Outcome made = program.run(
      Words{"perceive", "data", "--pipeline", "stereo", "--method", "opencv", "--out", "depth"});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.err + made.out, HasSubstr("1 of 1 frames have depth"));

  const Outcome scored = program.run(Words{"score", "data", "depth", "--out", "scores"});
  ASSERT_EQ(scored.code, 0) << scored.err;
  EXPECT_THAT(scored.err, HasSubstr("depth alone"));
  const ScoreFile file = scores_from_json(read_file(program.path("scores/scores.json")), "scores");
  double relative = ScoreRow::kNone;
  for (const ScoreRow& row : file.scores) {
    if (row.case_name == "all" && row.metric == "depth.error_relative") relative = row.value;
  }
  EXPECT_LT(relative, 0.05);  // a unit's calibration alone is 2 % at this distance

  const Outcome aligned =
      program.run(Words{"score", "data", "depth", "--align", "--out", "aligned"});
  EXPECT_NE(aligned.code, 0);

  // What was left before its traits is no pipeline of depth.
  write_file(program.path("depth/000000/boxes.json"), "[]\n");
  const Outcome left = program.run(Words{"score", "data", "depth", "--out", "left"});
  EXPECT_NE(left.code, 0);
  EXPECT_THAT(left.err, HasSubstr("traits.json"));
}

TEST(AppStereo, OneCameraIsRefusedByName) {
  const Program program;
  ASSERT_EQ(program
                .run(Words{"render", "boards", "--frames", "1", "--set", "render.pixel_samples=1",
                           "--out", "data"})
                .code,
            0);
  const Outcome made =
      program.run(Words{"perceive", "data", "--pipeline", "stereo", "--out", "depth"});
  EXPECT_NE(made.code, 0);
  EXPECT_THAT(made.err, HasSubstr("pair of cameras"));
  EXPECT_FALSE(fs::exists(program.path("depth/000000/depth")));
}

}  // namespace
}  // namespace cousin
