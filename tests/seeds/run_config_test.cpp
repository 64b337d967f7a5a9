#include "benchmarks/seeds/run_config.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "benchmarks/seeds/plan.h"
#include "benchmarks/seeds/stage_files.h"
#include "benchmarks/seeds/truth_choice.h"
#include "sim/dataset/atomic_file.h"
#include "tests/dataset/temporary_folder.h"

namespace cousin {
namespace {

TEST(SeedsRunConfig, TheResolvedTextReadsBackToItself) {
  const SeedsRunConfig config =
      seeds_run_config({"cultivar=jimai22", "rig.read_noise_e=3", "pipeline.mvs.neighbours=4"});
  EXPECT_EQ(config.scene.cultivar, "jimai22");
  EXPECT_EQ(config.rig.read_noise_e, 3);
  SeedsRunConfig copy;
  read_toml_text(resolved_toml(config), "resolved",
                 nested("scene", fields(copy.scene)) + nested("rig", fields(copy.rig)) +
                     nested("render", fields(copy.render)) +
                     nested("pipeline", fields(copy.pipeline)),
                 MissingKeys::error);
  EXPECT_EQ(resolved_toml(copy), resolved_toml(config));
  EXPECT_NE(config_hash(config, 1), config_hash(config, 2));
}

TEST(SeedsRunConfig, AUsersMeshMustBeThere) {
  const TemporaryFolder folder;
  EXPECT_THROW(seeds_run_config({"specimen=foo"}), std::invalid_argument);
  EXPECT_THROW(seeds_run_config({"specimen=mesh:"}), std::invalid_argument);
  const std::string absent = (folder.path() / "absent.stl").string();
  EXPECT_NE(error_of([&] { seeds_run_config({"specimen=mesh:" + absent}); }).find(absent),
            std::string::npos);
  EXPECT_NE(error_of([&] { seeds_run_config({"specimen=mesh:" + folder.path().string()}); }), "");
}

TEST(SeedsRunConfig, AnotherMeshInTheSameFileIsAnotherHash) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "mine.obj";
  const auto hash = [&](const std::string& bytes) {
    write_file(file, bytes);
    return config_hash(seeds_run_config({"specimen=mesh:" + file.string()}), 1);
  };
  const std::string first = hash("v 0 0 0\n");
  EXPECT_NE(hash("v 0 0 1\n"), first);
  EXPECT_EQ(hash("v 0 0 0\n"), first);
}

TEST(TruthChoice, ReadsListsInAnyOrderAndWritesOneText) {
  const TruthNeeds needs = truth_needs_from_string("visibility,depth");
  EXPECT_TRUE(needs.depth && needs.visibility);
  EXPECT_FALSE(needs.normal || needs.position || needs.instance || needs.part || needs.coverage);
  EXPECT_EQ(to_string(needs), "depth,visibility");
  EXPECT_EQ(to_string(truth_needs_from_string("depth,depth")), "depth");
  const std::string all = to_string(truth_needs_from_string("all"));
  EXPECT_EQ(all, "depth,normal,instance,part,position,coverage,visibility,shares,keypoints,flow");
  EXPECT_EQ(to_string(truth_needs_from_string(all)), all);
  EXPECT_EQ(to_string(truth_needs_from_string("none")), "none");
  for (const char* wrong :
       {"", "depth,", ",depth", "depth, part", "Depth", "all,depth", "none,all"})
    EXPECT_THROW(truth_needs_from_string(wrong), std::invalid_argument) << wrong;
}

TEST(SeedsRunConfig, TheRigsPresetComesBeforeTheUsersKeysWhateverTheirOrder) {
  const SeedsRunConfig config = seeds_run_config({"rig.prnu=0.002", "rig=phone_video_1080p"});
  EXPECT_EQ(config.rig.width_px, 1920);
  EXPECT_EQ(config.rig.prnu, 0.002);
}

TEST(SeedsRunConfig, MistakesNameTheKeyAndWhatThereIs) {
  const auto message = [](const std::string& set) {
    try {
      seeds_run_config({set});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(message("veiws=3").find("views"), std::string::npos) << message("veiws=3");
  EXPECT_NE(message("views=-1").find("views"), std::string::npos) << message("views=-1");
  EXPECT_NE(message("views=many").find("views"), std::string::npos) << message("views=many");
  EXPECT_NE(message("rig=no_such_phone").find("phone_video_720p"), std::string::npos);
  EXPECT_NE(message("pipeline.method=magic").find("paper"), std::string::npos);
}

TEST(SeedsPlan, LeavesOutWhatNoScoreReads) {
  const SeedsRunConfig config = seeds_run_config({});
  std::vector<std::string> runs;
  for (const PlanEntry& entry : seeds_plan(config, false)) {
    if (entry.runs) runs.push_back(entry.pass);
  }
  EXPECT_EQ(runs, (std::vector<std::string>{
                      "scene", "physics", "light cache", "radiance", "sensor", "perceive: corners",
                      "perceive: poses", "perceive: depth", "perceive: cloud", "perceive: clusters",
                      "perceive: masks", "perceive: surfaces", "perceive: traits", "score"}));
}

TEST(SeedsPlan, AttributionAddsDepthAndInstancesAndASphereNeedsNoPhysics) {
  const SeedsRunConfig config = seeds_run_config({"sphere=true", "pipeline.method=paper"});
  for (const PlanEntry& entry : seeds_plan(config, true)) {
    if (entry.pass == "physics" || entry.pass == "perceive: masks" ||
        entry.pass == "truth: normal") {
      EXPECT_FALSE(entry.runs) << entry.pass;
    }
    if (entry.pass == "truth: depth" || entry.pass == "truth: instance") {
      EXPECT_TRUE(entry.runs) << entry.pass;
    }
  }
}

TEST(SeedsPlan, NamesTheUsersStages) {
  for (const PlanEntry& entry :
       seeds_plan(seeds_run_config({}), false, {parse_stage_source("depth=exec:/bin/sh")})) {
    EXPECT_EQ(entry.why == "yours: exec:/bin/sh", entry.pass == "perceive: depth") << entry.pass;
  }
}

TEST(SeedsRunConfig, ASavedConfigurationCanBeGivenBack) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "config.toml";
  const SeedsRunConfig saved = seeds_run_config(
      {"cultivar=jimai22", "rig=phone_video_1080p", "rig.prnu=0.002", "pipeline.mvs.neighbours=4"});
  write_file(file, resolved_toml(saved));
  EXPECT_EQ(resolved_toml(seeds_run_config({}, file)), resolved_toml(saved));
  // Keys of the command line come after the file's, and a rig's preset in place of the file's rig.
  EXPECT_EQ(seeds_run_config({"cultivar=suijing18"}, file).scene.cultivar, "suijing18");
  EXPECT_EQ(seeds_run_config({"rig=phone_video_720p"}, file).rig.width_px, 1280);
  // A file may say little; the preset that it names fills the rest.
  write_file(file, "[scene]\nrig = \"phone_video_1080p\"\n[rig]\nprnu = 0.003\n");
  EXPECT_EQ(seeds_run_config({}, file).rig.width_px, 1920);
  EXPECT_EQ(seeds_run_config({}, file).rig.prnu, 0.003);
  write_file(file, "[scene]\nveiws = 3\n");
  EXPECT_THROW(seeds_run_config({}, file), std::runtime_error);
}

TEST(StageSource, ReadsBothFormsAndNamesMistakes) {
  const StageSource folder = parse_stage_source("depth=dir:/");
  EXPECT_EQ(folder.stage, "depth");
  EXPECT_EQ(folder.kind, StageSource::Kind::directory);
  EXPECT_EQ(parse_stage_source("traits=exec:sh").kind, StageSource::Kind::program);
  EXPECT_EQ(parse_stage_source("traits=exec:/bin/sh").kind, StageSource::Kind::program);
  for (const char* text :
       {"depth", "deep=dir:/", "depth=/tmp", "depth=dir:/no/such/folder",
        "depth=exec:", "depth=exec:./no_such_program", "depth=exec:no_such_program"}) {
    EXPECT_THROW(parse_stage_source(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace cousin
