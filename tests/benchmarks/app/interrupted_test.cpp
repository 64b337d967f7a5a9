// Runs that are killed, disks that fill and folders that take no files: what is finished stays, and
// the same command goes on from there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <sstream>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/output_folder.h"
#include "sim/dataset/seam_io.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Times = std::map<fs::path, fs::file_time_type>;

/// When the finished files below a folder were written; temporary ones and lists are none.
Times times(const fs::path& folder) {
  Times result;
  if (!fs::exists(folder)) return result;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& file = entry.path();
    const std::string name = file.filename().string();
    if (!entry.is_regular_file() || is_temporary_name(name) || is_output_list(name)) continue;
    result[file] = entry.last_write_time();
  }
  return result;
}

void expect_untouched(const Times& before) {
  for (const auto& [file, time] : before) {
    ASSERT_TRUE(fs::exists(file)) << file;
    EXPECT_EQ(fs::last_write_time(file), time) << file << " was made again";
  }
}

TEST(AppInterrupted, AKilledRenderGoesOn) {
  const Program program;
  Words scene = tiny_scene();
  scene[1] = "views=8";
  const fs::path images = program.path("data/000000/rgb");
  const Outcome killed = program.run_until(Words{"render", "seeds", "--out", "data"} + scene,
                                           [&] { return fs::exists(images / "000001.png"); });
  if (killed.signal != SIGKILL) GTEST_SKIP() << "it was finished before it could be killed";
  EXPECT_FALSE(fs::exists(program.path("data/manifest.json")));
  const Times finished = times(images);
  EXPECT_GE(finished.size(), 2U);
  const Outcome other =
      program.run(Words{"render", "seeds", "--out", "data", "--seed", "2"} + scene);
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("data/.cousin.render belongs to another configuration"));

  const Outcome rest = program.run(Words{"render", "seeds", "--out", "data"} + scene);
  EXPECT_EQ(rest.code, 0) << rest.err;
  expect_untouched(finished);
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "whole"} + scene).code, 0);
  const auto whole = contents(program.path("whole"));
  EXPECT_EQ(contents(program.path("data")), whole);  // nor does a half-written file stay
}

/// A folder always says whose it is: a kill at any place leaves none that another seed would take.
TEST(AppInterrupted, ARenderKilledAroundItsManifestKeepsItsFolder) {
  const Program program;
  const Words render = Words{"render", "seeds", "--out", "data"} + tiny_scene();
  const fs::path marker = program.path("data/.cousin.render");
  const fs::path manifest = program.path("data/manifest.json");
  ASSERT_EQ(program.run(render + Words{"--shard", "0/2"}).code, 0);
  const std::string owner = read_file(marker);
  ASSERT_EQ(program.run(render + Words{"--shard", "1/2"}).code, 0);
  const std::string whole = read_file(manifest);

  write_file(marker, owner);  // as if killed with the manifest just written
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
  EXPECT_EQ(program.run(render + Words{"--seed", "2"}).code, 2);
  EXPECT_EQ(program.run(render).code, 0);
  EXPECT_FALSE(fs::exists(marker));
  EXPECT_EQ(read_file(manifest), whole);

  // Images without an owner, as of an earlier program that was stopped.
  for (const char* name : {"manifest.json", "manifest.0-of-2.json", "manifest.1-of-2.json"})
    fs::remove(program.path("data") / name);
  for (const Words& words : {render, render + Words{"--seed", "2"}}) {
    const Outcome unowned = program.run(words);
    EXPECT_EQ(unowned.code, 2);
    EXPECT_THAT(unowned.err, AllOf(HasSubstr("cousin: data/000000/"),
                                   HasSubstr("is in the way: `cousin render` did not write it")));
  }
}

TEST(AppInterrupted, AKilledRunGoesOnWithTheNextScene) {
  const Program program;
  write_traits(program.path("mine"), {});
  // A stage that kills the program at the second scene of the first run; it notes each call.
  const fs::path stage = program.path("mine/stage.sh");
  write_file(stage,
             "#!/bin/sh\necho called >> mine/calls\n"
             "[ $(wc -l < mine/calls) -eq 2 ] && kill -9 $PPID\ncp mine/traits.json \"$2\"/\n");
  fs::permissions(stage, fs::perms::owner_all);
  const Words run =
      Words{"run",   "seeds", "--scenes", "2", "--stage", "traits=exec:" + stage.string(),
            "--out", "r"} +
      tiny_scene();
  const Outcome killed = program.run(run);
  ASSERT_EQ(killed.signal, SIGKILL) << killed.code << killed.err;
  const Times finished = times(program.path("r/parts"));
  EXPECT_EQ(finished.size(), 1U);
  const Times estimate = times(program.path("r/estimate/000001"));
  EXPECT_GE(estimate.size(), 5U);

  const Outcome rest = program.run(run);
  EXPECT_EQ(rest.code, 0) << rest.err;
  EXPECT_THAT(rest.err, HasSubstr("taken from the run that was stopped: r/parts/000001.json"));
  expect_untouched(estimate);
  EXPECT_EQ(read_file(program.path("mine/calls")), "called\ncalled\ncalled\n");  // not four times
  EXPECT_FALSE(fs::exists(program.path("r/parts")));
  const std::string scores = read_file(program.path("r/scores.csv"));
  EXPECT_THAT(scores, HasSubstr("run,000000,run,ours,views.posed"));
  EXPECT_THAT(scores, HasSubstr("run,000001,run,ours,views.posed"));
  EXPECT_THAT(scores, Not(HasSubstr("seconds.run")));  // nobody measured the whole
  EXPECT_LT(scores.find("run,000000,"), scores.find("run,000001,"));
}

TEST(AppInterrupted, AKilledBenchGoesOn) {
  const Program program;
  const Words bench = Words{"bench",
                            "seeds",
                            "--quick",
                            "--out",
                            "b",
                            "--only",
                            "quick_jimai22,quick_suijing18,quick_noise"} +
                      tiny_scene();
  const fs::path shards = program.path("b/seeds/shards");
  const Outcome killed = program.run_until(bench, [&] { return !times(shards).empty(); });
  if (killed.signal != SIGKILL) GTEST_SKIP() << "it was finished before it could be killed";
  const Times finished = times(shards);
  EXPECT_GE(finished.size(), 1U);
  EXPECT_FALSE(fs::exists(program.path("b/seeds/scores.csv")));
  const auto listed = [&] {
    std::istringstream lines(program.run(bench + Words{"--list"}).out);
    std::size_t all = 0, done = 0;
    for (std::string line; std::getline(lines, line); ++all) done += line.ends_with(" finished");
    return std::pair(all, done);
  };
  EXPECT_EQ(listed(), std::pair(std::size_t{3}, finished.size()));
  const Outcome rest = program.run(bench);
  EXPECT_EQ(rest.code, 0) << rest.err;
  expect_untouched(finished);
  EXPECT_EQ(times(shards).size(), 3U);
  EXPECT_EQ(listed(), std::pair(std::size_t{3}, std::size_t{3}));
  EXPECT_THAT(rest.err, Not(HasSubstr(finished.begin()->first.filename().string())));
  EXPECT_GT(fs::file_size(program.path("b/seeds/scores.csv")), 0U);
}

/// Files of at most so many bytes from here on: a write beyond fails, as on a full disk. Every user
/// may do this.
bool limit_files(rlim_t bytes) {
  const rlimit limit{bytes, bytes};
  return std::signal(SIGXFSZ, SIG_IGN) != SIG_ERR && setrlimit(RLIMIT_FSIZE, &limit) == 0;
}

TEST(AppInterrupted, AFullDiskKeepsWhatIsFinished) {
  const Program program;
  const Words render = Words{"render", "seeds", "--out", "data"} + tiny_scene();
  ASSERT_EQ(program.run(render + Words{"--shard", "0/2"}).code, 0);
  const Times finished = times(program.path("data"));
  const Times scene = times(program.path("data/000000"));
  EXPECT_GT(scene.size(), 5U);
  const Outcome full = program.run(render + Words{"--shard", "1/2"},
                                   [] { return limit_files(72 << 10); });  // an image is larger
  EXPECT_EQ(full.code, 3);
  EXPECT_THAT(full.err, HasSubstr("data/000000/rgb/000001.png: "));
  EXPECT_THAT(full.err, HasSubstr("File too large"));
  EXPECT_EQ(times(program.path("data")), finished);  // nothing new under a final name either
  EXPECT_EQ(program.run(render + Words{"--shard", "1/2"}).code, 0);
  expect_untouched(scene);
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
}

/// What takes long for a real scene; small, should a test let it start.
std::vector<Words> quick_work() {
  return {Words{"run", "seeds"} + tiny_scene(),
          Words{"render", "seeds"} + tiny_scene(),
          Words{"bench", "seeds", "--quick"} + tiny_scene(),
          {"bench", "stability", "--quick"}};
}

TEST(AppInterrupted, AFullDiskIsNamedBeforeAnyWork) {
  // Room for 4 KiB: too little for the test file that comes before any work.
  const Program program;
  const std::string folder = program.path("disk");
  fs::create_directories(folder);
  const auto limited = [] { return limit_files(4 << 10); };
  const auto mounted = [&] {  // a real file system that is full, where this user may mount one
    return unshare(CLONE_NEWNS) == 0 &&
           mount("", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
           mount("tmpfs", folder.c_str(), "tmpfs", 0, "size=4k,nr_inodes=100") == 0;
  };
  for (const Words& words : quick_work()) {
    for (const Prepare& full : {Prepare(limited), Prepare(mounted)}) {
      const Outcome outcome = program.run(words + Words{"--out", "disk/out"}, full);
      if (outcome.code == kNotPrepared) continue;
      EXPECT_EQ(outcome.code, 3) << words[0] << outcome.err;
      EXPECT_THAT(outcome.err, testing::StartsWith("cousin: disk/out")) << words[0];
      EXPECT_THAT(outcome.err, testing::AnyOf(HasSubstr("File too large"),
                                              HasSubstr("No space left on device")));
      EXPECT_EQ(outcome.out, "");
    }
    // Nothing is left there under a final name.
    EXPECT_TRUE(times(folder).empty()) << words[0];
  }
}

/// No folder can be made below a file, by no user.
TEST(AppInterrupted, AnOutputFolderBelowAFileIsNamedBeforeAnyWork) {
  const Program program;
  write_file(program.path("file"), "finished");
  for (const Words& words : quick_work()) {
    const Outcome outcome = program.run(words + Words{"--out", "file/out"});
    EXPECT_EQ(outcome.code, 3) << words[0] << " " << words[1];
    EXPECT_THAT(outcome.err, testing::StartsWith("cousin: file/out")) << words[0];
    EXPECT_EQ(outcome.out, "");
  }
  EXPECT_EQ(read_file(program.path("file")), "finished");
}

/// Permissions bind root too: the program about to start gets no right to override them. A root
/// that may not drop that right does not have it, as a rule.
bool bind_root() {
  for (const int capability : {CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH}) {
    prctl(PR_CAPBSET_DROP, capability, 0, 0, 0);
  }
  return true;
}

TEST(AppInterrupted, AReadOnlyFolderIsNamedBeforeAnyWork) {
  const Program program;
  const std::string folder = program.path("kept");
  write_file(program.path("kept/scores.csv"), "finished");
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  const Times before = times(folder);
  for (const Words& words : quick_work()) {
    const Outcome outcome = program.run(words + Words{"--out", "kept"}, bind_root);
    EXPECT_EQ(outcome.code, 3) << words[0];
    EXPECT_THAT(outcome.err, testing::StartsWith("cousin: kept")) << words[0];
    EXPECT_THAT(outcome.err, HasSubstr("Permission denied")) << words[0];
    EXPECT_EQ(outcome.out, "");
  }
  fs::permissions(folder, fs::perms::owner_all);
  EXPECT_EQ(times(folder), before);
  EXPECT_EQ(read_file(program.path("kept/scores.csv")), "finished");
}

/// A finished dataset that may only be read can still be perceived and verified.
TEST(AppInterrupted, AReadOnlyDatasetIsReadAndItsEstimateGoesElsewhere) {
  const Program program;
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "data"} + tiny_scene()).code, 0);
  const auto set_all = [&](fs::perms perms) {
    fs::permissions(program.path("data"), perms);
    fs::permissions(program.path("data/000000"), perms);
  };
  set_all(fs::perms::owner_read | fs::perms::owner_exec);
  const Outcome verified = program.run({"verify", "data"}, bind_root);
  EXPECT_EQ(verified.out, "data: no problems\n") << verified.err;
  const Outcome perceived = program.run({"perceive", "data", "--out", "est"}, bind_root);
  EXPECT_THAT(perceived.err, HasSubstr("2 of 2 views posed"));
  fs::create_directories(program.path("locked"));
  fs::permissions(program.path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  const Outcome inside = program.run({"perceive", "data", "--out", "locked/est"}, bind_root);
  EXPECT_EQ(inside.code, 3);
  EXPECT_THAT(inside.err, testing::StartsWith("cousin: locked/est"));
  fs::permissions(program.path("locked"), fs::perms::owner_all);
  set_all(fs::perms::owner_all);
}

}  // namespace
}  // namespace cousin
