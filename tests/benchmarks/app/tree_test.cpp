// Count and yield of a tree, as a user asks for it: in one command, and in three from files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmarks/score/scores.h"
#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Four views of a coarse small tree, two from each alley.
Words whole_tree() {
  Words words = {"--frames", "4", "--seed", "2"};
  for (const char* set : {"look=tree", "depth_by=model", "trees=1", "rows=1", "fruits=12",
                          "neighbours=0", "orchard.branch.count=8", "orchard.branch.last_share=0.6",
                          "orchard.leaf.teeth=0", "orchard.ground.reach_m=0"})
    words = words + Words{"--set", set};
  return words;
}

double value_of_tree(const ScoreFile& file, const std::string& metric) {
  for (const ScoreRow& row : file.scores) {
    if (row.metric == metric) return row.value;
  }
  return ScoreRow::kNone;
}

SpecimenRow tree_row(const ScoreFile& file, const std::string& trait) {
  for (const SpecimenRow& row : file.specimens) {
    if (row.cultivar == "tree" && row.trait == trait) return row;
  }
  return {};
}

TEST(AppTree, OneCommandCountsItsFruitsOnceAndFilesGiveTheSame) {
  const Program program;
  const Outcome run =
      program.run(Words{"run", "apples", "--pipeline", "tree", "--out", "tree"} + whole_tree());
  ASSERT_EQ(run.code, 0) << run.err;
  const ScoreFile file = scores_from_json(read_file(program.path("tree/scores.json")), "scores");
  const SpecimenRow count = tree_row(file, "fruit_count"), yield = tree_row(file, "yield");
  EXPECT_GT(count.truth, 6);
  ASSERT_EQ(count.status, ScoreStatus::ok);
  EXPECT_NEAR(count.measured, count.truth, 1.5);
  EXPECT_NEAR(yield.measured, yield.truth, 0.2 * yield.truth);
  EXPECT_LE(value_of_tree(file, "fruits.doubled"), 1);
  EXPECT_LE(value_of_tree(file, "fruits.missed"), 1);

  const Words render = {"render",  "apples",         "--out",     "data",
                        "--truth", "depth,instance", "--streams", "depth"};
  ASSERT_EQ(program.run(render + whole_tree()).code, 0);
  ASSERT_EQ(program
                .run({"perceive", "data", "--pipeline", "tree", "--out", "est", "--stage",
                      "boxes=dir:tree/estimate", "--stage", "poses=dir:tree/estimate"})
                .code,
            0);
  for (const char* seam : {"traits.json", "tracks.json", "fits.json"}) {
    EXPECT_EQ(read_file(program.path("est/000000") / seam),
              read_file(program.path("tree/estimate/000000") / seam))
        << seam;
  }
  ASSERT_EQ(program.run({"score", "data", "est"}).code, 0);
  const ScoreFile scored = scores_from_json(read_file(program.path("est/scores.json")), "scores");
  EXPECT_DOUBLE_EQ(tree_row(scored, "yield").measured, yield.measured);
}

TEST(AppTree, ABoxForEachViewCountsFruitsTwiceAndPosesAreAskedFor) {
  const Program program;
  const Outcome run = program.run(
      Words{"run", "apples", "--pipeline", "tree", "--method", "boxes", "--out", "boxes"} +
      whole_tree());
  ASSERT_EQ(run.code, 0) << run.err;
  const ScoreFile file = scores_from_json(read_file(program.path("boxes/scores.json")), "scores");
  EXPECT_GT(tree_row(file, "fruit_count").measured, 1.3 * tree_row(file, "fruit_count").truth);
  EXPECT_GT(value_of_tree(file, "fruits.doubled"), 2);
  // A detector that misses half of all boxes still sees most fruits in one view of the four.
  const Outcome missed = program.run(Words{"run", "apples", "--pipeline", "tree", "--set",
                                           "boxes.missed=0.5", "--set", "boxes.edge_sigma_px=0.5",
                                           "--set", "boxes.false_boxes=0.5", "--out", "missed"} +
                                     whole_tree());
  ASSERT_EQ(missed.code, 0) << missed.err;
  const ScoreFile seen = scores_from_json(read_file(program.path("missed/scores.json")), "scores");
  EXPECT_GT(value_of_tree(seen, "fruits.missed"), value_of_tree(file, "fruits.missed"));
  EXPECT_NEAR(tree_row(seen, "fruit_count").measured, tree_row(seen, "fruit_count").truth, 7);
  const Outcome none =
      program.run({"run", "apples", "--set", "look=tree", "--set", "occlusion=0.5", "--plan"});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, AllOf(HasSubstr("occlusion"), HasSubstr("look = tree")));
}

}  // namespace
}  // namespace cousin
