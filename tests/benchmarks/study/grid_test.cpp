#include "benchmarks/study/grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "benchmarks/study/shard.h"

namespace cousin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> names_of(const Grid& grid) {
  std::vector<std::string> names;
  for (const GridJob& job : jobs_of(grid)) names.push_back(job.name);
  return names;
}

TEST(Grid, IsTheProductOfItsFactorsOfWhichTheLastChangesFastest) {
  const Grid grid = {{"{cultivar}_run{run}",
                      {number_factor("run", 0, 2), key_factor("cultivar", {"a", "b"}),
                       key_factor("views", {"60"})}}};
  EXPECT_THAT(names_of(grid), ElementsAre("a_run0", "b_run0", "a_run1", "b_run1"));
  const GridJob job = jobs_of(grid)[3];
  EXPECT_THAT(job.sets, ElementsAre("cultivar=b", "views=60"));
  EXPECT_EQ(job.number("run"), 1);
  EXPECT_EQ(job.at("cultivar").word, "b");
  EXPECT_EQ(job.at("cultivar").level, 1U);
  EXPECT_TRUE(job.has("views"));
  EXPECT_FALSE(job.has("rig"));
}

TEST(Grid, HasItsBlocksOneAfterAnotherAndLeavesOutWhatIsNoPlace) {
  const Grid grid = {
      {"alone", {}},
      {"{x}{y}",
       {named_factor("x", {"a", "b"}), number_factor("y", 0, 3)},
       [](const GridJob& job) { return job.at("x").word == "a" || job.number("y") == 0; }},
      {"none", {number_factor("run", 1, 1)}}};
  EXPECT_THAT(names_of(grid), ElementsAre("alone", "a0", "a1", "a2", "b0"));
  EXPECT_EQ(jobs_of(grid)[0].block, 0U);
  EXPECT_EQ(jobs_of(grid)[4].block, 1U);
}

TEST(Grid, NamesAreThoseOfFilesAndLevelsNameOtherLevels) {
  const Grid grid = {{"{axis}, {far}",
                      {named_factor("axis", {"shape of it"}),
                       Factor{"far", {{"0.5", {"cousin.{axis}={far}", "seeds=1"}}}}}}};
  EXPECT_THAT(names_of(grid), ElementsAre("shape_of_it__0.5"));
  EXPECT_THAT(jobs_of(grid)[0].sets, ElementsAre("cousin.shape of it=0.5", "seeds=1"));
}

std::string grid_refusal(const Grid& grid) {
  try {
    jobs_of(grid);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Grid, RefusesNamesThatAreNotThereOrThereTwice) {
  EXPECT_THAT(grid_refusal({{"{x}_{y}", {named_factor("x", {"a"})}}}),
              testing::AllOf(HasSubstr("{x}_{y}"), HasSubstr("\"y\"")));
  EXPECT_THAT(grid_refusal({{"{x", {named_factor("x", {"a"})}}}), HasSubstr("{x"));
  EXPECT_THAT(grid_refusal({{"same", {}}, {"{x}", {named_factor("x", {"same"})}}}),
              HasSubstr("\"same\""));
  const GridJob job = jobs_of({{"{x}", {named_factor("x", {"a"})}}}).front();
  EXPECT_THROW(job.at("y"), std::invalid_argument);
  EXPECT_THROW(job.number("x"), std::invalid_argument);
}

TEST(Grid, AJobIsAPieceOfWorkInAFileOfItsName) {
  const ShardJob job = shard_of(jobs_of({{"{x}", {named_factor("x", {"a"})}}}).front(), "key",
                                [] { return std::string("text"); });
  EXPECT_EQ(job.name, "a.json");
  EXPECT_EQ(job.key, "key");
  EXPECT_EQ(job.run(), "text");
  EXPECT_EQ(job.grid.at("x").word, "a");
}

}  // namespace
}  // namespace cousin
