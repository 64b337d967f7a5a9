#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <variant>

#include "benchmarks/loop/plan.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/stage_files.h"
#include "benchmarks/loop/truth_choice.h"
#include "scenes/seeds/seeds_text.h"
#include "sim/dataset/atomic_file.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

/// What a mistake of the caller is told; "" if there is none.
template <class Work>
std::string refusal_of(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

const PhoneConfig& phone_of(const RunConfig& config) { return std::get<PhoneConfig>(config.rig); }

std::vector<std::string> passes(const RunConfig& config, bool run) {
  std::vector<std::string> names;
  for (const PlanEntry& entry : run_plan(config, false)) {
    if (entry.runs == run) names.push_back(entry.pass);
  }
  return names;
}

TEST(SeedsRunConfig, TheResolvedTextReadsBackToItself) {
  const RunConfig config =
      seeds_run_config({"cultivar=jimai22", "rig.read_noise_e=3", "pipeline.mvs.neighbours=4"});
  EXPECT_EQ(seeds_scene(config).cultivar, "jimai22");
  EXPECT_EQ(phone_of(config).read_noise_e, 3);
  RunConfig copy = seeds_run_config({});
  std::string by;
  read_toml_text(
      resolved_toml(config), "resolved",
      nested("scene", fields(copy.scene)) +
          nested("capture", Fields{{"streams", &copy.streams, ""}} + fields(copy.capture)) +
          nested("rig", fields(copy.rig)) +
          nested("render", Fields{{"by", &by, ""}} + fields(copy.cached)) +
          nested("pipeline", fields(*copy.pipeline)) + nested("cousin", fields(copy.cousin)),
      MissingKeys::error);
  EXPECT_EQ(by, "cached");
  EXPECT_EQ(resolved_toml(copy), resolved_toml(config));
  EXPECT_NE(config_hash(config, 1), config_hash(config, 2));
}

TEST(SeedsRunConfig, TheScenesTextNamesEveryCultivar) {
  for (const std::string& name : cultivar_names())
    EXPECT_NE(kSeedsText.help.find(name), std::string_view::npos) << name;
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
  EXPECT_EQ(
      all,
      "depth,normal,instance,part,position,coverage,visibility,shares,keypoints,leaf_area,flow");
  EXPECT_EQ(to_string(truth_needs_from_string(all)), all);
  EXPECT_EQ(to_string(truth_needs_from_string("none")), "none");
  EXPECT_EQ(to_string(truth_there_is(device_preset("zed_hd720"), {.color = true})),
            all + ",disparity");
  const TruthNeeds of_depth = truth_there_is(device_preset("d405"), {.depth = true});
  EXPECT_EQ(to_string(of_depth), all + ",noise_free_depth,invalid_reason");
  EXPECT_EQ(truth_needs_from_string("all", of_depth), of_depth);
  EXPECT_EQ(to_string(default_truth({.depth = true})),
            "visibility,noise_free_depth,invalid_reason");
  EXPECT_EQ(to_string(default_truth({.color = true})), "visibility");
  for (const char* wrong : {"disparity", "invalid_reason", "", "depth,", ",depth", "depth, part",
                            "Depth", "all,depth", "none,all"})
    EXPECT_THROW(truth_needs_from_string(wrong), std::invalid_argument) << wrong;
}

TEST(SeedsRunConfig, TheRigsPresetComesBeforeTheUsersKeysWhateverTheirOrder) {
  const RunConfig config = seeds_run_config({"rig.prnu=0.002", "rig=phone_video_1080p"});
  EXPECT_EQ(phone_of(config).width_px, 1920);
  EXPECT_EQ(phone_of(config).prnu, 0.002);
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
  EXPECT_EQ(
      passes(seeds_run_config({}), true),
      (std::vector<std::string>{"scene", "physics", "row poses", "light cache", "radiance",
                                "sensor", "perceive: corners", "perceive: poses", "perceive: depth",
                                "perceive: cloud", "perceive: clusters", "perceive: masks",
                                "perceive: surfaces", "perceive: traits", "score"}));
  const std::vector<std::string> left = passes(seeds_run_config({}), false);
  EXPECT_EQ(left.front(), "motion");
  for (const char* pass : {"raw", "infrared", "sensor depth", "truth: depth", "truth: disparity"})
    EXPECT_NE(std::find(left.begin(), left.end(), pass), left.end()) << pass;
}

TEST(SeedsPlan, ADepthCameraWhoseColourAloneIsReadRendersNoInfraredAndMatchesNothing) {
  const RunConfig config = seeds_run_config({"rig=d405"});
  EXPECT_EQ(passes(config, true),
            (std::vector<std::string>{"scene", "physics", "light cache", "radiance", "sensor",
                                      "perceive: corners", "perceive: poses", "perceive: depth",
                                      "perceive: cloud", "perceive: clusters", "perceive: masks",
                                      "perceive: surfaces", "perceive: traits", "score"}));
  for (const PlanEntry& entry : run_plan(config, false)) {
    if (entry.pass == "infrared")
      EXPECT_EQ(entry.why, "no stage reads infrared or the sensor's depth");
    if (entry.pass == "sensor depth") EXPECT_EQ(entry.why, "no stage reads the sensor's depth");
    if (entry.pass == "row poses")
      EXPECT_EQ(entry.why, "rig d405 has a global shutter: one pose an image");
  }
  // With the sensor's depth read, both run; by the fast model no infrared does.
  const std::vector<std::string> read =
      passes(seeds_run_config({"rig=d405", "pipeline.method=sensor_depth"}), true);
  for (const char* pass : {"radiance", "infrared", "sensor depth"})
    EXPECT_NE(std::find(read.begin(), read.end(), pass), read.end()) << pass;
  const std::vector<std::string> fast = passes(
      seeds_run_config({"rig=d457", "depth_by=model", "pipeline.method=sensor_depth"}), true);
  EXPECT_EQ(std::find(fast.begin(), fast.end(), "infrared"), fast.end());
}

TEST(SeedsPlan, APipelineThatReadsDepthAloneTracesNoLight) {
  const RunConfig config =
      seeds_run_config({"rig=d457", "knows_pose=true", "pipeline.method=depth_only"});
  EXPECT_EQ(
      passes(config, true),
      (std::vector<std::string>{"scene", "physics", "infrared", "sensor depth", "perceive: poses",
                                "perceive: depth", "perceive: cloud", "perceive: clusters",
                                "perceive: surfaces", "perceive: traits", "score"}));
  EXPECT_EQ(planned_streams(config), Streams{.depth = true});
}

TEST(SeedsPlan, PathsTakeThePlaceOfTheLightCache) {
  const RunConfig config = seeds_run_config({"render.by=paths", "render.pixel_samples=24"});
  const std::vector<std::string> run = passes(config, true), left = passes(config, false);
  EXPECT_NE(std::find(run.begin(), run.end(), "radiance"), run.end());
  EXPECT_NE(std::find(left.begin(), left.end(), "light cache"), left.end());
  const auto why_of = [](const std::vector<std::string>& sets) {
    for (const PlanEntry& entry : run_plan(seeds_run_config(sets), false)) {
      if (entry.pass == "radiance") return entry.why;
    }
    return std::string();
  };
  EXPECT_EQ(why_of({"render.by=paths", "render.pixel_samples=24"}),
            "the pipeline reads colour; paths, 24 samples a pixel");
  EXPECT_EQ(why_of({}), "the pipeline reads colour; cached, 4 samples a pixel, 144 at edges");
  EXPECT_EQ(why_of({"rig=d457", "knows_pose=true", "pipeline.method=depth_only"}),
            "no stage reads colour");
}

TEST(SeedsRunConfig, TheRendererThatRunsNamesTheImages) {
  const auto text = [](const std::vector<std::string>& sets) {
    return simulator_toml(seeds_run_config(sets));
  };
  EXPECT_NE(text({"render.pixel_samples=9"}), text({}));
  EXPECT_NE(text({"render.by=paths"}), text({}));
  EXPECT_NE(text({"render.by=paths", "render.pixel_samples=24"}), text({"render.by=paths"}));
  EXPECT_NE(refusal_of([&] { text({"render.by=mirrors"}); }).find("cached, paths"),
            std::string::npos);
  EXPECT_NE(refusal_of([&] { text({"render.pixel_samples=0"}); }).find("pixel_samples"),
            std::string::npos);
}

TEST(SeedsPlan, APassiveRigMakesNoInfrared) {
  for (const PlanEntry& entry : run_plan(seeds_run_config({"rig=zed_hd720"}), false)) {
    if (entry.pass == "infrared") {
      EXPECT_FALSE(entry.runs);
      EXPECT_EQ(entry.why, "rig zed_hd720 has no infrared pair");
    }
    if (entry.pass == "sensor depth") {
      EXPECT_FALSE(entry.runs);
      EXPECT_EQ(entry.why, "rig zed_hd720 has no depth sensor");
    }
  }
}

TEST(SeedsStreams, AreWhatIsReadAndForADatasetAllThatThereIs) {
  const auto text = [](const std::vector<std::string>& sets, Reader reader) {
    return to_string(planned_streams(seeds_run_config(sets), reader));
  };
  EXPECT_EQ(text({}, Reader::pipeline), "color");
  EXPECT_EQ(text({}, Reader::anybody), "color");
  EXPECT_EQ(text({"rig=d457"}, Reader::pipeline), "color");
  EXPECT_EQ(text({"rig=d457"}, Reader::anybody), "color,infrared,depth");
  EXPECT_EQ(text({"rig=d457", "streams=depth"}, Reader::anybody), "depth");
  EXPECT_EQ(text({"rig=d457", "streams=all"}, Reader::pipeline), "color,infrared,depth");
  const auto mistake = [&](const std::vector<std::string>& sets) {
    return refusal_of([&] { text(sets, Reader::pipeline); });
  };
  EXPECT_EQ(mistake({"rig=d457", "streams=depth"}),
            "streams = \"depth\" leaves out what method ours reads: color");
  EXPECT_EQ(mistake({"pipeline.method=sensor_depth"}),
            "method sensor_depth reads color,depth; rig phone_video_720p has color");
  EXPECT_NE(mistake({"streams=infrared"}).find("rig phone_video_720p has no infrared"),
            std::string::npos);
}

TEST(SeedsRunConfig, RigsOfEveryKindReadBackFromTheirResolvedText) {
  const TemporaryFolder folder;
  for (const auto& sets : std::vector<std::vector<std::string>>{
           {"rig=zed_hd720", "rig.rgb_right.trigger_delay_s=0.001"},
           {"rig=d405", "depth_by=matched", "streams=depth", "rig.columns=848"},
           {"rig=d457", "depth_by=model", "rig.color.photosites.read_noise_e=9"},
           {"rig=kinect_v2", "rig.time_of_flight.side=1", "rig.rgb.photosites.prnu=0.02"},
           {"rig=kinect_v1", "rig.structured_light.axial=barron_malik"},
           {"rig=dslr_apsc_24mp"}}) {
    const RunConfig config = seeds_run_config(sets);
    const auto file = folder.path() / "config.toml";
    write_file(file, resolved_toml(config));
    const RunConfig back = seeds_run_config({}, file);
    EXPECT_EQ(resolved_toml(back), resolved_toml(config)) << sets.front();
    EXPECT_EQ(back.rig.index(), config.rig.index());
  }
}

TEST(SeedsRunConfig, WhatNamesKeptCapturesOfPhonesIsAsItWas) {
  // Captures are kept under a hash of this text: keys that phones do not use are not in it.
  const std::string text = simulator_toml(seeds_run_config({}));
  EXPECT_EQ(text.find("capture"), std::string::npos);
  EXPECT_EQ(text.find("streams"), std::string::npos);
  EXPECT_NE(simulator_toml(seeds_run_config({"knows_pose=true"})), text);
}

TEST(SeedsPlan, AttributionAddsDepthAndInstances) {
  const RunConfig config = seeds_run_config({"sphere=true", "pipeline.method=paper"});
  for (const PlanEntry& entry : run_plan(config, true)) {
    if (entry.pass == "physics") EXPECT_TRUE(entry.runs);  // a sphere is dropped too
    if (entry.pass == "perceive: masks" || entry.pass == "truth: normal") {
      EXPECT_FALSE(entry.runs) << entry.pass;
    }
    if (entry.pass == "truth: depth" || entry.pass == "truth: instance") {
      EXPECT_TRUE(entry.runs) << entry.pass;
    }
  }
}

TEST(SeedsPlan, NamesTheUsersStages) {
  for (const PlanEntry& entry :
       run_plan(seeds_run_config({}), false, {parse_stage_source("depth=exec:/bin/sh")})) {
    EXPECT_EQ(entry.why == "yours: exec:/bin/sh", entry.pass == "perceive: depth") << entry.pass;
  }
}

TEST(SeedsRunConfig, ASavedConfigurationCanBeGivenBack) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "config.toml";
  const RunConfig saved = seeds_run_config(
      {"cultivar=jimai22", "rig=phone_video_1080p", "rig.prnu=0.002", "pipeline.mvs.neighbours=4"});
  write_file(file, resolved_toml(saved));
  EXPECT_EQ(resolved_toml(seeds_run_config({}, file)), resolved_toml(saved));
  // Keys of the command line come after the file's, and a rig's preset in place of the file's rig.
  EXPECT_EQ(seeds_scene(seeds_run_config({"cultivar=suijing18"}, file)).cultivar, "suijing18");
  EXPECT_EQ(phone_of(seeds_run_config({"rig=phone_video_720p"}, file)).width_px, 1280);
  // A file may say little; the preset that it names fills the rest.
  write_file(file, "[scene]\nrig = \"phone_video_1080p\"\n[rig]\nprnu = 0.003\n");
  EXPECT_EQ(phone_of(seeds_run_config({}, file)).width_px, 1920);
  EXPECT_EQ(phone_of(seeds_run_config({}, file)).prnu, 0.003);
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
