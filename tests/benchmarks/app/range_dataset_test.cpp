// Datasets of time-of-flight and structured-light cameras, as a user makes them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

using testing::HasSubstr;

Words tiny(const std::string& rig, const std::string& kind) {
  return {"--set", "views=2",
          "--set", "seeds=0",
          "--set", "rig=" + rig,
          "--set", "rig." + kind + ".columns=128",
          "--set", "rig." + kind + ".rows=96",
          "--set", "rig.rgb.width_px=96",
          "--set", "rig.rgb.height_px=64",
          "--set", "ring_distances_m=[0.7, 0.7, 0.7]",
          "--set", "knows_pose=true",
          "--set", "render.irradiance_samples=16",
          "--set", "render.edge_samples=16",
          "--set", "render.board_texel_m=0.005",
          "--set", "render.max_bounces=0"};
}

TEST(AppRangeDataset, IsTheSameForAnyNumberOfThreadsAndInShards) {
  const Program program;
  for (const auto& [rig, kind] : std::vector<std::pair<std::string, std::string>>{
           {"kinect_v2", "time_of_flight"}, {"kinect_v1", "structured_light"}}) {
    const Words render = Words{"render", "seeds"} + tiny(rig, kind);
    const Outcome one = program.run(render + Words{"--out", rig + "_1", "--threads", "1"});
    ASSERT_EQ(one.code, 0) << one.err;
    ASSERT_EQ(program.run(render + Words{"--out", rig, "--threads", "3", "--shard", "0/2"}).code,
              0);
    ASSERT_EQ(program.run(render + Words{"--out", rig, "--threads", "2", "--shard", "1/2"}).code,
              0);
    auto files = contents(program.path(rig));
    EXPECT_EQ(files.erase("manifest.0-of-2.json") + files.erase("manifest.1-of-2.json"), 2U);
    EXPECT_EQ(files, contents(program.path(rig + "_1")));
    EXPECT_TRUE(files.contains("000000/depth/000001.png")) << rig;
    EXPECT_TRUE(files.contains("000000/rgb/000001.png")) << rig;
    EXPECT_TRUE(files.contains("000000/truth/noise_free_depth/000001.npy")) << rig;
    EXPECT_TRUE(files.contains("000000/truth/invalid_reason/000001.png")) << rig;
    EXPECT_EQ(program.run({"verify", rig}).code, 0);
  }
}

TEST(AppRangeDataset, DepthOnlyRunsInMemoryAndThroughFilesToTheSameEstimate) {
  const Program program;
  const Words rig = tiny("kinect_v2", "time_of_flight");
  const Outcome run = program.run(Words{"run", "seeds", "--method", "depth_only", "--set",
                                        "pipeline.fuse.min_views=1", "--out", "r"} +
                                  rig);
  EXPECT_EQ(run.code, 0) << run.err;
  ASSERT_EQ(program.run(Words{"render", "seeds", "--streams", "depth", "--out", "d"} + rig).code,
            0);
  const Outcome perceived = program.run(
      {"perceive", "d", "--method", "depth_only", "--set", "fuse.min_views=1", "--out", "est"});
  // The board is empty, which perceive reports as it does for a real capture.
  EXPECT_EQ(perceived.code, 3);
  EXPECT_THAT(perceived.err, HasSubstr("2 of 2 views posed, 0 specimens"));
  const auto cloud = [&](const std::string& folder) {
    std::ifstream in(program.path(folder + "/000000/cloud.ply"), std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(in)), {});
  };
  EXPECT_FALSE(cloud("est").empty());
  EXPECT_EQ(cloud("r/estimate"), cloud("est"));
}

TEST(AppRangeDataset, RigsAreListedWithTheirWordAndRefuseWhatTheyCannot) {
  const Program program;
  const Outcome rigs = program.run({"rigs"});
  EXPECT_THAT(rigs.out, HasSubstr("Kinect for Xbox One, time of flight, depth 512 x 424"));
  EXPECT_THAT(rigs.out, HasSubstr("Kinect for Xbox 360, structured light, depth 640 x 480"));
  const Outcome model = program.run(Words{"render", "seeds"} + tiny("kinect_v2", "time_of_flight") +
                                    Words{"--set", "depth_by=model"});
  EXPECT_EQ(model.code, 2);
  EXPECT_THAT(model.err, HasSubstr("the fast model is of stereo depth cameras"));
  const Outcome infrared =
      program.run({"render", "seeds", "--set", "rig=kinect_v1", "--streams", "infrared"});
  EXPECT_EQ(infrared.code, 2);
  EXPECT_THAT(infrared.err, HasSubstr("rig kinect_v1 has no infrared; it has color,depth"));
  const Outcome none = program.run({"render", "seeds", "--set", "rig=absent.toml"});
  EXPECT_NE(none.code, 0);
  EXPECT_THAT(none.err, HasSubstr("absent.toml: no such file"));
}

}  // namespace
}  // namespace cousin
