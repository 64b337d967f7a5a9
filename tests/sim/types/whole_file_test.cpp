#include "sim/types/whole_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(WholeFile, TemporaryNamesDifferAndAreKnown) {
  std::set<std::string> names;
  for (int i = 0; i < 1000; ++i) names.insert(temporary_name("scores.csv"));
  EXPECT_EQ(names.size(), 1000U);
  EXPECT_TRUE(names.begin()->starts_with(".scores.csv.cousin-"));
  for (const std::string& name : names) EXPECT_TRUE(is_own_temporary(name));
  EXPECT_LE(temporary_name(std::string(255, 'x')).size(), 255U);
  EXPECT_TRUE(is_own_temporary(temporary_name(std::string(255, 'x'))));
  for (const char* other : {"scores.csv", ".scores.csv.77.0.part", ".a.cousin-0123.part",
                            "a.cousin-0123456789abcdef.part", ".a.cousin-0123456789abcdeg.part",
                            ".a.cousin-0123456789abcdef.part.x"})
    EXPECT_FALSE(is_own_temporary(other)) << other;
}

/// As in containers: a process is killed in the middle of a file, and the next one has its number.
/// The name that an earlier version would have taken is there already.
TEST(WholeFile, AKilledProcessOfTheSameNumberIsNotInTheWay) {
  const TemporaryFolder folder;
  for (int i = 0; i < 20; ++i)
    std::ofstream(folder.path() /
                  (".result." + std::to_string(::getpid()) + "." + std::to_string(i) + ".part"))
        << "half";
  const std::size_t before = names_in(folder.path()).size();
  EXPECT_EQ(write_whole_file(folder.path() / "result", "whole").error, 0);
  EXPECT_EQ(bytes_of(folder.path() / "result"), "whole");
  EXPECT_EQ(names_in(folder.path()).size(), before + 1);
}

/// Processes that all write the same files at the same time.
TEST(WholeFile, ManyProcessesLeaveWholeFilesAndNothingElse) {
  const TemporaryFolder folder;
  constexpr int kProcesses = 8, kFiles = 20;
  for (int p = 0; p < kProcesses; ++p) {
    if (fork() != 0) continue;
    int failures = 0;
    for (int i = 0; i < kFiles; ++i) {
      const WriteOutcome outcome = write_whole_file(folder.path() / std::to_string(i),
                                                    std::string(1000, static_cast<char>('a' + p)));
      failures += outcome.error != 0;
    }
    _exit(failures);
  }
  for (int p = 0; p < kProcesses; ++p) {
    int status = 0;
    ASSERT_GT(wait(&status), 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(names_in(folder.path()).size(), static_cast<std::size_t>(kFiles));
  for (const std::string& name : names_in(folder.path())) {
    const std::string bytes = bytes_of(folder.path() / name);
    EXPECT_EQ(bytes, std::string(1000, bytes.at(0)));
  }
}

TEST(WholeFile, ALinkOfTheFinalNameIsReplacedAndItsTargetStays) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "mine") << "mine";
  fs::create_symlink("mine", folder.path() / "result");
  EXPECT_EQ(write_whole_file(folder.path() / "result", "whole").error, 0);
  EXPECT_EQ(bytes_of(folder.path() / "mine"), "mine");
  EXPECT_FALSE(fs::is_symlink(folder.path() / "result"));
}

TEST(WholeFile, TemporaryFilesOfDeadProcessesGoAndThoseOfLiveOnesStay) {
  const TemporaryFolder folder;
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const PartFolder part(folder.path() / "scene");
    std::ofstream(part.path() / "half") << "half";
    const std::string name = part.path().string();
    if (write(ready[1], name.data(), name.size()) < 0) _exit(1);
    pause();
  }
  char name[4096] = {};
  ASSERT_GT(read(ready[0], name, sizeof name - 1), 0);
  const fs::path part = name;
  EXPECT_TRUE(is_own_temporary(part.filename().string()));
  EXPECT_FALSE(remove_if_stale(part));  // its process lives
  EXPECT_TRUE(fs::exists(part / "half"));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(remove_if_stale(part));
  EXPECT_FALSE(fs::exists(part));
  // Names that are not ours are nobody's to clear away.
  std::ofstream(folder.path() / ".notes.part") << "mine";
  EXPECT_FALSE(remove_if_stale(folder.path() / ".notes.part"));
  fs::create_directory(folder.path() / "mine");
  const fs::path link = folder.path() / temporary_name("x");
  fs::create_directory_symlink("mine", link);
  EXPECT_FALSE(remove_if_stale(link));
  EXPECT_TRUE(fs::exists(folder.path() / "mine"));
}

TEST(PartFolder, TakesItsNameOnceAndLeavesNothingOtherwise) {
  const TemporaryFolder folder;
  {
    PartFolder first(folder.path() / "scene"), second(folder.path() / "scene");
    const PartFolder given_up(folder.path() / "scene");
    std::ofstream(first.path() / "file") << "first";
    std::ofstream(second.path() / "file") << "second";
    EXPECT_TRUE(first.take_free_name());
    EXPECT_FALSE(second.take_free_name());
  }
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"scene"});
  EXPECT_EQ(bytes_of(folder.path() / "scene/file"), "first");
  {
    PartFolder third(folder.path() / "scene");
    std::ofstream(third.path() / "other") << "third";
    third.replace();
  }
  EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"scene"});
  EXPECT_EQ(names_in(folder.path() / "scene"), std::vector<std::string>{"other"});
}

TEST(RemoveOwnFolder, DoesNotFollowLinks) {
  const TemporaryFolder folder, other;
  std::ofstream(other.path() / "mine") << "mine";
  fs::create_directories(folder.path() / "results/depth");
  std::ofstream(folder.path() / "results/depth/0.exr") << "ours";
  fs::create_directory_symlink(other.path(), folder.path() / "results/link");
  fs::create_directory_symlink(other.path(), folder.path() / "linked");
  remove_own_folder(folder.path() / "linked");
  remove_own_folder(folder.path() / "results");
  EXPECT_FALSE(fs::exists(folder.path() / "results"));
  EXPECT_EQ(bytes_of(other.path() / "mine"), "mine");
}

}  // namespace
}  // namespace cousin
