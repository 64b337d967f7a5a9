#include "benchmarks/suites/program/program_suite.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>
#include <vector>

#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

fs::path script(const fs::path& folder, const std::string& lines) {
  const fs::path file = folder / "program";
  std::ofstream(file) << "#!/bin/sh\n" << lines;
  fs::permissions(file, fs::perms::owner_all);
  return file;
}

const ScoreRow& row_of(const ScoreFile& file, const std::string& metric) {
  for (const ScoreRow& row : file.scores) {
    if (row.metric == metric) return row;
  }
  throw std::runtime_error("no row " + metric);
}

TEST(ProgramSuite, MeasuresTheProcessItStarts) {
  const TemporaryFolder folder;
  // Only the run takes a while and memory, so the start must not.
  const fs::path program = script(folder.path(),
                                  "[ \"$1\" = --help ] && exit 0\n"
                                  "head -c 60000000 /dev/zero | tail -c 60000000 > /dev/null\n"
                                  "sleep 0.3\n");
  const std::vector<char> own(300'000'000, 1);
  const ScoreFile file = program_suite(program, folder.path());
  EXPECT_EQ(own.back(), 1);
  EXPECT_EQ(file.scores.size(), 3U);
  EXPECT_EQ(row_of(file, "seconds.start").n, 21);
  EXPECT_LT(row_of(file, "seconds.start").value, row_of(file, "seconds.wall").value);
  EXPECT_GE(row_of(file, "seconds.wall").value, 0.3);
  EXPECT_EQ(row_of(file, "seconds.wall").status, ScoreStatus::pass);
  EXPECT_GE(row_of(file, "peak_rss").value, 1e5);
  EXPECT_LE(row_of(file, "peak_rss").value, 1e8);  // a shell, whatever this process holds
  EXPECT_EQ(row_of(file, "peak_rss").status, ScoreStatus::pass);
}

TEST(ProgramSuite, AProgramThatFailsIsAnError) {
  const TemporaryFolder folder;
  const ScoreFile file = program_suite(script(folder.path(), "exit 3\n"), folder.path());
  for (const ScoreRow& row : file.scores) EXPECT_EQ(row.status, ScoreStatus::error) << row.metric;
}

TEST(ProgramSuite, AProgramThatCrashesNowAndThenIsAnError) {
  const TemporaryFolder folder;
  // The first start succeeds, the others die.
  const fs::path mark = folder.path() / "mark";
  const std::string lines =
      "[ -e " + mark.string() + " ] && kill -SEGV $$\n: > " + mark.string() + "\n";
  const ScoreFile file = program_suite(script(folder.path(), lines), folder.path());
  EXPECT_EQ(row_of(file, "seconds.start").status, ScoreStatus::error);
}

TEST(ProgramSuite, AProgramThatIsNotThereIsNamed) {
  const TemporaryFolder folder;
  EXPECT_THROW(program_suite(folder.path() / "nothing", folder.path()), std::runtime_error);
}

}  // namespace
}  // namespace cousin
