#include "benchmarks/study/shard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

class ShardFolder : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) /
        ("shards_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::vector<ShardJob> jobs(int count, const std::string& key = "k") {
    std::vector<ShardJob> result;
    for (int i = 0; i < count; ++i) {
      result.push_back({"job" + std::to_string(i) + ".json", key, [this, i] {
                          ++calls_;
                          return "result " + std::to_string(i);
                        }});
    }
    return result;
  }
  fs::path folder_;
  int calls_ = 0;
};

TEST(Shard, RangesCoverTheListOnceWithSizesThatDifferByOne) {
  for (const int size : {0, 1, 7, 60, 1000}) {
    for (const int count : {1, 2, 3, 7, 64}) {
      int next = 0;
      for (int i = 0; i < count; ++i) {
        const auto [first, end] = shard_range({i, count}, size);
        EXPECT_EQ(first, next);
        EXPECT_GE(end - first, size / count);
        EXPECT_LE(end - first, size / count + 1);
        next = end;
      }
      EXPECT_EQ(next, size);
    }
  }
}

TEST(Shard, RefusesTextThatIsNoShard) {
  EXPECT_EQ(parse_shard("2/5").index, 2);
  EXPECT_EQ(parse_shard("").count, 1);
  for (const char* text : {"5/5", "-1/5", "1", "1/0", "a/b", "1/2x", "/", "1/999999999999"}) {
    EXPECT_THROW(parse_shard(text), std::invalid_argument) << text;
  }
}

TEST_F(ShardFolder, PartOfANameChoosesJobs) {
  EXPECT_EQ(jobs_named(jobs(12), "").size(), 12U);
  std::vector<ShardJob> named = jobs(12);
  named[3].name = "maize_splats.json";
  named[7].name = "rice_splats.json";
  const std::vector<ShardJob> chosen = jobs_named(named, "_splats");
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[1].name, "rice_splats.json");
  const std::vector<ShardJob> either = jobs_named(named, "rice_,maize_");
  ASSERT_EQ(either.size(), 2U);
  EXPECT_EQ(either[0].name, "maize_splats.json");
  try {
    jobs_named(named, "barley");
    FAIL() << "a name that no job has";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("barley"));
    EXPECT_THAT(error.what(), testing::HasSubstr(named[0].name));
  }
  EXPECT_TRUE(jobs_named({}, "anything").empty());
}

TEST_F(ShardFolder, FinishedJobsAreNotRunAgain) {
  run_shards(folder_, jobs(4), {});
  EXPECT_EQ(calls_, 4);
  const auto again = run_shards(folder_, jobs(4), {});
  EXPECT_EQ(calls_, 4);
  EXPECT_EQ(again[3].text, "result 3");
  EXPECT_TRUE(again[3].reused);
}

TEST_F(ShardFolder, WhatAJobWouldGoOnFromIsRemovedWithItsResult) {
  std::vector<ShardJob> both = jobs(2);
  for (ShardJob& job : both) {
    job.unfinished = folder_ / "unfinished" / job.name;
    fs::create_directories(job.unfinished);
  }
  both[1].run = []() -> std::string { throw std::runtime_error("stopped half way"); };
  run_shards(folder_, both, {});
  EXPECT_FALSE(fs::exists(both[0].unfinished));
  EXPECT_TRUE(fs::exists(both[1].unfinished));
}

TEST_F(ShardFolder, AnotherKeyOrADamagedFileIsMadeAnew) {
  run_shards(folder_, jobs(2), {});
  run_shards(folder_, jobs(2, "other"), {});
  EXPECT_EQ(calls_, 4);
  std::ofstream(folder_ / "job0.json") << "half a li";  // as a foreign writer would leave it
  EXPECT_EQ(run_shards(folder_, jobs(2, "other"), {})[0].text, "result 0");
  EXPECT_EQ(calls_, 5);
}

TEST_F(ShardFolder, ShardsTogetherGiveWhatOneRunGives) {
  run_shards(folder_, jobs(5), {0, 2});
  const auto merged = run_shards(folder_, jobs(5), {1, 2});
  EXPECT_EQ(calls_, 5);
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(merged[static_cast<std::size_t>(i)].text, "result " + std::to_string(i));
}

TEST_F(ShardFolder, WhatAnotherShardFinishesMeanwhileIsThereAtTheEnd) {
  auto list = jobs(4);
  list[3].run = [this] {  // the other shard ends its first job during this shard's last one
    auto others = jobs(4);
    others[1].run = []() -> std::string { throw std::runtime_error("stopped"); };
    run_shards(folder_, others, {0, 2});
    return std::string("result 3");
  };
  const auto results = run_shards(folder_, list, {1, 2});
  EXPECT_EQ(results[0].text, "result 0");
  EXPECT_TRUE(results[0].reused);
  EXPECT_FALSE(is_missing(results[0]));
  EXPECT_TRUE(is_missing(results[1]));
  EXPECT_EQ(results[3].text, "result 3");
  EXPECT_FALSE(results[3].reused);
}

TEST_F(ShardFolder, AFailedJobIsNotMissing) {
  auto list = jobs(2);
  list[0].run = []() -> std::string { throw std::runtime_error("no light"); };
  const auto results = run_shards(folder_, list, {0, 2});
  EXPECT_FALSE(is_missing(results[0]));
  EXPECT_TRUE(is_missing(results[1]));
}

TEST_F(ShardFolder, AJobThatThrowsIsRecordedAndTheRestGoesOn) {
  auto list = jobs(3);
  list[1].run = []() -> std::string { throw std::runtime_error("no light"); };
  const auto results = run_shards(folder_, list, {});
  EXPECT_EQ(results[1].error, "no light");
  EXPECT_EQ(results[2].text, "result 2");
  EXPECT_FALSE(fs::exists(folder_ / "job1.json"));
}

TEST_F(ShardFolder, AResultThatCannotBeWrittenIsReturnedAndReported) {
  std::ofstream(folder_) << "a file where the folder would be";
  const auto results = run_shards(folder_ / "below", jobs(2), {});
  EXPECT_EQ(calls_, 2);
  EXPECT_EQ(results[1].text, "result 1");
  EXPECT_NE(results[1].error.find("below: cannot make the folder"), std::string::npos);
  EXPECT_TRUE(results[1].failure);
}

TEST_F(ShardFolder, APartThatWasCutOffAnywhereIsMadeAgain) {
  int runs = 0;
  const std::vector<ShardJob> jobs = {{"part.json", "key", [&] {
                                         ++runs;
                                         return std::string("{\"rows\": []}\n");
                                       }}};
  ASSERT_EQ(run_shards(folder_, jobs, {})[0].text, "{\"rows\": []}\n");
  const std::string whole = read_file(folder_ / "part.json");
  EXPECT_TRUE(is_finished(folder_, jobs[0]));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write_file(folder_ / "part.json", whole.substr(0, length));
    EXPECT_FALSE(is_finished(folder_, jobs[0])) << length;
  }
  write_file(folder_ / "part.json", whole.substr(0, whole.find('\n') + 1));  // the key's line alone
  EXPECT_EQ(run_shards(folder_, jobs, {})[0].text, "{\"rows\": []}\n");
  EXPECT_EQ(runs, 2);
  EXPECT_EQ(read_file(folder_ / "part.json"), whole);
}

}  // namespace
}  // namespace cousin
