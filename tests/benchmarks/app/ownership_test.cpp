// What is somebody's in a folder that a command is told to write into: it stays, and the command
// says so before any work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "benchmarks/tools/fit_sensor/hidden_device.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/imaging/image_io.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Photographs of nothing in photos/: enough for commands that look at --out before they measure.
void write_photographs(const Program& program) {
  for (const char* name : {"a.png", "b.png"})
    write_png(program.path("photos") / name, Image<Rgb8>(64, 48, {90, 90, 90}));
}

Words import_photographs(const std::string& out) {
  return {"import", "photos", "--format", "folder", "--intrinsics", "60,60,32,24", "--out", out};
}

void write_desk(const Program& program) {
  HiddenDevice device = draw_hidden_device("d457", Rng(1));
  device.config.columns = 424;
  RecordingPlan plan;
  plan.distances_m = {0.35, 0.5};
  plan.frames = 2;
  plan.flats = 0;
  write_recordings(program.path("desk"), record(device, plan, Rng(2)), device, plan);
}

/// A command that writes into out/, and what it would write over there.
struct Case {
  Words words;
  std::vector<const char*> files;
};

std::vector<Case> cases() {
  return {{Words{"render", "seeds"} + tiny_scene(),
           {"000000/notes.txt", "000000/rgb/000000.png", "manifest.json"}},
          {Words{"run", "seeds"} + tiny_scene(),
           {"scores.csv", "report.html", "config.toml", "estimate/000000/depth/000001.exr",
            "estimate/000000/meshes/000000.ply", "report/000000/scene.json"}},
          {{"perceive", "data", "--pipeline", "seeds"},
           {"000000/traits.json", "000000/depth/000009.exr", "000000/meshes/000007_samples.ply",
            "000000/rig.json"}},
          {{"perceive", "data", "--pipeline", "scene"}, {"000000/pictures/000000.png"}},
          {{"calibrate", "photos", "--board", "chessboard:6x4:0.03"},
           {"opencv/CMakeLists.txt", "ros/src/node.py", "kalibr/camchain.yaml", "mrcal/a",
            "colmap/database.db", "scores.csv", "calibration.json", "report.html"}},
          {{"fit-sensor", "desk", "--rig", "d457"}, {"preset.toml", "scores.csv", "report.html"}},
          {{"import", "photos", "--format", "folder", "--intrinsics", "60,60,32,24"},
           {"000000/rgb/000000.png", "000001/notes.txt", "manifest.json"}},
          {{"export", "data", "--format", "nerfstudio"}, {"notes.txt", "images/1.png"}},
          {{"score", "data", "est"}, {"scores.csv", "scores.json"}},
          {{"bench", "stability", "--quick"}, {"stability/scores.csv", "stability/report.html"}},
          {{"report", "results"}, {"report.html"}}};
}

/// What the commands read: a capture, photographs, recordings and a result.
void write_inputs(const Program& program) {
  write_photographs(program);
  write_desk(program);
  ASSERT_EQ(program.run(import_photographs("data")).code, 0);
  fs::create_directories(program.path("est/000000"));
  write_file(
      program.path("results/scores.json"),
      R"({"schema": 1, "header": {"program_version": "", "dataset_hash": "", "config_hash": "",
                "machine": "", "more": {}}, "scores": [], "specimens": []})");
}

TEST(AppOwnership, EveryVerbRefusesSomebodysFileBeforeAnyWork) {
  const Program program;
  write_inputs(program);
  for (const Case& one : cases()) {
    for (const char* file : one.files) {
      write_file(program.path("out") / file, "mine");
      const Outcome outcome = program.run(one.words + Words{"--out", "out"});
      EXPECT_EQ(outcome.code, 2) << one.words[0] << " " << file << outcome.err;
      const std::string named = "cousin: out/" + std::string(file);
      EXPECT_THAT(outcome.err,
                  AllOf(HasSubstr(one.words[0] == "render" && std::string(file) == "manifest.json"
                                      ? "out/manifest.json"
                                      : named),
                        HasSubstr("--out")))
          << one.words[0];
      EXPECT_EQ(contents(program.path("out")), (std::map<std::string, std::string>{{file, "mine"}}))
          << one.words[0];
      fs::remove_all(program.path("out"));
    }
  }
}

TEST(AppOwnership, EveryVerbRefusesALinkAndItsTargetStays) {
  const Program program;
  write_inputs(program);
  write_file(program.path("home/thesis.tex"), "mine");
  for (const Case& one : cases()) {
    // In place of the file, and of the folder that it would be in.
    const fs::path file = program.path("out") / one.files.front();
    for (const bool is_folder : {false, true}) {
      if (is_folder && file.parent_path() == program.path("out")) continue;
      const fs::path link = is_folder ? file.parent_path() : file;
      fs::create_directories(link.parent_path());
      fs::create_symlink(program.path(is_folder ? "home" : "home/thesis.tex"), link);
      const Outcome outcome = program.run(one.words + Words{"--out", "out"});
      EXPECT_EQ(outcome.code, 2) << one.words[0] << outcome.err;
      EXPECT_TRUE(fs::is_symlink(link)) << one.words[0];
      EXPECT_EQ(contents(program.path("home")),
                (std::map<std::string, std::string>{{"thesis.tex", "mine"}}))
          << one.words[0];
      fs::remove_all(program.path("out"));
    }
  }
}

TEST(AppOwnership, ACalibrationThatFailsRemovesNothingOfSomebodys) {
  const Program program;
  write_photographs(program);
  write_file(program.path("opencv/modules/core.cpp"), "mine");
  const Outcome outcome =
      program.run({"calibrate", "photos", "--board", "chessboard:6x4:0.03", "--out", "."});
  EXPECT_NE(outcome.code, 0);
  EXPECT_EQ(read_file(program.path("opencv/modules/core.cpp")), "mine");
}

TEST(AppOwnership, AnImportOverARenderedDatasetIsRefused) {
  const Program program;
  write_photographs(program);
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "data"} + tiny_scene()).code, 0);
  const auto before = contents(program.path("data"));
  const Outcome over = program.run(import_photographs("data"));
  EXPECT_EQ(over.code, 2);
  EXPECT_THAT(over.err, HasSubstr("is in the way: `cousin import` did not write it"));
  EXPECT_EQ(contents(program.path("data")), before);
  // The other way round too, and another import.
  ASSERT_EQ(program.run(import_photographs("real")).code, 0);
  EXPECT_EQ(program.run(Words{"render", "seeds", "--out", "real"} + tiny_scene()).code, 2);
  Words other = import_photographs("real");
  fs::copy(program.path("photos"), program.path("photos2"));
  other[1] = "photos2";
  const Outcome mixed = program.run(other);
  EXPECT_EQ(mixed.code, 2);
  EXPECT_THAT(mixed.err, HasSubstr("real/.cousin.import belongs to another configuration"));
  // The same again takes the place of what it wrote, and keeps nothing of what is gone.
  fs::remove(program.path("photos/b.png"));
  EXPECT_EQ(program.run(import_photographs("real")).code, 0);
  EXPECT_EQ(read_capture(program.path("real/000000")).frames.size(), 1U);
  EXPECT_FALSE(fs::exists(program.path("real/000000/rgb/000001.png")));
}

/// A dataset that an earlier version mixed: its pictures are an import's, its truth a renderer's.
TEST(AppOwnership, AMixedDatasetIsNotScored) {
  const Program program;
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "data"} + tiny_scene()).code, 0);
  ASSERT_EQ(program.run({"perceive", "data", "--out", "est"}).code, 3);  // an empty board
  ASSERT_EQ(program.run({"score", "data", "est"}).code, 0);
  for (const char* file : {"scene_camera.json", "rig.json", "truth/traits.json"}) {
    const fs::path path = program.path("data/000000") / file;
    const std::string good = read_file(path);
    write_file(path, good + " ");
    const Outcome mixed = program.run({"score", "data", "est"});
    EXPECT_EQ(mixed.code, 3) << file;
    EXPECT_THAT(mixed.err, AllOf(HasSubstr("data/000000/" + std::string(file)),
                                 HasSubstr("its SHA-256 is not the one in manifest.json")));
    write_file(path, good);
  }
  EXPECT_EQ(program.run({"score", "data", "est"}).code, 0);
}

/// Both begin before the other has written anything.
TEST(AppOwnership, TwoSeedsAtOnceIntoOneFolderLeaveOneDataset) {
  const Program program;
  const auto render = [](const std::string& seed) {
    return Words{"render", "seeds", "--out", "data", "--seed", seed} + tiny_scene();
  };
  Outcome second;
  std::thread other([&] {
    const Program same_folder(program);
    second = same_folder.run(render("2"));
  });
  const Outcome first = program.run(render("1"));
  other.join();
  EXPECT_TRUE((first.code == 0 && second.code == 2) || (first.code == 2 && second.code == 0))
      << first.code << first.err << second.code << second.err;
  const Outcome& refused = first.code == 2 ? first : second;
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("cousin: data/"), HasSubstr("belongs to another configuration"),
                    HasSubstr("SHA-256")));
  const std::string seed = first.code == 0 ? "1" : "2";
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
  Words alone = render(seed);
  alone[3] = "alone";
  ASSERT_EQ(program.run(alone).code, 0);
  EXPECT_EQ(contents(program.path("data")), contents(program.path("alone")));
}

TEST(AppOwnership, ShardsAtOnceMakeTheFilesOfOneRun) {
  const Program program;
  Words scene = tiny_scene();
  scene[1] = "views=3";
  std::vector<std::thread> shards;
  std::vector<Outcome> outcomes(3);
  for (std::size_t i = 0; i < 3; ++i) {
    shards.emplace_back([&, i] {
      const Program same_folder(program);
      outcomes[i] = same_folder.run(
          Words{"render", "seeds", "--out", "data", "--shard", std::to_string(i) + "/3"} + scene);
    });
  }
  for (std::thread& shard : shards) shard.join();
  for (const Outcome& outcome : outcomes) EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "whole"} + scene).code, 0);
  auto files = contents(program.path("data"));
  std::erase_if(files, [](const auto& file) { return file.first.starts_with("manifest."); });
  auto whole = contents(program.path("whole"));
  std::erase_if(whole, [](const auto& file) { return file.first.starts_with("manifest."); });
  EXPECT_EQ(files, whole);
  EXPECT_EQ(read_file(program.path("data/manifest.json")),
            read_file(program.path("whole/manifest.json")));
}

/// An image that somebody put where the run would have gone on is not taken for the run's.
TEST(AppOwnership, AStoppedRenderThatSomebodyChangedDoesNotGoOn) {
  const Program program;
  const Words render = Words{"render", "seeds", "--out", "data"} + tiny_scene();
  ASSERT_EQ(program.run(render + Words{"--shard", "0/2"}).code, 0);
  const fs::path image = program.path("data/000000/rgb/000000.png");
  const std::string good = read_file(image);
  write_file(image, "mine");
  const Outcome changed = program.run(render);
  EXPECT_EQ(changed.code, 2);
  EXPECT_THAT(changed.err, HasSubstr("data/000000/rgb/000000.png is in the way: it was changed"));
  write_file(image, good);
  write_file(program.path("data/000000/rgb/000001.png"), "mine");
  EXPECT_EQ(program.run(render).code, 2);
  EXPECT_EQ(read_file(program.path("data/000000/rgb/000001.png")), "mine");
  fs::remove(program.path("data/000000/rgb/000001.png"));
  EXPECT_EQ(program.run(render).code, 0);
  EXPECT_EQ(program.run({"verify", "data"}).out, "data: no problems\n");
}

TEST(AppOwnership, AnotherConfigurationOfARunLeavesNothingOfTheFirst) {
  const Program program;
  const Words run = Words{"run", "seeds", "--out", "r"} + tiny_scene();
  ASSERT_EQ(program.run(run + Words{"--scenes", "2"}).code, 0);
  write_file(program.path("r/notes.txt"), "mine");
  ASSERT_EQ(program.run(run + Words{"--seed", "2"}).code, 0);
  EXPECT_FALSE(fs::exists(program.path("r/estimate/000001")));
  EXPECT_TRUE(fs::exists(program.path("r/estimate/000000/poses.json")));
  EXPECT_EQ(read_file(program.path("r/notes.txt")), "mine");
  // `report` writes the run's page anew, and the run its own.
  EXPECT_EQ(program.run({"report", "r"}).code, 0);
  EXPECT_EQ(program.run(run).code, 0);
}

}  // namespace
}  // namespace cousin
