// Strawberries as a user meets them: the same bytes from a folder of stands at rest, on any
// threads, in shards; what cannot be is refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Two small photographs of one coarse stretch of two fruits.
Words tiny_bed(const std::string& out) {
  return {"render",    "strawberries",
          "--scenes",  "2",
          "--frames",  "1",
          "--out",     out,
          "--streams", "color",
          "--set",     "rig=dslr_apsc_24mp",
          "--set",     "rig.rgb.width_px=64",
          "--set",     "rig.rgb.height_px=64",
          "--set",     "render.pixel_samples=1",
          "--set",     "plants=1",
          "--set",     "fruits_min=2",
          "--set",     "fruits_max=2",
          "--set",     "fruit_grid=12",
          "--set",     "bed.row.plants=1",
          "--set",     "bed.row.variants=1",
          "--set",     "bed.path.beds=0",
          "--set",     "bed.film.cell_m=0.05"};
}

TEST(StrawberriesDataset, IsTheSameFromTheFolderOfStandsOnAnyThreadsAndInShards) {
  const Program program;
  const std::string cache = "cache=" + program.path("stands").string();
  const auto manifest = [&](const std::string& out) {
    return read_file(program.path(out + "/manifest.json"));
  };
  const Outcome fresh = program.run(tiny_bed("fresh") + Words{"--threads", "1"});
  ASSERT_EQ(fresh.code, 0) << fresh.err;
  ASSERT_EQ(program.run(tiny_bed("filling") + Words{"--set", cache, "--threads", "2"}).code, 0);
  ASSERT_FALSE(fs::is_empty(program.path("stands")));
  ASSERT_EQ(program.run(tiny_bed("filled") + Words{"--set", cache}).code, 0);
  EXPECT_EQ(manifest("filling"), manifest("fresh"));
  EXPECT_EQ(manifest("filled"), manifest("fresh"));
  for (const char* shard : {"1/2", "0/2"}) {
    ASSERT_EQ(program.run(tiny_bed("shards") + Words{"--set", cache, "--shard", shard}).code, 0);
  }
  EXPECT_EQ(manifest("shards"), manifest("fresh"));
  EXPECT_EQ(program.run({"verify", "fresh"}).out, "fresh: no problems\n");
  // A stand that was cut off is named, and nothing is written.
  for (const auto& entry : fs::directory_iterator(program.path("stands")))
    fs::resize_file(entry.path(), 300);
  const Outcome damaged = program.run(tiny_bed("damaged") + Words{"--set", cache});
  EXPECT_NE(damaged.code, 0);
  EXPECT_THAT(damaged.err, HasSubstr(".stand: its sha256"));
  EXPECT_FALSE(fs::exists(program.path("damaged/000000")));
}

TEST(StrawberriesDataset, WhatCannotBeIsRefusedByName) {
  const Program program;
  const auto refusal = [&](const char* set) {
    const Outcome outcome = program.run(tiny_bed("bad") + Words{"--set", set});
    EXPECT_NE(outcome.code, 0) << set;
    EXPECT_FALSE(fs::exists(program.path("bad/000000"))) << set;
    return outcome.err;
  };
  EXPECT_THAT(refusal("fruits_min=0"), HasSubstr("fruits_min"));
  EXPECT_THAT(refusal("fruits_max=500"), HasSubstr("fruits_max"));
  EXPECT_THAT(refusal("light=moon"), HasSubstr("morning, overcast, noon, lamp"));
  EXPECT_THAT(refusal("heavier=90"), HasSubstr("too heavy for their stalks at heavier = 90"));
}

}  // namespace
}  // namespace cousin
