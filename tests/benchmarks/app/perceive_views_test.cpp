#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "sim/dataset/capture_io.h"
#include "sim/dataset/seam_io.h"
#include "tests/benchmarks/app/program.h"
#include "tests/benchmarks/loop/box_scene.h"
#include "tests/perception/pipelines/cube_capture.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Words few_steps(const char* steps = "150") {
  return {"--pipeline", "scene",           "--set", std::string("steps=") + steps,
          "--set",      "most_splats=900", "--set", "start_points=500",
          "--set",      "mesh_cells=30",   "--set", "hold_out_every=4"};
}

/// Of the first line that says how far training is; 0: none does.
int first_step(const std::string& err) {
  const std::string words = "splats, step ";
  const std::size_t at = err.find(words);
  return at == std::string::npos ? 0 : std::stoi(err.substr(at + words.size()));
}

TEST(AppPerceiveViews, PhotographsOfAnythingBecomeGaussiansAndScores) {
  const Program program;
  write_capture(program.path("cube/000000"), cube_capture());
  const Outcome ours =
      program.run(Words{"perceive", "cube", "--out", "est", "--json"} + few_steps());
  ASSERT_EQ(ours.code, 0) << ours.err;
  const nlohmann::json scores = nlohmann::json::parse(ours.out);
  bool has_held_out = false;
  for (const nlohmann::json& row : scores["scores"]) {
    if (row["metric"] != "held_out.psnr") continue;
    has_held_out = true;
    EXPECT_EQ(row["n"], 3);
  }
  EXPECT_TRUE(has_held_out) << ours.out.substr(0, 400);
  for (const char* file : {"splats.ply", "splats_seen.csv", "cloud.ply", "meshes/000000.ply",
                           "scores.csv", "config.toml", "pictures/000004.png"})
    EXPECT_TRUE(fs::exists(program.path("est/000000") / file)) << file;
  // Its own model again, as somebody's.
  const Outcome theirs = program.run(
      Words{"perceive", "cube", "--out", "again", "--stage", "splats=dir:est"} + few_steps());
  EXPECT_EQ(theirs.code, 0) << theirs.err;
  EXPECT_THAT(theirs.err, AllOf(HasSubstr("12 of 12 views posed"), HasSubstr("held out")));
  EXPECT_EQ(contents(program.path("again/000000")).at("cloud.ply"),
            contents(program.path("est/000000")).at("cloud.ply"));
}

TEST(AppPerceiveViews, AKilledTrainingGoesOnToTheSameBytes) {
  const Program program;
  write_capture(program.path("cube/000000"), cube_capture());
  const Words words = Words{"perceive", "cube"} + few_steps("1500");
  ASSERT_EQ(program.run(words + Words{"--out", "whole"}).code, 0);
  const fs::path unfinished = program.path("parts/000000/splats.unfinished");
  const Outcome killed =
      program.run_until(words + Words{"--out", "parts"}, [&] { return fs::exists(unfinished); });
  if (killed.signal != SIGKILL) GTEST_SKIP() << "it was finished before it could be killed";
  ASSERT_TRUE(fs::exists(unfinished));
  EXPECT_EQ(first_step(killed.err), 50);
  const Outcome rest = program.run(words + Words{"--out", "parts"});
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_GE(first_step(rest.err), 500);  // there the first checkpoint was
  EXPECT_FALSE(fs::exists(unfinished));
  auto whole = contents(program.path("whole")), parts = contents(program.path("parts"));
  for (auto* files : {&whole, &parts}) files->erase("000000/scores.csv");  // has seconds
  EXPECT_EQ(parts, whole);
}

TEST(AppPerceiveViews, ASceneAsAWholeIsScoredAgainstItsTruth) {
  const Program program;
  const SceneTruth truth = box_on_bench();
  write_capture(program.path("box/000000"), cube_capture());  // of as many frames
  write_truth(program.path("box/000000"), truth);
  const Estimate estimate = measured_box(truth, 0.0005F);
  fs::create_directories(program.path("est/000000"));
  write_cloud(program.path("est/000000"), estimate.cloud);
  const Outcome raw = program.run(
      {"score", "box", "est", "--json", "--gate", "specimens.cloud_seen.accuracy_mean<=0.0006"});
  EXPECT_EQ(raw.code, 0) << raw.err;
  EXPECT_THAT(raw.out, Not(HasSubstr("specimens.missed")));
  const Words tight = {"score", "box", "est", "--gate",
                       "specimens.cloud_seen.accuracy_mean<=0.0004"};
  const Outcome broken = program.run(tight);
  EXPECT_EQ(broken.code, 1) << broken.err;
  EXPECT_THAT(broken.err, HasSubstr("scored as a scene as a whole"));
  EXPECT_THAT(broken.out, HasSubstr("000000 specimens.cloud_seen.f1_1000um"));
  // Without poses nothing can be aligned, and nothing is scored as if it were.
  const Outcome lost = program.run(tight + Words{"--align"});
  EXPECT_EQ(lost.code, 1) << lost.err;
  EXPECT_THAT(lost.out, AllOf(HasSubstr("not_solved"), HasSubstr("alignment.scale")));
  write_poses(program.path("est/000000"), estimate.poses);
  EXPECT_EQ(program.run(tight + Words{"--align"}).code, 1);
  EXPECT_EQ(program
                .run({"score", "box", "est", "--align", "--gate", "alignment.scale>=0.999",
                      "--gate", "alignment.scale<=1.001"})
                .code,
            0);
  Poses unknown = estimate.poses;
  unknown[0].frame = 99;
  write_poses(program.path("est/000000"), unknown);
  const Outcome foreign = program.run({"score", "box", "est"});
  EXPECT_EQ(foreign.code, 3);
  EXPECT_THAT(foreign.err, AllOf(HasSubstr("est/000000"), HasSubstr("frame 99")));
  // Another scene's scores are kept.
  write_capture(program.path("box/000001"), cube_capture());
  write_truth(program.path("box/000001"), truth);
  fs::create_directories(program.path("est/000001"));
  write_cloud(program.path("est/000001"), estimate.cloud);
  const Outcome half = program.run({"score", "box", "est"});
  EXPECT_EQ(half.code, 3);
  EXPECT_THAT(half.err,
              AllOf(HasSubstr("1 of 2 scenes could not be scored"), HasSubstr("frame 99")));
  EXPECT_THAT(half.out, HasSubstr("000001 specimens.cloud_seen.f1_1000um"));
  EXPECT_TRUE(fs::exists(program.path("est/scores.csv")));
  fs::remove_all(program.path("est/000001"));
  // One that was left before its traits is not taken for another kind.
  write_corners(program.path("est/000000"), {});
  const Outcome cut = program.run({"score", "box", "est"});
  EXPECT_EQ(cut.code, 3);
  EXPECT_THAT(cut.err, HasSubstr("traits.json"));
  // An estimate that told specimens apart says lengths in metres.
  write_traits(program.path("est/000000"), {});
  const Outcome seeds = program.run({"score", "box", "est", "--align"});
  EXPECT_EQ(seeds.code, 2);
  EXPECT_THAT(seeds.err, HasSubstr("has traits.json"));
}

TEST(AppRunViews, AnySceneBecomesGaussiansNumbersAndAPage) {
  const Program program;
  const Words tray = tiny_tray() + Words{"--frames", "8", "--set", "knows_pose=true"};
  const Words words =
      Words{"run", "seedlings", "--pipeline", "scene", "--out", "tray", "--scenes", "2"} + tray +
      Words{"--set", "pipeline.steps=60",         "--set", "pipeline.most_splats=900",
            "--set", "pipeline.start_points=500", "--set", "pipeline.mesh_cells=30",
            "--set", "pipeline.hold_out_every=4"};
  const Outcome run = program.run(words + Words{"--json", "--gate", "views.posed>=1"});
  ASSERT_EQ(run.code, 0) << run.err;
  const nlohmann::json scores = nlohmann::json::parse(run.out)["scores"];
  const auto rows = [&](const std::string& metric) {
    return std::count_if(scores.begin(), scores.end(),
                         [&](const nlohmann::json& row) { return row["metric"] == metric; });
  };
  for (const char* metric : {"held_out.psnr", "camera.centre_rms", "surface.seen", "gaussians",
                             "seconds.splats", "seconds.render"})
    EXPECT_EQ(rows(metric), 2) << metric;
  for (const char* file : {"report.html", "scores.csv", "config.toml", "estimate/000001/splats.ply",
                           "report/000000/splats.ply", "report/000000/truth.ply"})
    EXPECT_TRUE(fs::exists(program.path("tray") / file)) << file;
  EXPECT_FALSE(fs::exists(program.path("tray/parts")));
  // The same as its parts: render, perceive.
  ASSERT_EQ(program.run(Words{"render", "seedlings", "--out", "data"} + tray).code, 0);
  ASSERT_EQ(program
                .run({"perceive", "data", "--pipeline", "scene", "--out", "est", "--set",
                      "steps=60", "--set", "most_splats=900", "--set", "start_points=500", "--set",
                      "mesh_cells=30", "--set", "hold_out_every=4"})
                .code,
            0);
  for (const char* file : {"splats.ply", "cloud.ply", "poses.json"})
    EXPECT_EQ(contents(program.path("est/000000")).at(file),
              contents(program.path("tray/estimate/000000")).at(file))
        << file;
  // And again by what it wrote.
  const Outcome again =
      program.run({"run", "seedlings", "--pipeline", "scene", "--out", "again", "--config",
                   "tray/config.toml", "--pipeline-config", "tray/estimate/000000/config.toml"});
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(contents(program.path("again/estimate/000000")).at("splats.ply"),
            contents(program.path("tray/estimate/000000")).at("splats.ply"));
  const Outcome plan =
      program.run(words + Words{"--plan", "--json", "--set", "pipeline.cloud_views=0"});
  const nlohmann::json passes = nlohmann::json::parse(plan.out);
  for (const nlohmann::json& pass : passes) {
    if (pass["pass"] == "cloud") EXPECT_FALSE(pass["runs"]) << plan.out;
    if (pass["pass"] == "splats") EXPECT_TRUE(pass["runs"]) << plan.out;
  }
  EXPECT_EQ(program.run(words + Words{"--attribution"}).code, 2);
  const Outcome keys = program.run({"run", "seedlings", "--pipeline", "scene", "--keys"});
  EXPECT_THAT(keys.out, AllOf(HasSubstr("hold_out_every"), HasSubstr("tray")));
  const Outcome unknown = program.run({"run", "seedlings", "--pipeline", "plants"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("seeds, strawberries, apples, tree, maize, stereo, scene"));
}

TEST(AppPerceiveViews, MistakesAreNamed) {
  const Program program;
  write_capture(program.path("cube/000000"), cube_capture());
  const auto refusal = [&](const Words& words) {
    const Outcome outcome =
        program.run(Words{"perceive", "cube", "--pipeline", "scene", "--out", "est"} + words);
    EXPECT_EQ(outcome.code, 2);
    return outcome.err;
  };
  EXPECT_THAT(refusal({"--method", "ours"}), HasSubstr("is not one of splats, splats_paper"));
  EXPECT_THAT(refusal({"--stage", "corners=dir:cube"}), HasSubstr("poses, splats, depth"));
  EXPECT_THAT(refusal({"--set", "largest_side_px=1"}), HasSubstr("neither 0 nor 16"));
  EXPECT_THAT(refusal({"--set", "voxel_px=0"}), HasSubstr("voxel_px = 0: must be in"));
  EXPECT_THAT(refusal({"--set", "clusters.join_rounds=2"}), HasSubstr("unknown key"));
  const Outcome inside =
      program.run({"perceive", "cube/000000", "--pipeline", "scene", "--out", "cube"});
  EXPECT_EQ(inside.code, 2);
  EXPECT_THAT(inside.err, HasSubstr("would lie in the scene itself"));
}

}  // namespace
}  // namespace cousin
