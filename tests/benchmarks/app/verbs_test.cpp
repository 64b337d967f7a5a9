// Each verb does its work, from one to the next, as a user calls them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// stdout as JSON; a discarded value if it is none.
nlohmann::json json_of(const Outcome& outcome) {
  EXPECT_EQ(outcome.err, "");  // --json is quiet
  const auto value = nlohmann::json::parse(outcome.out, nullptr, false);
  EXPECT_FALSE(value.is_discarded()) << outcome.out;
  return value;
}

TEST(AppVerbs, RenderVerifyPerceiveScoreReport) {
  const Program program;
  const Outcome rendered =
      program.run(Words{"render", "seeds", "--out", "data", "--json"} + tiny_scene());
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  EXPECT_EQ(json_of(rendered).value("dataset", ""), "data");
  EXPECT_FALSE(fs::exists(program.path("data/.cousin.render")));

  const Outcome whole = program.run({"verify", "data"});
  EXPECT_EQ(whole.code, 0) << whole.out;
  EXPECT_EQ(whole.out, "data: no problems\n");
  EXPECT_TRUE(json_of(program.run({"verify", "data", "--json"}))["problems"].empty());

  // An empty board: both views are posed, no specimen is found, and that is said and scored.
  const Outcome perceived = program.run({"perceive", "data", "--out", "est"});
  EXPECT_EQ(perceived.code, 3);
  EXPECT_THAT(perceived.err, HasSubstr("cousin: data/000000: 2 of 2 views posed, 0 specimens: "));
  const Outcome scored =
      program.run({"score", "data", "est", "--json", "--gate", "views.posed>=1"});
  EXPECT_EQ(scored.code, 0) << scored.err;
  EXPECT_GT(json_of(scored)["scores"].size(), 0U);
  const Outcome broken = program.run({"score", "data", "est", "--gate", "views.posed>=2"});
  EXPECT_EQ(broken.code, 1);
  EXPECT_THAT(broken.err, HasSubstr("gate views.posed>=2"));
  const Outcome reported = program.run({"report", "est", "--json"});
  EXPECT_EQ(reported.code, 0) << reported.err;
  EXPECT_THAT(read_file(program.path(json_of(reported).value("report", ""))), HasSubstr("</html>"));

  // Without truth the same bytes come out, and the dataset is valid.
  const auto before = contents(program.path("est"));
  fs::remove_all(program.path("data/000000/truth"));
  EXPECT_EQ(program.run({"verify", "data"}).code, 0);
  EXPECT_EQ(program.run({"perceive", "data", "--out", "est2"}).code, 3);
  for (const auto& [file, bytes] : contents(program.path("est2"))) {
    EXPECT_EQ(bytes, before.at(file)) << file;
  }
  const Outcome no_truth = program.run({"score", "data", "est"});
  EXPECT_EQ(no_truth.code, 3);
  EXPECT_THAT(no_truth.err, HasSubstr("data/000000: there is no truth/"));
}

TEST(AppVerbs, RunWritesScoresAndReport) {
  const Program program;
  write_file(program.path("mine/parts/of_a_flower.txt"), "petals");
  const Outcome run = program.run(
      Words{"run", "seeds", "--out", "r", "--json", "--gate", "views.posed>=2"} + tiny_scene());
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("gate views.posed>=2"));
  EXPECT_EQ(nlohmann::json::parse(run.out, nullptr, false),
            nlohmann::json::parse(read_file(program.path("r/scores.json")), nullptr, false));
  for (const char* file : {"scores.csv", "specimens.csv", "report.html"}) {
    EXPECT_GT(fs::file_size(program.path("r") / file), 0U) << file;
  }
  // Every time comes with its memory: in all, and above what the program takes before its work.
  int timed = 0;
  const nlohmann::json file = nlohmann::json::parse(run.out);
  for (const nlohmann::json& row : file["scores"]) {
    if (!row.value("metric", "").starts_with("seconds.")) continue;
    ++timed;
    EXPECT_GT(row.at("peak_above_start_mb").get<double>(), 0) << row;
    EXPECT_LT(row.at("peak_above_start_mb").get<double>(), row.at("peak_rss_mb").get<double>());
  }
  EXPECT_GT(timed, 5);
  EXPECT_FALSE(fs::exists(program.path("r/parts")));
  // A folder of that name that was there before loses nothing but the run's own files.
  EXPECT_EQ(
      program.run(Words{"run", "seeds", "--out", "mine", "--scenes", "2"} + tiny_scene()).code, 0);
  EXPECT_EQ(contents(program.path("mine/parts")),
            (std::map<std::string, std::string>{{"of_a_flower.txt", "petals"}}));
}

TEST(AppVerbs, ShardsOfARenderMakeTheDatasetOfOneRun) {
  const Program program;
  const Words render = Words{"render", "seeds"} + tiny_scene();
  ASSERT_EQ(program.run(render + Words{"--out", "whole"}).code, 0);
  // In this order the index is written before the second view is there.
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "0/2"}).code, 0);
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "1/2"}).code, 0);
  auto files = contents(program.path("data"));
  EXPECT_EQ(files.erase("manifest.0-of-2.json") + files.erase("manifest.1-of-2.json"), 2U);
  EXPECT_EQ(files, contents(program.path("whole")));
}

TEST(AppVerbs, RenderWritesTheTruthThatIsAskedFor) {
  const Program program;
  const Words render = Words{"render", "seeds", "--out"};
  const auto folders = [&](const std::string& dataset) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(program.path(dataset + "/000000/truth"))) {
      if (entry.is_directory()) names.insert(entry.path().filename().string());
    }
    return names;
  };
  ASSERT_EQ(program.run(render + Words{"default"} + tiny_scene()).code, 0);
  ASSERT_EQ(program.run(render + Words{"all", "--truth", "all"} + tiny_scene()).code, 0);
  ASSERT_EQ(program.run(render + Words{"two", "--truth", "part,depth"} + tiny_scene()).code, 0);
  ASSERT_EQ(program.run(render + Words{"none", "--truth", "none"} + tiny_scene()).code, 0);
  // An empty board: there is no specimen to have a mask.
  EXPECT_EQ(folders("default"), std::set<std::string>({"models"}));
  EXPECT_EQ(folders("all"), std::set<std::string>({"coverage", "depth", "flow", "instance",
                                                   "models", "normal", "part", "position"}));
  EXPECT_EQ(folders("two"), std::set<std::string>({"depth", "models", "part"}));
  EXPECT_EQ(folders("none"), std::set<std::string>({"models"}));
  for (const char* dataset : {"all", "two", "none"}) {
    EXPECT_EQ(program.run({"verify", dataset}).code, 0) << dataset;
    // What is written beside the photographs does not change them.
    for (const char* image : {"000000/rgb/000000.png", "000000/rgb/000001.png"}) {
      EXPECT_EQ(read_file(program.path(dataset) / image),
                read_file(program.path("default") / image));
    }
  }
  const Image<float> depth_m = read_npy(program.path("two/000000/truth/depth/000001.npy"));
  EXPECT_EQ(depth_m.width(), 320);
  EXPECT_GT(depth_m(160, 90), 0.1F);
  EXPECT_EQ(read_png16(program.path("two/000000/truth/part/000001.png"))(160, 90), 0);

  // One choice a folder; the same in other words is the same.
  const Outcome again =
      program.run(render + Words{"two", "--truth", "depth,part", "--quiet"} + tiny_scene());
  EXPECT_EQ(again.code, 0) << again.err;
  const Outcome other = program.run(render + Words{"two", "--truth", "depth"} + tiny_scene());
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("two/manifest.json belongs to another configuration, seed or "
                                   "choice of truth"));
  const Outcome unknown = program.run(render + Words{"new", "--truth", "depth,colour"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(
      unknown.err,
      HasSubstr(
          "\"colour\" is not one of depth, normal, instance, part, position, "
          "coverage, visibility, shares, keypoints, leaf_area, flow, disparity, noise_free_depth, "
          "invalid_reason, all, none"));
  EXPECT_FALSE(fs::exists(program.path("new")));
}

TEST(AppVerbs, ASlashOrADotAtTheEndOfAPathChangesNothing) {
  const Program program;
  write_png(program.path("photos/a.png"), Image<Rgb8>(64, 48, {90, 90, 90}));
  const auto import = [&](const std::string& path) {
    return program.run({"import", path, "--format", "folder", "--intrinsics", "60,60,32,24"});
  };
  EXPECT_EQ(import("photos/").code, 0);
  EXPECT_TRUE(fs::exists(program.path("out/photos/000000/rig.json")));
  fs::remove_all(program.path("out"));
  EXPECT_EQ(import("photos/.").code, 0);
  EXPECT_TRUE(fs::exists(program.path("out/photos/000000/rig.json")));

  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "data/"} + tiny_scene()).code, 0);
  EXPECT_THAT(program.run({"perceive", "data/"}).err, HasSubstr("estimates: data_estimate\n"));
  EXPECT_THAT(program.run({"perceive", "data/000000/", "--pipeline", "seeds", "--out", "est/"}).err,
              HasSubstr("000000: 2 of 2 views posed"));
  EXPECT_TRUE(fs::exists(program.path("est/000000/traits.json")));
  EXPECT_EQ(program.run({"score", "data/", "data_estimate//"}).code, 0);
  EXPECT_THAT(read_file(program.path("data_estimate/scores.csv")), HasSubstr("\ndata,000000,"));

  // Only six digits are a scene's number.
  fs::rename(program.path("data/000000"), program.path("20260101123456"));
  EXPECT_THAT(
      program.run({"perceive", "20260101123456", "--pipeline", "seeds", "--out", "day"}).err,
      HasSubstr("20260101123456: 2 of 2 views posed"));
  EXPECT_TRUE(fs::exists(program.path("day/000000/traits.json")));
}

TEST(AppVerbs, VerifyNamesAnEditedFile) {
  const Program program;
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "data"} + tiny_scene()).code, 0);
  const fs::path camera = program.path("data/000000/scene_camera.json");
  write_file(camera, read_file(camera) + " ");
  fs::remove(program.path("data/000000/rgb/000001.png"));
  const Outcome edited = program.run({"verify", "data"});
  EXPECT_EQ(edited.code, 3);
  EXPECT_THAT(edited.out,
              AllOf(HasSubstr("000000/scene_camera.json: "), HasSubstr("000000/rgb/000001.png: "),
                    Not(HasSubstr("rgb/000000.png"))));
  EXPECT_EQ(json_of(program.run({"verify", "data", "--json"}))["problems"].size(), 2U);
  EXPECT_EQ(program.run({"verify", "absent"}).code, 3);

  // The folder belongs to its configuration: another one is not mixed into it.
  const Outcome other =
      program.run(Words{"render", "seeds", "--out", "data", "--seed", "2"} + tiny_scene());
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("data/manifest.json belongs to another configuration"));
}

TEST(AppVerbs, AFolderOfImagesIsImported) {
  const Program program;
  for (const char* name : {"b.png", "a.png"}) {
    write_png(program.path("photos") / name, Image<Rgb8>(64, 48, {90, 90, 90}));
  }
  const Words import = {"import", "photos", "--format", "folder", "--out", "real"};
  const Outcome imported = program.run(import + Words{"--intrinsics", "60,60,32,24", "--json"});
  ASSERT_EQ(imported.code, 0) << imported.err;
  EXPECT_EQ(json_of(imported).value("frames", 0), 2);
  EXPECT_EQ(program.run({"verify", "real"}).code, 0);
  const Outcome unnamed = program.run({"perceive", "real", "--out", "est"});
  EXPECT_EQ(unnamed.code, 2);
  EXPECT_THAT(unnamed.err, HasSubstr("give --pipeline, one of seeds"));
  const Outcome other = program.run({"perceive", "real", "--out", "est", "--pipeline", "roots"});
  EXPECT_EQ(other.code, 2);
  EXPECT_THAT(other.err, HasSubstr("pipeline \"roots\" is not one of: seeds"));

  const Outcome no_file = program.run(import + Words{"--intrinsics", "camera.yaml"});
  EXPECT_EQ(no_file.code, 3);
  EXPECT_THAT(no_file.err, HasSubstr("camera.yaml"));
  const Outcome nan = program.run(import + Words{"--intrinsics", "nan,60,32,24"});
  EXPECT_EQ(nan.code, 2);
  EXPECT_THAT(nan.err, HasSubstr("number 1"));
  write_png(program.path("photos/c.png"), Image<Rgb8>(48, 64));
  const Outcome size = program.run(import + Words{"--intrinsics", "60,60,32,24"});
  EXPECT_EQ(size.code, 3);
  EXPECT_THAT(size.err, AllOf(HasSubstr("c.png"), HasSubstr("48 x 64")));
}

}  // namespace
}  // namespace cousin
