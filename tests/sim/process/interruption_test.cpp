// What becomes of other programs and scratch folders when this process is ended. Each test forks a
// process that runs a program, ends it, and looks at what is left.
#include "sim/process/interruption.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"

namespace cousin {
namespace {
namespace fs = std::filesystem;

/// Waits up to ten seconds.
template <class Condition>
bool comes_true(Condition condition) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// The number in a file that a shell writes; 0 until it is there.
pid_t number_in(const fs::path& file) {
  pid_t number = 0;
  std::ifstream(file) >> number;
  return number;
}

bool runs(pid_t process) { return kill(process, 0) == 0 || errno == EPERM; }

/// A program that starts another one, writes both numbers into the folder, and waits.
ProgramCall two_programs(const fs::path& folder) {
  return {.words = {"sh", "-c",
                    "sleep 1000 & echo $! > " + (folder / "inner.part").string() + "; mv " +
                        (folder / "inner.part").string() + " " + (folder / "inner").string() +
                        "; wait"},
          .log = "/dev/null"};
}

/// Whether a process that runs a program in a scratch folder, ended by `number`, leaves neither.
void ends_all(int number) {
  const ScratchFolder notes("cousin-test");
  const pid_t process = fork();
  if (process == 0) {
    clean_up_when_interrupted();
    const ScratchFolder scratch("cousin-test-inner");
    std::ofstream(scratch.path() / "capture.png") << "a copy";
    std::ofstream(notes.path() / "scratch") << scratch.path().string() << std::flush;
    run_program(two_programs(notes.path()));
    _exit(0);
  }
  ASSERT_TRUE(comes_true([&] { return number_in(notes.path() / "inner") > 0; }));
  const pid_t inner = number_in(notes.path() / "inner");
  std::string scratch;
  std::ifstream(notes.path() / "scratch") >> scratch;
  ASSERT_TRUE(runs(inner));
  ASSERT_TRUE(fs::exists(fs::path(scratch) / "capture.png"));
  kill(process, number);
  int status = 0;
  waitpid(process, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), number);
  if (number != SIGKILL) {  // by its own hand, before it ends
    EXPECT_FALSE(fs::exists(scratch));
  }
  EXPECT_TRUE(comes_true([&] { return !runs(inner); }));
  EXPECT_TRUE(comes_true([&] { return !fs::exists(scratch); }));
}

TEST(Interruption, TerminatedNothingIsLeftRunningOrInTheTemporaryFolder) { ends_all(SIGTERM); }
TEST(Interruption, HungUpNothingIsLeftRunningOrInTheTemporaryFolder) { ends_all(SIGHUP); }
TEST(Interruption, InterruptedNothingIsLeftRunningOrInTheTemporaryFolder) { ends_all(SIGINT); }
TEST(Interruption, KilledNothingIsLeftRunningOrInTheTemporaryFolder) { ends_all(SIGKILL); }

TEST(Interruption, ASignalThatIsIgnoredStaysIgnored) {
  const ScratchFolder notes("cousin-test");
  const pid_t process = fork();
  if (process == 0) {
    signal(SIGHUP, SIG_IGN);
    clean_up_when_interrupted();
    kill(getpid(), SIGHUP);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    _exit(7);
  }
  int status = 0;
  waitpid(process, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 7);
}

TEST(Interruption, ATimeLimitEndsWhatTheProgramStartedToo) {
  const ScratchFolder notes("cousin-test");
  ProgramCall call = two_programs(notes.path());
  call.time_limit_s = 5;
  EXPECT_EQ(run_program(call).end, ProgramEnd::timed_out);
  const pid_t inner = number_in(notes.path() / "inner");
  ASSERT_GT(inner, 0);
  EXPECT_TRUE(comes_true([&] { return !runs(inner); }));
}

TEST(Interruption, WhatAProgramLeavesRunningEndsWithIt) {
  const ScratchFolder notes("cousin-test");
  const std::string file = (notes.path() / "left").string();
  EXPECT_TRUE(succeeded(
      run_program({.words = {"sh", "-c", "sleep 1000 & echo $! > " + file}, .log = "/dev/null"})));
  const pid_t left = number_in(file);
  ASSERT_GT(left, 0);
  EXPECT_TRUE(comes_true([&] { return !runs(left); }));
}

}  // namespace
}  // namespace cousin
