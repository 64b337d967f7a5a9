#include "sim/process/program_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "sim/process/scratch_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ProgramRun, WordsReachTheProgramAsTheyAreWithoutAShell) {
  const ScratchFolder folder("cousin-test");
  const std::string hostile = "a b;$(touch " + (folder.path() / "made").string() + ") 'q' \"r\" *";
  const ProgramOutcome outcome =
      run_program({.words = {"printf", "[%s]", hostile, ""}, .log = folder.path() / "log"});
  EXPECT_TRUE(succeeded(outcome)) << outcome.reason;
  EXPECT_EQ(text_of(folder.path() / "log"), "[" + hostile + "][]");
  EXPECT_FALSE(fs::exists(folder.path() / "made"));
}

TEST(ProgramRun, TheLogHoldsBothStreamsAndNothingOfAnEarlierRun) {
  const ScratchFolder folder("cousin-test");
  const fs::path log = folder.path() / "log";
  std::ofstream(log) << "what another run left, which is longer than what comes";
  run_program({.words = {"sh", "-c", "echo out; echo err >&2"}, .log = log});
  EXPECT_EQ(text_of(log), "out\nerr\n");
}

TEST(ProgramRun, AVariableIsSetInTheProgramBesideOurs) {
  const ScratchFolder folder("cousin-test");
  const fs::path log = folder.path() / "log";
  run_program({.words = {"sh", "-c", "echo $COUSIN_X; test -n \"$PATH\" && echo path"},
               .environment = {{"COUSIN_X", "a=b c"}},
               .log = log});
  EXPECT_EQ(text_of(log), "a=b c\npath\n");
}

TEST(ProgramRun, EachEndIsToldApartAndNamesTheProgram) {
  const fs::path log = "/dev/null";
  const ProgramOutcome failed = run_program({.words = {"sh", "-c", "exit 7"}, .log = log});
  EXPECT_EQ(failed.end, ProgramEnd::exited);
  EXPECT_EQ(failed.code, 7);
  EXPECT_EQ(failed.reason, "\"sh\" exited with 7");
  const ProgramOutcome killed = run_program({.words = {"sh", "-c", "kill -TERM $$"}, .log = log});
  EXPECT_EQ(killed.end, ProgramEnd::signalled);
  EXPECT_EQ(killed.code, SIGTERM);
  const ProgramOutcome absent = run_program({.words = {"no-such-program"}, .log = log});
  EXPECT_EQ(absent.end, ProgramEnd::not_started);
  EXPECT_THAT(absent.reason, HasSubstr("cannot start \"no-such-program\""));
  EXPECT_THROW(run_program({}), std::invalid_argument);
  EXPECT_THROW(run_program({.words = {"true"}, .log = "/no/such/folder/log"}), std::runtime_error);
}

TEST(ProgramRun, AProgramThatDoesNotEndIsStoppedAtItsTimeLimit) {
  const ProgramOutcome outcome =
      run_program({.words = {"sleep", "1000"}, .log = "/dev/null", .time_limit_s = 0.05});
  EXPECT_EQ(outcome.end, ProgramEnd::timed_out);
  EXPECT_THAT(outcome.reason, HasSubstr("time limit of 0.05 s"));
  EXPECT_GE(outcome.wall_s, 0.05);
  EXPECT_TRUE(succeeded(run_program({.words = {"true"}, .log = "/dev/null", .time_limit_s = 100})));
}

TEST(ProgramRun, ABareNameIsLookedUpInPathAndAnotherIsTheFile) {
  EXPECT_TRUE(find_program("sh").has_parent_path());
  EXPECT_EQ(find_program(find_program("sh").string()), find_program("sh"));
  EXPECT_EQ(find_program("no-such-program"), fs::path());
  EXPECT_EQ(find_program("/etc/passwd"), fs::path());  // there, but not executable
  EXPECT_EQ(find_program("/"), fs::path());
  EXPECT_EQ(find_program(""), fs::path());
}

TEST(ProgramRun, LastLinesOfALongLogAreItsEnd) {
  const ScratchFolder folder("cousin-test");
  const fs::path log = folder.path() / "log";
  {
    std::ofstream out(log);
    for (int i = 0; i < 100000; ++i) out << "line " << i << "\n\n";
    out << std::string(1000, 'x') << "\n";
  }
  EXPECT_EQ(last_lines(log, 2), " | line 99999 | " + std::string(300, 'x'));
  EXPECT_EQ(last_lines(folder.path() / "absent"), "");
}

TEST(ScratchFolder, IsNewAndGoesWithAllItHolds) {
  fs::path path;
  {
    const ScratchFolder one("cousin-test"), two("cousin-test");
    path = one.path();
    EXPECT_NE(one.path(), two.path());
    std::ofstream(one.path() / "file") << "x";
    EXPECT_TRUE(fs::exists(path / "file"));
  }
  EXPECT_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace cousin
