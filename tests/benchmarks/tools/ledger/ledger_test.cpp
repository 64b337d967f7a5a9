// The ledger: a file that only grows, whose lines are as old as the commits that added them.
#include "benchmarks/tools/ledger/ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/process/program_run.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Prediction fox(const std::string& id = "fox-depth") {
  return {id, "multiview/fox", "share of pixels with a depth", "1", 0.4, 0.6, "as the chair has"};
}

std::string refusal_of(const fs::path& file, const LedgerEntry& entry) {
  try {
    append_to_ledger(file, entry);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Ledger, EntriesComeBackInOrder) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "docs/ledger.jsonl";
  append_to_ledger(file, SeenSet{"images/rice", "its results are in docs/results/real"});
  append_to_ledger(file, fox());
  append_to_ledger(file, LedgerOutcome{"fox-depth", 0.45, "cousin bench real"});
  const std::vector<LedgerEntry> entries = read_ledger(file);
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(std::get<SeenSet>(entries[0]).set, "images/rice");
  EXPECT_EQ(std::get<Prediction>(entries[1]).high, 0.6);
  EXPECT_EQ(std::get<Prediction>(entries[1]).why, "as the chair has");
  EXPECT_EQ(std::get<LedgerOutcome>(entries[2]).value, 0.45);
}

TEST(Ledger, LinesThatDoNotFitAreRefusedAndTheFileStays) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "ledger.jsonl";
  append_to_ledger(file, fox());
  const std::string before = read_file(file);
  EXPECT_THAT(refusal_of(file, fox()), HasSubstr("line 2 has the prediction \"fox-depth\" again"));
  EXPECT_THAT(refusal_of(file, LedgerOutcome{"maize", 1, "x"}),
              HasSubstr("the outcome of no prediction above, \"maize\""));
  Prediction turned = fox("turned");
  std::swap(turned.low, turned.high);
  EXPECT_THAT(refusal_of(file, turned), HasSubstr("\"low\" is not below \"high\""));
  Prediction unsaid = fox("unsaid");
  unsaid.why.clear();
  EXPECT_THAT(refusal_of(file, unsaid), HasSubstr("\"why\" is no text"));
  EXPECT_THAT(refusal_of(file, fox("two words")), HasSubstr("letters, digits, - and _"));
  EXPECT_EQ(read_file(file), before);
  write_file(file, before + R"({"seen": "a", "why": "b", "when": "c"})");
  EXPECT_THAT(error_of([&] { read_ledger(file); }),
              AllOf(HasSubstr("ledger.jsonl: line 2"), HasSubstr("unknown key \"when\"")));
  write_file(file, "{");
  EXPECT_THAT(error_of([&] { read_ledger(file); }), HasSubstr("line 1 is not JSON"));
}

/// Commits are letters here, older ones first.
bool is_earlier(const std::string& older, const std::string& newer) { return older < newer; }

std::vector<LedgerStatus> statuses(const std::vector<LedgerEntry>& entries,
                                   const std::vector<std::string>& commits) {
  std::vector<LedgerStatus> all;
  for (const LedgerRow& row : judge_ledger(entries, commits, is_earlier)) all.push_back(row.status);
  return all;
}

TEST(Ledger, AnOutcomeCountsOnlyWhereItsPredictionIsOlder) {
  const LedgerEntry prediction = fox();
  const LedgerEntry inside = LedgerOutcome{"fox-depth", 0.6, "c"};
  const LedgerEntry outside = LedgerOutcome{"fox-depth", 0.61, "c"};
  EXPECT_THAT(statuses({prediction}, {"a"}), ElementsAre(LedgerStatus::open));
  EXPECT_THAT(statuses({prediction}, {""}), ElementsAre(LedgerStatus::not_committed));
  EXPECT_THAT(statuses({prediction, inside}, {"a", "b"}), ElementsAre(LedgerStatus::kept));
  EXPECT_THAT(statuses({prediction, outside}, {"a", "b"}), ElementsAre(LedgerStatus::missed));
  EXPECT_THAT(statuses({prediction, inside}, {"a", ""}), ElementsAre(LedgerStatus::kept));
  EXPECT_THAT(statuses({prediction, inside}, {"a", "a"}), ElementsAre(LedgerStatus::not_older));
  EXPECT_THAT(statuses({prediction, inside}, {"b", "a"}), ElementsAre(LedgerStatus::not_older));
}

TEST(Ledger, APredictionOfASetThatWasSeenIsNotBlind) {
  const LedgerEntry seen = SeenSet{"multiview/fox", "measured"};
  EXPECT_THAT(statuses({seen, fox()}, {"a", "b"}), ElementsAre(LedgerStatus::seen));
  EXPECT_THAT(statuses({fox(), seen}, {"a", "b"}), ElementsAre(LedgerStatus::open));
  // Its own outcome is such a sight.
  const LedgerEntry outcome = LedgerOutcome{"fox-depth", 0.5, "c"};
  EXPECT_THAT(statuses({fox(), outcome, fox("again")}, {"a", "b", "c"}),
              ElementsAre(LedgerStatus::kept, LedgerStatus::seen));
}

/// A line that was put above others later is not older than they are.
TEST(Ledger, APlaceInTheFileIsNoDate) {
  const LedgerEntry outcome = LedgerOutcome{"fox-depth", 0.5, "c"};
  const LedgerEntry late = LedgerOutcome{"again", 0.5, "c"};
  EXPECT_THAT(statuses({fox("again"), fox(), outcome, late}, {"c", "a", "b", "d"}),
              ElementsAre(LedgerStatus::seen, LedgerStatus::kept));
}

bool git(const fs::path& folder, std::vector<std::string> words) {
  std::vector<std::string> all = {"git",         "-C", folder.string(),   "-c",
                                  "user.name=a", "-c", "user.email=a@b.c"};
  all.insert(all.end(), words.begin(), words.end());
  return succeeded(run_program({.words = all, .log = folder / "log"}));
}

TEST(Ledger, CommitsOfLinesAreGits) {
  if (find_program("git").empty()) GTEST_SKIP() << "there is no git";
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "ledger.jsonl";
  ASSERT_TRUE(git(folder.path(), {"init", "-q"}));
  append_to_ledger(file, fox());
  EXPECT_THAT(commits_of_lines(file), ElementsAre(""));  // before there is any commit
  ASSERT_TRUE(git(folder.path(), {"add", "ledger.jsonl"}));
  ASSERT_TRUE(git(folder.path(), {"commit", "-q", "-m", "predicted"}));
  append_to_ledger(file, LedgerOutcome{"fox-depth", 0.5, "c"});
  ASSERT_TRUE(git(folder.path(), {"commit", "-q", "-a", "-m", "measured"}));
  append_to_ledger(file, fox("later"));
  const std::vector<std::string> commits = commits_of_lines(file);
  ASSERT_EQ(commits.size(), 3U);
  EXPECT_NE(commits[0], commits[1]);
  EXPECT_EQ(commits[2], "");
  const IsOlder is_older = is_older_in(folder.path());
  EXPECT_TRUE(is_older(commits[0], commits[1]));
  EXPECT_FALSE(is_older(commits[1], commits[0]));
  EXPECT_FALSE(is_older(commits[0], commits[0]));
  const std::vector<LedgerRow> rows = judge_ledger(read_ledger(file), commits, is_older);
  EXPECT_EQ(rows[0].status, LedgerStatus::kept);
}

}  // namespace
}  // namespace cousin
