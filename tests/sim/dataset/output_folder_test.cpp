#include "sim/dataset/output_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/types/whole_file.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

FolderClaim calibrate(std::string config = {}) {
  return {.verb = "calibrate",
          .version = "1",
          .config = std::move(config),
          .names = {"scores.csv", "opencv", "depth/######.exr"}};
}

FolderClaim render(const std::string& config) {
  return {.verb = "render",
          .version = "1",
          .config = config,
          .names = {"######", "manifest.json"},
          .other_config = FolderClaim::OtherConfig::refuse,
          .sharing = FolderClaim::Sharing::shards};
}

/// The message of what is refused; "" if nothing is.
template <class Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

std::string refusal_of(const fs::path& folder, const FolderClaim& claim) {
  const std::string checked = refusal([&] { check_output_folder(folder, claim); });
  const std::string taken = refusal([&] { const OutputFolder own(folder, claim); });
  EXPECT_EQ(checked, taken);
  return taken;
}

TEST(OutputFolder, WhatACommandWroteItReplacesAndWhatItDidNotWriteAgainGoes) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  for (const bool both : {true, false}) {
    OutputFolder own(out, calibrate());
    write_file(out / "scores.csv", both ? "first" : "second");
    if (both) write_file(out / "opencv/camera.yaml", "first");
    own.remove_earlier();
  }
  EXPECT_EQ(read_file(out / "scores.csv"), "second");
  EXPECT_FALSE(fs::exists(out / "opencv"));
}

TEST(OutputFolder, SomebodysFilesAreRefusedBeforeAnyWorkAndStay) {
  for (const char* name :
       {"scores.csv", "opencv/notes.txt", "opencv/src/a.cpp", "depth/000007.exr"}) {
    const TemporaryFolder folder;
    write_file(folder.path() / name, "mine");
    EXPECT_THAT(refusal_of(folder.path(), calibrate()),
                AllOf(HasSubstr((folder.path() / name).string() + " is in the way"),
                      HasSubstr("`cousin calibrate` did not write it"), HasSubstr("--out")));
    EXPECT_EQ(read_file(folder.path() / name), "mine");
    EXPECT_FALSE(fs::exists(folder.path() / ".cousin.calibrate"));
  }
  const TemporaryFolder folder;  // what is not in the way may stay
  for (const char* name : {"notes.txt", "depth/notes.txt", "depth/7.exr", "src/opencv/a.cpp"})
    write_file(folder.path() / name, "mine");
  EXPECT_EQ(refusal_of(folder.path(), calibrate()), "");
}

TEST(OutputFolder, AFileThatWasChangedSinceIsSomebodys) {
  const TemporaryFolder folder;
  {
    const OutputFolder own(folder.path(), calibrate());
    write_file(folder.path() / "scores.csv", "ours");
  }
  write_file(folder.path() / "scores.csv", "mine now");
  EXPECT_THAT(refusal_of(folder.path(), calibrate()),
              HasSubstr("scores.csv is in the way: it was changed since `cousin calibrate` wrote"));
}

TEST(OutputFolder, LinksAreRefusedAndTheirTargetsStay) {
  const TemporaryFolder other;
  write_file(other.path() / "a.yaml", "mine");
  for (const char* name : {"scores.csv", "opencv", "opencv/a.yaml"}) {
    const TemporaryFolder folder;
    {
      const OutputFolder own(folder.path(), calibrate());
      write_file(folder.path() / "scores.csv", "ours");
      write_file(folder.path() / "opencv/a.yaml", "ours");
    }
    fs::remove_all(folder.path() / name);
    fs::create_symlink(fs::path(name) == "opencv" ? other.path() : other.path() / "a.yaml",
                       folder.path() / name);
    EXPECT_THAT(refusal_of(folder.path(), calibrate()), HasSubstr("it is a link")) << name;
    EXPECT_EQ(read_file(other.path() / "a.yaml"), "mine");
  }
}

/// The names that a command says are not all that it is held to.
TEST(OutputFolder, NoWriterReplacesOrRemovesWhatTheCommandDidNotWrite) {
  const TemporaryFolder folder, other;
  write_file(folder.path() / "late.csv", "mine");
  write_file(folder.path() / "late/x", "mine");
  write_file(other.path() / "x", "mine");
  fs::create_directory_symlink(other.path(), folder.path() / "link");
  {
    OutputFolder own(folder.path(), calibrate());
    EXPECT_THAT(refusal([&] { write_file(folder.path() / "late.csv", "ours"); }),
                HasSubstr("late.csv is in the way"));
    EXPECT_THAT(refusal([&] { write_file(folder.path() / "link/new", "ours"); }),
                HasSubstr("link is in the way: it is a link"));
    EXPECT_FALSE(remove_own(folder.path() / "late.csv"));
    write_file(folder.path() / "late/ours", "ours");
    remove_own_folder(folder.path() / "late");
    remove_own_folder(folder.path() / "link");
    EXPECT_FALSE(fs::exists(folder.path() / "late/ours"));
    own.remove_earlier();
  }
  EXPECT_EQ(read_file(folder.path() / "late.csv"), "mine");
  EXPECT_EQ(read_file(folder.path() / "late/x"), "mine");
  EXPECT_EQ(read_file(other.path() / "x"), "mine");
  EXPECT_FALSE(fs::exists(other.path() / "new"));
  EXPECT_FALSE(fs::exists(folder.path() / ".cousin.calibrate"));  // nothing was written
}

TEST(OutputFolder, TheSameFolderUnderAnotherNameIsGuardedToo) {
  const TemporaryFolder folder;
  write_file(folder.path() / "real/mine.csv", "mine");
  fs::create_directory_symlink("real", folder.path() / "alias");
  const OutputFolder own(folder.path() / "alias", calibrate());  // the user named the link
  EXPECT_NE(refusal([&] { write_file(folder.path() / "real/mine.csv", "ours"); }), "");
  EXPECT_NE(refusal([&] { write_file(folder.path() / "alias/../real/mine.csv", "ours"); }), "");
  write_file(folder.path() / "alias/scores.csv", "ours");
  EXPECT_EQ(own.files(), std::vector<std::string>{"scores.csv"});
}

TEST(OutputFolder, AnotherConfigurationIsRefusedByBothHashes) {
  const TemporaryFolder folder;
  {
    const OutputFolder own(folder.path(), render("aaa"));
    write_file(folder.path() / "000000/rig.json", "ours");
  }
  EXPECT_THAT(refusal_of(folder.path(), render("bbb")),
              AllOf(HasSubstr(".cousin.render belongs to another configuration"),
                    HasSubstr("aaa there, bbb here"), HasSubstr("choose another --out")));
  EXPECT_EQ(refusal_of(folder.path(), render("aaa")), "");
}

TEST(OutputFolder, TheResultsOfAnotherVerbStay) {
  const TemporaryFolder folder;
  {
    const OutputFolder own(folder.path(), render("aaa"));
    write_file(folder.path() / "000000/rig.json", "ours");
  }
  FolderClaim import = render("aaa");
  import.verb = "import";
  EXPECT_THAT(refusal_of(folder.path(), import),
              HasSubstr("000000/rig.json is in the way: `cousin render` wrote it"));
}

TEST(OutputFolder, TwoCommandsThatDoNotGoTogetherAreNotThereAtOnce) {
  const TemporaryFolder folder;
  const OutputFolder own(folder.path(), calibrate());
  EXPECT_THAT(refusal([&] { const OutputFolder second(folder.path(), calibrate()); }),
              HasSubstr("another `cousin calibrate` is writing there at this moment"));
}

/// Processes that start at once with two configurations: one of these has the folder.
TEST(OutputFolder, OfTwoConfigurationsAtOnceOneIsRefused) {
  for (int round = 0; round < 3; ++round) {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    int start[2];
    ASSERT_EQ(pipe(start), 0);
    constexpr int kProcesses = 6;
    for (int p = 0; p < kProcesses; ++p) {
      if (fork() != 0) continue;
      close(start[1]);
      char none;
      if (read(start[0], &none, 1) != 0) _exit(3);  // returns when the parent has closed its end
      const std::string config = p % 2 == 0 ? "aaa" : "bbb";
      try {
        const OutputFolder own(out, render(config));
        for (int i = 0; i < 5; ++i)  // shards of one configuration write the same bytes
          write_file(out / "000000" / std::to_string(i), config);
        usleep(20'000);
      } catch (const std::invalid_argument&) {
        _exit(2);
      } catch (...) {
        _exit(4);
      }
      _exit(config == "aaa" ? 10 : 11);
    }
    close(start[0]);
    close(start[1]);
    int done[2] = {0, 0}, refused = 0;
    for (int p = 0; p < kProcesses; ++p) {
      int status = 0;
      ASSERT_GT(wait(&status), 0);
      ASSERT_TRUE(WIFEXITED(status));
      const int code = WEXITSTATUS(status);
      ASSERT_TRUE(code == 2 || code == 10 || code == 11) << code;
      if (code == 2)
        ++refused;
      else
        ++done[code - 10];
    }
    EXPECT_EQ(refused, kProcesses / 2);
    EXPECT_TRUE(done[0] == 0 || done[1] == 0);
    const std::string bytes = read_file(out / "000000/0");
    for (int i = 1; i < 5; ++i) EXPECT_EQ(read_file(out / "000000" / std::to_string(i)), bytes);
  }
}

TEST(OutputFolder, AKilledCommandGoesOnAndItsTemporaryFilesAreCleared) {
  const TemporaryFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    const OutputFolder own(folder.path(), render("aaa"));
    write_file(folder.path() / "000000/rig.json", "ours");
    const PartFolder part(folder.path() / "000000/rgb");
    write_file(part.path() / "half", "half");
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  // A record that was cut off counts for nothing.
  const std::string list = read_file(folder.path() / ".cousin.render");
  write_file(folder.path() / ".cousin.render", list + "+ 0123");
  {
    const OutputFolder own(folder.path(), render("aaa"));
    EXPECT_EQ(own.files(), std::vector<std::string>{"000000/rig.json"});
    write_file(folder.path() / "000000/rgb/0.png", "ours");
    EXPECT_EQ(own.files().size(), 2U);
  }
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
    files += !entry.is_directory();
  EXPECT_EQ(files, 3U);  // with the list
  EXPECT_NE(refusal_of(folder.path(), render("bbb")), "");
}

/// A list says nothing of files outside its folder, whoever wrote it.
TEST(OutputFolder, AListThatLeadsOutOfItsFolderRemovesNothing) {
  const TemporaryFolder folder;
  write_file(folder.path() / "mine", "mine");
  write_file(folder.path() / "out/.cousin.calibrate", "= calibrate - 1\n+ * ../mine\n+ * " +
                                                          (folder.path() / "mine").string() +
                                                          "\n/ ..\n/ .\n+ * a/../../mine\n+ * b\n");
  OutputFolder own(folder.path() / "out", calibrate());
  EXPECT_EQ(own.files(), std::vector<std::string>{"b"});
  own.remove_earlier();
  EXPECT_EQ(read_file(folder.path() / "mine"), "mine");
}

/// A list may be a stranger's that came with a folder.
TEST(OutputFolder, WhatIsNotAsItWasListedIsNotRemoved) {
  const TemporaryFolder folder;
  write_file(folder.path() / "thesis.tex", "mine");
  write_file(folder.path() / ".cousin.calibrate", "= calibrate - 1\n+ * thesis.tex\n");
  {
    OutputFolder own(folder.path(), calibrate());
    own.remove_earlier();
  }
  EXPECT_EQ(read_file(folder.path() / "thesis.tex"), "mine");
}

TEST(OutputFolder, AFileOfAnotherConfigurationThatWasEditedIsInTheWay) {
  const TemporaryFolder folder, other;
  FolderClaim claim = calibrate("aaa");
  {
    const OutputFolder own(folder.path(), claim);
    write_file(folder.path() / "estimate/000001/traits.json", "ours");
    write_file(folder.path() / "estimate/000002/traits.json", "ours");
  }
  claim.config = "bbb";
  EXPECT_EQ(refusal_of(folder.path(), claim), "");
  write_file(folder.path() / "estimate/000001/traits.json", "mine");
  EXPECT_THAT(refusal_of(folder.path(), claim),
              HasSubstr("000001/traits.json is in the way: it was changed"));
  write_file(folder.path() / "estimate/000001/traits.json", "ours");
  fs::rename(folder.path() / "estimate/000002", other.path() / "moved");
  fs::create_directory_symlink(other.path() / "moved", folder.path() / "estimate/000002");
  EXPECT_THAT(refusal_of(folder.path(), claim), HasSubstr("it is behind the link estimate/000002"));
  EXPECT_EQ(read_file(other.path() / "moved/traits.json"), "ours");
}

TEST(OutputFolder, WhatIsLeftOfAnotherConfigurationGoesThoughARunWasStoppedBetween) {
  const TemporaryFolder folder;
  const auto write = [&](const char* name) { write_file(folder.path() / name, "ours"); };
  {
    const OutputFolder own(folder.path(), calibrate("aaa"));
    for (const char* name : {"a", "b", "deep/c"}) write(name);
  }
  {
    const OutputFolder own(folder.path(), calibrate("bbb"));
    write("a");  // the same bytes; stopped before the rest
  }
  OutputFolder own(folder.path(), calibrate("bbb"));
  EXPECT_EQ(own.files_of_other_configs(), (std::vector<std::string>{"b", "deep/c"}));
  write("d");
  own.remove_other_configs();
  EXPECT_EQ(own.files(), (std::vector<std::string>{"a", "d"}));
  EXPECT_FALSE(fs::exists(folder.path() / "deep"));
}

TEST(OutputFolder, ALargeFileThatWasEditedIsInTheWayToo) {
  const TemporaryFolder folder;
  const std::string large(std::size_t{17} << 20, 'a');
  {
    const OutputFolder own(folder.path(), calibrate());
    write_file(folder.path() / "scores.csv", large);
  }
  EXPECT_EQ(refusal_of(folder.path(), calibrate()), "");
  write_file(folder.path() / "scores.csv", large + "b");
  EXPECT_THAT(refusal_of(folder.path(), calibrate()), HasSubstr("it was changed since"));
}

TEST(OutputFolder, SomethingElseWithTheNameOfTheListIsInTheWay) {
  const TemporaryFolder folder;
  const fs::path list = folder.path() / ".cousin.calibrate";
  write_file(list, "my notes\n");
  EXPECT_THAT(refusal_of(folder.path(), calibrate()),
              AllOf(HasSubstr(".cousin.calibrate is in the way"), HasSubstr("--out")));
  EXPECT_EQ(read_file(list), "my notes\n");
  fs::remove(list);
  fs::create_directories(list);
  EXPECT_THAT(refusal_of(folder.path(), calibrate()), HasSubstr("is in the way"));
  fs::remove(list);
  fs::create_symlink("/nowhere", list);
  EXPECT_THAT(refusal_of(folder.path(), calibrate()), HasSubstr("is in the way"));
}

TEST(OutputFolder, NamesWithEndsOfLinesAndBackslashesAreKept) {
  const TemporaryFolder folder;
  const std::string name = "a\nb\\n c";
  for (int i = 0; i < 2; ++i) {
    const OutputFolder own(folder.path(), calibrate());
    write_file(folder.path() / name, std::to_string(i));
    EXPECT_EQ(own.files(), std::vector<std::string>{name});
  }
  EXPECT_EQ(read_file(folder.path() / name), "1");
}

TEST(OutputFolder, TheListIsTheSameForAnyOrderOfWriting) {
  const TemporaryFolder one, two;
  for (const auto& [folder, reversed] : {std::pair(&one, false), std::pair(&two, true)}) {
    const OutputFolder own(folder->path(), calibrate("aaa"));
    for (const char* name : {reversed ? "b" : "a", reversed ? "a" : "b"}) {
      write_file(folder->path() / name, "earlier");
      write_file(folder->path() / name, name);
    }
    write_file(folder->path() / "timings.json", reversed ? "1" : "2");
  }
  EXPECT_EQ(read_file(one.path() / ".cousin.calibrate"),
            read_file(two.path() / ".cousin.calibrate"));
}

TEST(PartFolder, ReplacesOnlyAFolderThatIsTheCommandsOwn) {
  const TemporaryFolder folder;
  const fs::path scene = folder.path() / "report/000000";
  const OutputFolder own(folder.path(), calibrate());
  const auto replace = [&](const char* file) {
    PartFolder part(scene);
    write_file(part.path() / file, file);
    part.replace();
  };
  replace("first");
  replace("second");
  EXPECT_FALSE(fs::exists(scene / "first"));
  EXPECT_THAT(own.files(), testing::Contains("report/000000/second"));
  { std::ofstream(scene / "mine") << "mine"; }
  EXPECT_THAT(refusal([&] { replace("third"); }), HasSubstr("report/000000/mine is in the way"));
  EXPECT_EQ(read_file(scene / "mine"), "mine");
  EXPECT_EQ(read_file(scene / "second"), "second");
}

}  // namespace
}  // namespace cousin
