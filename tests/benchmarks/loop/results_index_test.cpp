// The index of kept results is made of their tables.
#include "benchmarks/loop/results_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "benchmarks/score/scores.h"
#include "sim/dataset/atomic_file.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

ScoreRow row_of(ScoreStatus status) {
  ScoreRow row;
  row.metric = "error";
  row.status = status;
  return row;
}

TEST(ResultsIndex, ALineAFolderSaysWhatMadeItAndWhatItsLimitsSay) {
  const TemporaryFolder folder;
  const auto put = [&](const char* name, const std::vector<ScoreRow>& rows, const char* about) {
    write_file(folder.path() / name / "scores.csv", to_csv(rows));
    if (about != nullptr) write_file(folder.path() / name / "about.md", about);
  };
  put("b", {row_of(ScoreStatus::pass), row_of(ScoreStatus::fail), row_of(ScoreStatus::not_solved)},
      "`cousin bench b | c`,\ncommit 1\n\nWhat came of it.\n");
  put("a", {row_of(ScoreStatus::ok)}, nullptr);
  write_file(folder.path() / "README.md", "of another time");
  const std::vector<KeptResults> results = kept_results(folder.path());
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[0].name, "a");
  EXPECT_EQ(results[1].made_by, "`cousin bench b | c`, commit 1");
  const std::string index = results_index(results);
  EXPECT_THAT(index, AllOf(HasSubstr("1 of 2 limits are kept in 2 folders"),
                           HasSubstr("| [b](b/about.md) | `cousin bench b \\| c`, commit 1 | 3 | "
                                     "1 of 2 | 1 |"),
                           HasSubstr("| [a](a/scores.csv) |  | 1 | none | 0 |"),
                           Not(HasSubstr("What came of it"))));
  EXPECT_THAT(results_plot(results), AllOf(HasSubstr("<svg"), HasSubstr(">b</text>"),
                                           HasSubstr("1 of 2"), Not(HasSubstr(">a</text>"))));
}

TEST(ResultsIndex, ALongCommandIsCutAndItsCodeClosed) {
  const TemporaryFolder folder;
  write_file(folder.path() / "a" / "scores.csv", to_csv(std::vector<ScoreRow>{}));
  std::string about = "`cousin bench seeds --only first.json";
  for (int i = 0; i < 30; ++i) about += ",part" + std::to_string(i) + ".json";
  write_file(folder.path() / "a" / "about.md", about + "` (seed 1)\n\nfound\n");
  const std::string made_by = kept_results(folder.path()).at(0).made_by;
  EXPECT_LT(made_by.size(), 170U);
  EXPECT_THAT(made_by, testing::EndsWith(".json …`"));
}

TEST(ResultsIndex, ATableThatCannotBeReadIsNamed) {
  const TemporaryFolder folder;
  write_file(folder.path() / "a" / "scores.csv", "suite,scene\n");
  EXPECT_THAT([&] { kept_results(folder.path()); },
              ThrowsMessage<std::runtime_error>(HasSubstr("a/scores.csv")));
}

}  // namespace
}  // namespace cousin
