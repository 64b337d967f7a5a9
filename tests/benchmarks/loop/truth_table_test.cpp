#include <gtest/gtest.h>

#include "benchmarks/loop/truth_stages.h"

namespace cousin {
namespace {

TEST(TruthTable, EachStageHasItsTruthAndItsPicturesOrSaysWhyNot) {
  for (const StageRow& stage : stage_table()) {
    const TruthRow& row = truth_row(stage.name);
    EXPECT_NE(row.put == nullptr, row.why_none.empty()) << stage.name;
    EXPECT_NE(row.show == nullptr, row.why_not_shown.empty()) << stage.name;
    if (!row.put) continue;
    Stages stages;
    row.put(stages, SimulatedRun{}, SeedBoard{});
    EXPECT_TRUE(stage.is_there(stages)) << stage.name;
  }
  EXPECT_EQ(truth_table().size(), stage_table().size());
}

}  // namespace
}  // namespace cousin
