// Plant scenes in parts: shards, threads, and runs that were killed give the files of one run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::string>;

/// A tray of four cells on three days, two small photographs a day.
Words growing_tray() {
  return Words{"render", "seedlings", "--scenes", "3", "--truth", "visibility,instance,keypoints"} +
         Words{"--set", "day=4", "--set", "day_step=3"} + tiny_tray();
}

/// Without what a kill while writing leaves and what shards add.
Files finished(const fs::path& folder) {
  Files files = contents(folder);
  std::erase_if(files, [](const auto& file) {
    const std::string name = fs::path(file.first).filename();
    return is_temporary_name(name) || name.find("-of-") != std::string::npos;
  });
  return files;
}

TEST(PlantResume, ShardsOfAGrowthSeriesInAnyOrderMakeTheFilesOfOneRun) {
  const Program program;
  ASSERT_EQ(program.run(growing_tray() + Words{"--out", "whole", "--threads", "1"}).code, 0);
  // Four shards of six frames: some begin in the middle of a day.
  for (const char* shard : {"2/4", "0/4", "3/4", "1/4"}) {
    const Outcome outcome = program.run(growing_tray() + Words{"--out", "data", "--shard", shard});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }
  const Files whole = finished(program.path("whole"));
  EXPECT_EQ(finished(program.path("data")), whole);
  EXPECT_TRUE(whole.contains("000002/truth/shared_plants.json"));
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
}

TEST(PlantResume, AKilledRunGoesOnToTheSameBytes) {
  const Program program;
  ASSERT_EQ(program.run(growing_tray() + Words{"--out", "whole"}).code, 0);
  // Killed while it takes pictures, and while it writes the truth of the second day.
  for (const char* sign : {"data/000000/rgb/000001.png", "data/000001/truth/instance/000000.png"}) {
    const Outcome killed = program.run_until(growing_tray() + Words{"--out", "data"},
                                             [&] { return fs::exists(program.path(sign)); });
    EXPECT_TRUE(killed.signal == SIGKILL || killed.code == 0) << killed.err;
  }
  const Outcome rest = program.run(growing_tray() + Words{"--out", "data"});
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_EQ(finished(program.path("data")), finished(program.path("whole")));
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
}

TEST(PlantResume, AKilledShardGoesOnToTheSameBytes) {
  const Program program;
  ASSERT_EQ(program.run(growing_tray() + Words{"--out", "whole"}).code, 0);
  const Words first = growing_tray() + Words{"--out", "data", "--shard", "0/2"};
  program.run_until(first, [&] { return fs::exists(program.path("data/000000/rgb/000000.png")); });
  ASSERT_EQ(program.run(growing_tray() + Words{"--out", "data", "--shard", "1/2"}).code, 0);
  ASSERT_EQ(program.run(first).code, 0);
  EXPECT_EQ(finished(program.path("data")), finished(program.path("whole")));
}

}  // namespace
}  // namespace cousin
