// How heavy apples are, as a user asks for it: in one command, and in three from files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmarks/score/scores.h"
#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Two views of a coarse small tree before a D455, each of a free fruit.
Words small_tree() {
  Words words = {"--frames", "2", "--seed", "2"};
  for (const char* set :
       {"depth_by=model", "trees=1", "rows=1", "fruits=8", "neighbours=0", "occlusion=0",
        "distance_min_m=0.4", "distance_max_m=0.6", "orchard.branch.count=8",
        "orchard.branch.last_share=0.6", "orchard.leaf.teeth=0", "orchard.ground.reach_m=0"})
    words = words + Words{"--set", set};
  return words;
}

double value_of_apples(const std::vector<ScoreRow>& rows, const std::string& metric,
                       const std::string& name) {
  for (const ScoreRow& row : rows) {
    if (row.metric == metric && row.case_name == name) return row.value;
  }
  return ScoreRow::kNone;
}

TEST(AppApples, OneCommandMeasuresThemAndFilesGiveTheSame) {
  const Program program;
  const Outcome run = program.run(Words{"run", "apples", "--out", "apples"} + small_tree());
  ASSERT_EQ(run.code, 0) << run.err;
  const ScoreFile file = scores_from_json(read_file(program.path("apples/scores.json")), "scores");
  EXPECT_GE(value_of_apples(file.scores, "boxes.found", "run"), 2);
  EXPECT_EQ(value_of_apples(file.scores, "boxes.missed", "run"), 0);
  EXPECT_GE(value_of_apples(file.scores, "mass.measured", "unoccluded"), 1);
  EXPECT_LT(value_of_apples(file.scores, "mass.mape", "unoccluded"), 0.1);

  // The same from files, with the boxes of the run as somebody's.
  const Words render = {"render",    "apples",  "--out",
                        "data",      "--truth", "depth,instance,visibility",
                        "--streams", "depth"};
  ASSERT_EQ(program.run(render + small_tree()).code, 0);
  ASSERT_EQ(
      program.run({"perceive", "data", "--out", "est", "--stage", "boxes=dir:apples/estimate"})
          .code,
      0);
  for (const char* seam : {"traits.json", "fits.json", "boxes.json"}) {
    EXPECT_EQ(read_file(program.path("est/000000") / seam),
              read_file(program.path("apples/estimate/000000") / seam))
        << seam;
  }
  ASSERT_EQ(program.run({"score", "data", "est"}).code, 0);
  const ScoreFile scored = scores_from_json(read_file(program.path("est/scores.json")), "scores");
  EXPECT_DOUBLE_EQ(value_of_apples(scored.scores, "mass.mape", "unoccluded"),
                   value_of_apples(file.scores, "mass.mape", "unoccluded"));
}

TEST(AppApples, OnlyDepthIsRenderedAndMethodsAreChosenByName) {
  const Program program;
  const Outcome plan = program.run({"run", "apples", "--method", "paper", "--plan"});
  EXPECT_EQ(plan.code, 0);
  EXPECT_THAT(plan.out, AllOf(HasSubstr("true ones: the pipeline has no stage of its own for it"),
                              HasSubstr("truth: visibility")));
  const Outcome blind = program.run({"run", "apples", "--set", "rig=dslr_apsc_24mp"});
  EXPECT_EQ(blind.code, 2);
  EXPECT_THAT(blind.err, HasSubstr("method ours reads depth"));
  const Outcome other = program.run({"run", "apples", "--method", "moon"});
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, AllOf(HasSubstr("--method moon"), HasSubstr("ours, paper")));
}

}  // namespace
}  // namespace cousin
