// The scenes of plants, as a user meets them: rendered, verified, exported; not yet measured.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

nlohmann::json json_in(const fs::path& file) {
  return nlohmann::json::parse(read_file(file), nullptr, false);
}

/// A square of 40 x 60 units on a stem's box, each an object of its own.
std::string seedling_obj() {
  return "o leaf\nv -20 -30 50\nv 20 -30 50\nv 20 30 50\nv -20 30 50\nf 1 2 3 4\n"
         "o stem\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nv 0 0 50\nf 5 7 6\nf 5 6 8\nf 6 7 8\nf 7 5 8\n";
}

TEST(PlantScenes, AUsersMeshIsRenderedWithItsTraitsAndLeafAreas) {
  const Program program;
  write_file(program.path("mine.obj"), seedling_obj());
  const Words render = {"render",   "specimen",
                        "--set",    "mesh=mine.obj",
                        "--set",    "rig.width_px=64",
                        "--set",    "rig.height_px=48",
                        "--set",    "render.pixel_samples=1",
                        "--frames", "2",
                        "--truth",  "visibility,leaf_area"};
  const Outcome refused = program.run(render + Words{"--out", "metres"});
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("mine.obj"), HasSubstr("unit=mm")));
  EXPECT_FALSE(fs::exists(program.path("metres/000000")));

  const Outcome done = program.run(render + Words{"--out", "mine", "--set", "unit=mm"});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(program.run({"verify", "mine"}).out, "mine: no problems\n");
  const nlohmann::json traits = json_in(program.path("mine/000000/truth/traits.json"));
  std::map<std::string, double> values;
  for (const auto& trait : traits["instances"][0]["traits"])
    values[trait["name"]] = trait["value"].get<double>();
  EXPECT_NEAR(values["height"], 0.05, 1e-12);
  EXPECT_NEAR(values["leaf_area"], 0.04 * 0.06, 1e-12);
  EXPECT_EQ(values["watertight"], 0);
  EXPECT_FALSE(values.contains("volume"));
  // Views from above see all of a leaf that nothing hides.
  for (const auto* part : {"views", "frames"}) ASSERT_TRUE(traits.contains(part)) << part;
  const auto& seen = traits["views"][0]["traits"][1];
  EXPECT_EQ(seen["name"], "visible_leaf_area");
  EXPECT_NEAR(seen["value"].get<double>(), 0.04 * 0.06, 1e-6);
  EXPECT_EQ(traits["frames"].size(), 2U);

  // Another file under the same name is another dataset.
  write_file(program.path("mine.obj"), seedling_obj() + "# changed\n");
  EXPECT_EQ(program.run(render + Words{"--out", "mine", "--set", "unit=mm"}).code, 2);
  const Outcome absent =
      program.run({"render", "specimen", "--set", "mesh=none.ply", "--out", "none"});
  EXPECT_EQ(absent.code, 3);
  EXPECT_THAT(absent.err, HasSubstr("none.ply"));
  const Outcome unset = program.run({"render", "specimen", "--out", "none"});
  EXPECT_EQ(unset.code, 2);
  EXPECT_THAT(unset.err, HasSubstr("--set mesh=FILE"));
  EXPECT_EQ(program.run({"render", "specimen", "--keys"}).code, 0);
}

TEST(PlantScenes, AreListedWithWhatTheyLack) {
  const Outcome listed = Program().run({"scenes"});
  EXPECT_EQ(listed.code, 0);
  EXPECT_THAT(listed.out, AllOf(HasSubstr("seeds "), HasSubstr("seedlings "), HasSubstr("maize "),
                                HasSubstr("strawberries "), HasSubstr("apples "),
                                HasSubstr("no pipeline yet")));
}

TEST(PlantScenes, SeedlingsAreRenderedVerifiedAndRefusedByThePipelines) {
  const Program program;
  const Outcome rendered = program.run(
      Words{"render", "seedlings", "--out", "tray", "--json", "--truth", "part,keypoints"} +
      tiny_tray());
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  EXPECT_TRUE(nlohmann::json::parse(rendered.out)["seconds"].contains("build 000000"));
  EXPECT_EQ(program.run({"verify", "tray"}).out, "tray: no problems\n");
  const nlohmann::json traits = json_in(program.path("tray/000000/truth/traits.json"));
  EXPECT_GE(traits["instances"].size(), 4U);  // each cell's, and each plant's
  EXPECT_FALSE(json_in(program.path("tray/000000/truth/keypoints.json")).is_discarded());

  const Outcome perceived = program.run({"perceive", "tray", "--out", "est"});
  EXPECT_EQ(perceived.code, 2);
  EXPECT_THAT(perceived.err, HasSubstr("is of scene \"seedlings\", which has no pipeline yet"));
  const Outcome run = program.run({"run", "seedlings"});
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, AllOf(HasSubstr("no pipeline of its own yet"), HasSubstr("--pipeline scene"),
                             HasSubstr("cousin render seedlings")));
  const Outcome plan = program.run({"run", "seedlings", "--plan"});
  EXPECT_EQ(plan.code, 0);
  EXPECT_THAT(plan.out, AllOf(HasSubstr("radiance"), HasSubstr("left out:"),
                              HasSubstr("there is no pipeline for this scene yet")));
}

TEST(PlantScenes, ShardsOfATrayMakeTheDatasetOfOneRunOnOtherThreads) {
  const Program program;
  const Words render = Words{"render", "seedlings"} + tiny_tray();
  ASSERT_EQ(program.run(render + Words{"--out", "whole", "--threads", "1"}).code, 0);
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "1/2"}).code, 0);
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "0/2"}).code, 0);
  auto files = contents(program.path("data"));
  EXPECT_EQ(files.erase("manifest.0-of-2.json") + files.erase("manifest.1-of-2.json"), 2U);
  EXPECT_EQ(files, contents(program.path("whole")));
}

TEST(PlantScenes, AGrowthSeriesIsOneTrayOnOneDayAfterAnother) {
  const Program program;
  ASSERT_EQ(program
                .run(Words{"render", "seedlings", "--out", "days", "--scenes", "3", "--streams",
                           "color", "--truth", "none", "--set", "day=3", "--set", "day_step=4"} +
                     tiny_tray())
                .code,
            0);
  std::map<int, double> before;
  for (const char* scene : {"000000", "000001", "000002"}) {
    std::map<int, double> area;
    const nlohmann::json traits = json_in(program.path("days") / scene / "truth" / "traits.json");
    for (const auto& instance : traits["instances"]) {
      for (const auto& trait : instance["traits"]) {
        if (trait["name"] == "leaf_area") area[instance["instance"]] = trait["value"];
      }
    }
    ASSERT_FALSE(area.empty());
    for (const auto& [id, value] : before) EXPECT_GE(area[id], value) << id;
    before = area;
  }
}

TEST(PlantScenes, MaizeIsSeenByTwoCamerasWithAllItsTruth) {
  const Program program;
  const Outcome rendered =
      program.run({"render", "maize", "--out", "field", "--frames", "1", "--set", "stage=V6",
                   "--set", "rig=zed_hd720", "--set", "render.pixel_samples=1", "--set",
                   "maize.field.cell_m=0.2", "--truth", "part,keypoints,disparity", "--json"});
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  EXPECT_TRUE(fs::exists(program.path("field/000000/truth/disparity/000000.npy")));
  EXPECT_THAT(read_file(program.path("field/000000/truth/keypoints.json")), HasSubstr("node "));
  const fs::path right = program.path("field/000000/truth/sensors/rgb_right");
  EXPECT_TRUE(fs::exists(right / "part/000000.png"));
  EXPECT_FALSE(fs::exists(right / "disparity"));
  const nlohmann::json here = json_in(program.path("field/000000/truth/keypoints.json"))["frames"],
                       there = json_in(right / "keypoints.json")["frames"];
  ASSERT_EQ(here["0"].size(), there["0"].size());
  EXPECT_NE(here["0"][0]["u_px"], there["0"][0]["u_px"]);
  EXPECT_EQ(program.run({"verify", "field"}).code, 0);
}

TEST(PlantScenes, ABoardNamesItsDesignAndHasItsCornersInEveryView) {
  const Program program;
  const Outcome rendered = program.run(
      {"render", "boards", "--out", "board", "--frames", "2", "--set", "place=hand", "--set",
       "board=chessboard_a4", "--set", "flaws.warp_x_m=0.003", "--set", "rig.width_px=160", "--set",
       "rig.height_px=90", "--set", "render.pixel_samples=1"});
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  EXPECT_EQ(json_in(program.path("board/000000/rig.json"))["board"],
            "chessboard columns=10 rows=7 pitch_m=0.025");
  const nlohmann::json keypoints = json_in(program.path("board/000000/truth/keypoints.json"));
  for (const char* frame : {"0", "1"}) {
    ASSERT_EQ(keypoints["frames"][frame].size(), 54U);
    for (const auto& point : keypoints["frames"][frame]) EXPECT_EQ(point["state"], "visible");
  }
  EXPECT_NE(keypoints["frames"]["0"][0]["u_px"], keypoints["frames"]["1"][0]["u_px"]);
  EXPECT_EQ(program.run({"verify", "board"}).code, 0);
}

TEST(PlantScenes, EveryTableOfCousinsMovesKeysOfItsSceneWithinTheirLimits) {
  const Program program;
  const std::map<std::string, Words> axes = {
      {"seeds", {"shape", "growth", "texture", "light", "sensor"}},
      {"seedlings", {"shape", "growth", "texture", "light", "sensor"}},
      {"maize", {"shape", "growth", "texture", "light", "sensor"}},
      {"strawberries", {"shape", "growth", "texture", "light", "sensor"}},
      {"apples", {"shape", "growth", "texture", "light", "sensor"}},
      {"boards", {"shape", "texture", "light", "sensor"}}};
  const bool has_physics = program.run({"scenes"}).out.find("WITH_MUJOCO") == std::string::npos;
  for (const auto& [scene, names] : axes) {
    if (scene == "strawberries" && !has_physics) continue;
    Words words = {"run", scene, "--plan"};
    for (const std::string& name : names) words = words + Words{"--set", "cousin." + name + "=1"};
    const Outcome planned = program.run(words);
    EXPECT_EQ(planned.code, 0) << scene << ": " << planned.err;
  }
}

TEST(PlantScenes, ACousinAtZeroIsTheSceneItselfAndAFarOneSaysWhatWasMoved) {
  const Program program;
  const auto render = [&](const std::string& out, const Words& more) {
    return program.run(Words{"render", "seedlings", "--out", out} + tiny_tray() + more).code;
  };
  ASSERT_EQ(render("plain", {}), 0);
  ASSERT_EQ(render("twin", {"--set", "cousin.growth=0"}), 0);
  ASSERT_EQ(render("far", {"--set", "cousin.growth=1"}), 0);
  EXPECT_EQ(contents(program.path("plain")), contents(program.path("twin")));
  const char* image = "000000/rgb/000000.png";
  EXPECT_NE(read_file(program.path("plain") / image), read_file(program.path("far") / image));
  EXPECT_THAT(read_file(program.path("far/000000/truth/config.toml")),
              AllOf(HasSubstr("growth = 1.0"),
                    HasSubstr("# cousin.growth: watermelon.hypocotyl.length_m = 0.045 -> ")));
}

TEST(PlantScenes, ApplesShowTheShareAskedForOfATargetInTheRigsOwnImage) {
  const Program program;
  const Outcome rendered = program.run({"render",
                                        "apples",
                                        "--out",
                                        "row",
                                        "--frames",
                                        "1",
                                        "--json",
                                        "--truth",
                                        "visibility,keypoints",
                                        "--streams",
                                        "color",
                                        "--set",
                                        "trees=1",
                                        "--set",
                                        "rows=1",
                                        "--set",
                                        "fruits=12",
                                        "--set",
                                        "views=1",
                                        "--set",
                                        "occlusion=0.3",
                                        "--set",
                                        "orchard.branch.count=8",
                                        "--set",
                                        "orchard.branch.last_share=0.6",
                                        "--set",
                                        "orchard.fruit.grid=16",
                                        "--set",
                                        "orchard.leaf.teeth=0",
                                        "--set",
                                        "orchard.ground.reach_m=0",
                                        "--set",
                                        "render.pixel_samples=1"});
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const nlohmann::json traits = json_in(program.path("row/000000/truth/traits.json"));
  std::map<std::string, double> tree;
  for (const auto& trait : traits["instances"][0]["traits"]) tree[trait["name"]] = trait["value"];
  ASSERT_EQ(tree.at("met 000000"), 1);
  const nlohmann::json info = json_in(program.path("row/000000/truth/scene_gt_info.json"));
  double visible = -1;
  for (const auto& one : info["0"]) {
    if (one["instance_id"] == static_cast<int>(tree.at("target 000000")))
      visible = one["visib_fract"];
  }
  EXPECT_NEAR(visible, 0.7, 0.03);
  EXPECT_EQ(program.run({"verify", "row"}).code, 0);
}

TEST(PlantScenes, WrongConfigurationsAreRefusedWithKeyValueAndLimit) {
  const Program program;
  const auto refusal = [&](const std::string& scene, const std::string& set) {
    const Outcome outcome = program.run({"render", scene, "--out", "x", "--set", set});
    EXPECT_EQ(outcome.code, 2) << set;
    EXPECT_FALSE(fs::exists(program.path("x"))) << set;
    return outcome.err;
  };
  EXPECT_THAT(refusal("seedlings", "day=-1"), HasSubstr("day"));
  EXPECT_THAT(refusal("seedlings", "day=1000"), AllOf(HasSubstr("1000"), HasSubstr("20")));
  EXPECT_THAT(refusal("seedlings", "light=D9"), HasSubstr("D1, D2, D3"));
  EXPECT_THAT(refusal("seedlings", "rig=none"), HasSubstr("none"));
  EXPECT_THAT(refusal("seedlings", "watermelon.leaf.lobes=[1]"), HasSubstr("leaf.lobes"));
  EXPECT_THAT(refusal("maize", "stage=V1"), HasSubstr("V3 .. V18, VT"));
  EXPECT_THAT(refusal("maize", "rows=0"), HasSubstr("rows"));
  EXPECT_THAT(refusal("boards", "cousin.growth=1"), HasSubstr("moves nothing"));
  EXPECT_THAT(refusal("maize", "cousin.light=2"), HasSubstr("cousin.light"));
  EXPECT_THAT(refusal("boards", "board=a5"), HasSubstr("charuco_a4"));
  EXPECT_THAT(refusal("boards", "poses.fill_max=1.5"), HasSubstr("outside is 0"));
  EXPECT_THAT(refusal("apples", "distance_min_m=0.01"), HasSubstr("inside a fruit"));
  EXPECT_THAT(refusal("apples", "orchard.wood.albedo=[1]"), HasSubstr("wood.albedo"));
}

}  // namespace
}  // namespace cousin
