#include "benchmarks/seeds/suite.h"

#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "tests/dataset/temporary_folder.h"

namespace cousin {
namespace {

/// What a job left: one number far beyond its limit.
ShardResult beyond_its_limit() {
  ScoreRow row;
  row.suite = "seeds";
  row.scene = "pooled";
  row.case_name = "maize";
  row.method = "ours";
  row.metric = "length.rmse";
  row.value = 1;
  ShardResult result;
  result.name = "job0.json";
  result.text = to_json({.header = {}, .scores = {row}});
  return result;
}

TEST(SeedsSuite, NumbersAreHeldToLimitsOnlyWhenAllJobsAreThere) {
  ShardResult other;
  other.name = "job1.json";
  EXPECT_EQ(pool_seeds_suite({beyond_its_limit(), other}, {}).scores.at(0).status, ScoreStatus::ok);
  other.error = "no light";
  EXPECT_EQ(pool_seeds_suite({beyond_its_limit(), other}, {}).scores.at(0).status,
            ScoreStatus::fail);
}

TEST(SeedsSuite, AnotherMeshInTheSameFileIsMeasuredAnew) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "mine.obj";
  SeedsSuiteConfig config;
  config.quick = true;
  config.sets = {"specimen=mesh:" + file.string()};
  write_file(file, "v 0 0 0\n");
  const std::string key = seeds_suite_jobs(config).at(0).key;
  write_file(file, "v 0 0 1\n");
  EXPECT_NE(seeds_suite_jobs(config).at(0).key, key);
}

}  // namespace
}  // namespace cousin
