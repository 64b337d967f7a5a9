#include "benchmarks/study/shard_scores.h"

#include <gtest/gtest.h>

namespace cousin {
namespace {

TEST(ShardScores, AFailedJobIsAnErrorRowAndTheOthersStay) {
  ScoreFile one;
  ScoreRow row;
  row.metric = "seconds";
  row.value = 2;
  one.scores = {row};
  ShardResult good{"a.json", to_json(one), {}, {}, false}, bad{"b.json", {}, "no light", {}, false};
  ShardResult missing{"c.json", {}, {}, {}, false};
  const ScoreFile pooled = scores_of_shards({good, bad, missing}, "sensors", 5);
  ASSERT_EQ(pooled.scores.size(), 2U);
  EXPECT_EQ(pooled.scores[0].value, 2);
  EXPECT_EQ(pooled.scores[1].status, ScoreStatus::error);
  EXPECT_EQ(pooled.scores[1].metric, "no light");
  EXPECT_EQ(pooled.scores[1].case_name, "b.json");
  EXPECT_EQ(pooled.scores[1].seed, 5U);
}

TEST(ShardScores, MachinesOfKeptJobsAreNamedOnce) {
  ShardResult jobs[3];
  for (int i = 0; i < 3; ++i) {
    ScoreFile file;
    file.header.machine = i == 1 ? "B, 4 cores" : "A, 2 cores";
    jobs[i] = {std::to_string(i) + ".json", to_json(file), {}, {}, false};
  }
  const ShardResult unknown{"old.json", to_json(ScoreFile{}), {}, {}, false};
  EXPECT_EQ(scores_of_shards({jobs[0], jobs[2]}, "splats", 1).header.machine, "A, 2 cores");
  EXPECT_EQ(scores_of_shards({jobs[0], unknown}, "splats", 1).header.machine,
            "A, 2 cores and unknown");
  EXPECT_EQ(scores_of_shards({jobs[0], jobs[1], jobs[2]}, "splats", 1).header.machine,
            "A, 2 cores and B, 4 cores");
}

}  // namespace
}  // namespace cousin
