// What a user's broken input gives: an exit code, and a message that names file, key or view.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/seam_io.h"
#include "sim/imaging/image_io.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr int kViews = 3;

/// Three grey views in data/000000: all there but the board.
class AppBadInput : public testing::Test {
 protected:
  void SetUp() override {
    capture_.pipeline = "seeds";
    capture_.rig.resize(1);
    capture_.rig[0].camera = Camera{LensModel::opencv5, 64, 48, 60, 60, 32, 24, {}};
    for (int i = 0; i < kViews; ++i) {
      Frame frame;
      frame.id = i;
      frame.sensors.resize(1);
      frame.sensors[0].reported = capture_.rig[0].camera;
      frame.sensors[0].color = Image<Rgb8>(64, 48, {90, 90, 90});
      capture_.frames.push_back(frame);
    }
    write_capture(scene_, capture_);
  }
  Outcome perceive(const Words& more = {}) const {
    return program_.run(Words{"perceive", "data", "--out", "est"} + more);
  }
  /// The message of `perceive`, which must end as bad input; nothing is estimated then.
  std::string refusal() const {
    const Outcome outcome = perceive();
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("cousin: "));
    EXPECT_FALSE(fs::exists(program_.path("est/000000/traits.json")));
    return outcome.err;
  }
  /// The same, with the first `from` of a file replaced by `to` for this call.
  std::string refusal(const std::string& file, const std::string& from, const std::string& to) {
    const std::string good = read_file(scene_ / file);
    std::string bad = good;
    const std::size_t at = bad.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) bad.replace(at, from.size(), to);
    write_file(scene_ / file, bad);
    const std::string message = refusal();
    write_file(scene_ / file, good);
    return message;
  }
  /// Seams that stand in for the stages before the surfaces: posed views and one cluster.
  void write_seams(const Silhouettes& silhouettes) const {
    const fs::path seams = program_.path("seams");
    Poses poses(kViews);
    Clusters clusters;
    clusters.count = 1;
    for (int i = 0; i < kViews; ++i) {
      FramePose& pose = poses[static_cast<std::size_t>(i)];
      pose.frame = i;
      pose.status = PoseStatus::ok;
      pose.camera = capture_.rig[0].camera;
      pose.camera_from_world.translation_m = {0, 0, 0.3};
    }
    for (int i = 0; i < 100; ++i) {
      clusters.cloud.push_back({{0.0005F * (i % 10), 0.0005F * (i / 10), 0.002F}, {0, 0, 1}});
      clusters.instance.push_back(0);
    }
    write_corners(seams, {});
    write_poses(seams, poses);
    write_depths(seams, {});
    write_cloud(seams, clusters.cloud);
    write_clusters(seams, clusters);
    write_silhouettes(seams, silhouettes, 0);
  }
  static Words seam_stages(const Words& stages) {
    Words words;
    for (const std::string& stage : stages)
      words.insert(words.end(), {"--stage", stage + "=dir:seams"});
    return words;
  }

  Program program_;
  fs::path scene_ = program_.path("data/000000");
  Capture capture_;
};

TEST_F(AppBadInput, BrokenImagesNameFileAndView) {
  const fs::path png = scene_ / "rgb/000001.png";
  const std::string good = read_file(png);
  const auto names = AllOf(HasSubstr("000000/rgb/000001.png"), HasSubstr("frame 1"));
  write_file(png, good.substr(0, good.size() / 2));
  EXPECT_THAT(refusal(), names);
  write_png(png, Image<Rgb8>(63, 48));
  EXPECT_THAT(refusal(), AllOf(names, HasSubstr("63 x 48"), HasSubstr("64 x 48")));
  fs::remove(png);
  EXPECT_THAT(refusal(), AllOf(names, HasSubstr("missing")));
}

TEST_F(AppBadInput, BrokenJsonNamesFileAndKey) {
  EXPECT_THAT(refusal("rig.json", "\"fx_px\": 60.0", "\"fx_px\": \"60\""),
              AllOf(HasSubstr("000000/rig.json: "), HasSubstr("/sensors/0/camera/fx_px = \"60\"")));
  EXPECT_THAT(refusal("rig.json", "\"fx_px\": 60.0", "\"fx_px\": 0"),
              AllOf(HasSubstr("000000/rig.json: "), HasSubstr("fx_px = 0")));
  EXPECT_THAT(refusal("rig.json", "\"fx_px\": 60.0", "\"fx_px\": NaN"),
              HasSubstr("000000/rig.json: not JSON"));
  EXPECT_THAT(refusal("rig.json", "\"fx_px\": 60.0", "\"fx_px\": 60.0, \"focal\": 1"),
              AllOf(HasSubstr("000000/rig.json: "), HasSubstr("unknown key \"focal\"")));
  EXPECT_THAT(refusal("rig.json", "\"sensors\"", "\"sensor\""),
              AllOf(HasSubstr("000000/rig.json: "), HasSubstr("lacks the key \"sensors\"")));
  EXPECT_THAT(refusal("scene_camera.json", "\"cam_K\"", "\"cam_k\""),
              AllOf(HasSubstr("000000/scene_camera.json: "),
                    HasSubstr("/0 = an object lacks the key \"cam_K\"")));
  EXPECT_THAT(refusal("scene_camera.json", "{", "["), HasSubstr("scene_camera.json: not JSON"));
  fs::remove(scene_ / "rig.json");
  EXPECT_THAT(refusal(), HasSubstr("000000/rig.json: cannot read"));
}

TEST_F(AppBadInput, ALensThatFoldsInsideTheImageNamesTheView) {
  capture_.frames[2].sensors[0].reported.distortion[0] = -5;
  // The writer checks lenses too: the file is made from a good one.
  const std::string text = read_file(scene_ / "scene_camera.json");
  auto json = nlohmann::json::parse(text);
  auto& camera = json["2"]["cousin"]["sensors"][0]["camera"];
  ASSERT_TRUE(camera.contains("distortion"));
  camera["distortion"] = {-5.0, 0.0, 0.0, 0.0, 0.0};
  write_file(scene_ / "scene_camera.json", json.dump());
  EXPECT_THAT(refusal(), AllOf(HasSubstr("000000/scene_camera.json: "), HasSubstr("frame 2"),
                               HasSubstr("folds inside the image")));
}

TEST_F(AppBadInput, ABoardThatIsNotSeenIsAStatusOfEachView) {
  const Outcome outcome = perceive();
  EXPECT_EQ(outcome.code, 3);
  for (const char* view : {"view 0", "view 1", "view 2"}) {
    EXPECT_THAT(outcome.err, HasSubstr(std::string(view) + " has no pose: no_board (not_seen)"));
  }
  EXPECT_THAT(outcome.err,
              HasSubstr("cousin: data/000000: 0 of 3 views posed, 0 specimens: no view shows "
                        "the board"));
  for (const FramePose& pose : read_poses(program_.path("est/000000"))) {
    EXPECT_EQ(pose.status, PoseStatus::no_board);
  }
  EXPECT_TRUE(read_traits(program_.path("est/000000")).empty());
  EXPECT_EQ(perceive({"--json"}).out, "[]\n");
}

TEST_F(AppBadInput, AnEstimateInTheDatasetsOwnFolderIsRefused) {
  for (const char* out : {"data", "data/est", "./data/000000"}) {
    const Outcome outcome = program_.run({"perceive", "data/", "--out", out});
    EXPECT_EQ(outcome.code, 2) << out;
    EXPECT_THAT(outcome.err, HasSubstr("lies in the dataset data; name a folder beside it"));
  }
  EXPECT_FALSE(std::filesystem::exists(program_.path("data/000000/config.toml")));
  // The folder that is taken where none is named lies beside it too.
  program_.run({"perceive", "data/"});
  EXPECT_TRUE(std::filesystem::exists(program_.path("data_estimate/000000/config.toml")));
}

TEST_F(AppBadInput, ABoardThatIsSeenWithoutAPoseIsNotSaidToBeUnseen) {
  write_seams({});
  Poses poses(kViews);
  Corners corners(kViews);
  for (int i = 0; i < kViews; ++i) {
    const auto view = static_cast<std::size_t>(i);
    poses[view].frame = corners[view].frame = i;
    poses[view].status = PoseStatus::degenerate;
    corners[view].status = i > 0 ? BoardStatus::ok : BoardStatus::not_seen;
  }
  write_poses(program_.path("seams"), poses);
  write_corners(program_.path("seams"), corners);
  const Outcome outcome = perceive(seam_stages({"corners", "poses"}));
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("0 of 3 views posed, 0 specimens: 2 views show the board, but "
                                     "none could be posed"));
}

TEST_F(AppBadInput, ABrokenSceneKeepsTheEstimateOfTheOneBefore) {
  write_capture(program_.path("data/000001"), capture_);
  write_file(program_.path("data/000001/rgb/000002.png"), "");
  const Outcome outcome = perceive();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("000001/rgb/000002.png"));
  EXPECT_TRUE(read_traits(program_.path("est/000000")).empty());
  EXPECT_FALSE(fs::exists(program_.path("est/000001/traits.json")));
}

TEST_F(AppBadInput, AnEmptyMaskIsASeedThatIsNotSolved) {
  write_seams({{.frame = 0, .instance = 0}, {.frame = 1, .instance = 0}});
  const Outcome outcome =
      perceive(seam_stages({"corners", "poses", "depth", "cloud", "clusters", "masks"}));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("000000 specimen 0: not_solved (surface: too_few_views)"));
}

TEST_F(AppBadInput, TouchingSeedsAreNotSolved) {
  write_seams({});
  Surfaces surfaces(1);
  surfaces[0].status = SurfaceStatus::touching;
  write_surfaces(program_.path("seams"), surfaces);
  const Outcome outcome = perceive(
      seam_stages({"corners", "poses", "depth", "cloud", "clusters", "masks", "surfaces"}));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("000000 specimen 0: not_solved (surface: touching)"));
}

// In the program, not in a test's executable: there PCL's libraries are neighbours of all others.
TEST_F(AppBadInput, ThePapersStepsMeasureACloudOfFiles) {
  write_seams({});
  Cloud cloud;
  for (int i = 0; i < 480 * 480; ++i) {
    const float x = 0.000125F * static_cast<float>(i % 480 - 240);
    const float y = 0.000125F * static_cast<float>(i / 480 - 240);
    // A half ball.
    const float rest = 0.00145F * 0.00145F - x * x - y * y;
    cloud.push_back({{x, y, rest > 0 ? std::sqrt(rest) : 0.0F}, {0, 0, 1}});
  }
  write_cloud(program_.path("seams"), cloud);
  // The even spacing of the grid would make all of the half ball an outlier.
  const Outcome methods = program_.run({"methods"});
  const Outcome outcome =
      perceive(Words{"--method", "paper", "--set", "paper_clusters.outlier_sigma=100"} +
               seam_stages({"corners", "poses", "depth", "cloud"}));
  if (methods.out.find("not built") != std::string::npos) GTEST_SKIP() << "built without PCL";
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("000000 specimen 0: ok"));
}

// The paper's steps make no outlines and fewer meshes: `score` would rate the other method's.
TEST_F(AppBadInput, AnEarlierMethodsSeamsDoNotStay) {
  write_seams({{.frame = 0, .instance = 0}, {.frame = 1, .instance = 0}});
  const Words given = seam_stages({"corners", "poses", "depth", "cloud", "clusters"});
  const fs::path est = program_.path("est/000000");
  ASSERT_EQ(perceive(given + seam_stages({"masks"})).code, 0);
  EXPECT_TRUE(fs::exists(est / "masks.json"));
  EXPECT_TRUE(fs::exists(est / "surfaces.json"));
  write_file(est / "meshes/notes.txt", "mine");
  // What would be taken for ours is moved away by its owner, and by nobody else.
  write_file(est / "meshes/000007_samples.ply", "mine");
  const Outcome in_the_way = perceive(given);
  EXPECT_EQ(in_the_way.code, 2);
  EXPECT_THAT(in_the_way.err, HasSubstr("est/000000/meshes/000007_samples.ply is in the way"));
  EXPECT_EQ(read_file(est / "meshes/000007_samples.ply"), "mine");
  fs::remove(est / "meshes/000007_samples.ply");
  perceive(Words{"--method", "paper", "--stage", "traits=dir:seams"} + given);
  EXPECT_TRUE(fs::exists(est / "clusters.ply"));
  EXPECT_FALSE(fs::exists(est / "masks.json"));
  EXPECT_EQ(read_file(est / "meshes/notes.txt"), "mine");
}

TEST_F(AppBadInput, AStageMayBeReadFromTheFolderThatIsWritten) {
  write_seams({});
  ASSERT_EQ(perceive(seam_stages({"corners", "poses", "depth", "cloud", "clusters"})).code, 0);
  const auto before = contents(program_.path("est"));
  const Outcome again =
      perceive({"--stage", "corners=dir:est", "--stage", "poses=dir:est", "--stage",
                "depth=dir:est", "--stage", "cloud=dir:est", "--stage", "clusters=dir:est"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(contents(program_.path("est")), before);
}

TEST_F(AppBadInput, AForeignSeamNamesFileAndKey) {
  write_file(program_.path("seams/traits.json"),
             R"({"specimens": [{"instance": "0", "status": "ok", "traits": []}]})");
  const Outcome wrong = perceive(seam_stages({"traits"}));
  EXPECT_EQ(wrong.code, 3);
  EXPECT_THAT(wrong.err,
              AllOf(HasSubstr("cousin: stage traits: "), HasSubstr("seams/traits.json: "),
                    HasSubstr("/specimens/0/instance")));
  EXPECT_EQ(read_poses(program_.path("est/000000")).size(), 3U);  // earlier seams are kept
  const Outcome absent = perceive(seam_stages({"poses"}));
  EXPECT_EQ(absent.code, 3);
  EXPECT_THAT(absent.err, AllOf(HasSubstr("cousin: stage poses: "),
                                HasSubstr("seams/poses.json: cannot read")));
  // Whole, but not of this capture.
  write_poses(program_.path("seams"), {});
  const Outcome few = perceive(seam_stages({"poses"}));
  EXPECT_EQ(few.code, 3);
  EXPECT_THAT(few.err, HasSubstr("stage poses: 0 frames; the capture has 3"));
}

TEST_F(AppBadInput, AProgramThatFailsOrWritesABadFileIsAnErrorInside) {
  const fs::path stage = program_.path("stage.sh");
  const auto outcome = [&](const std::string& script) {
    write_file(stage, "#!/bin/sh\n" + script + "\n");
    fs::permissions(stage, fs::perms::owner_all);
    return perceive({"--stage", "traits=exec:" + stage.string()});
  };
  for (const char* script : {"exit 2", "true", "echo '{' > \"$2\"/traits.json"}) {
    const Outcome failed = outcome(script);
    EXPECT_EQ(failed.code, 4) << script;
    EXPECT_THAT(failed.err, HasSubstr("cousin: stage traits: "));
  }
}

TEST_F(AppBadInput, AFolderForTemporaryFilesThatIsNotThereIsNamed) {
  const fs::path stage = program_.path("stage.sh");
  write_file(stage, "#!/bin/sh\nexit 0\n");
  fs::permissions(stage, fs::perms::owner_all);
  const Outcome outcome =
      program_.run({"perceive", "data", "--out", "est", "--stage", "traits=exec:" + stage.string()},
                   [] { return setenv("TMPDIR", "/proc/none", 1) == 0; });
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("stage traits: the input of its program could not be"),
                                 HasSubstr("/proc/none")));
}

TEST_F(AppBadInput, RunLengthMasksOfAUsersStageAreRead) {
  write_seams({});
  const Words stages = seam_stages({"corners", "poses", "depth", "cloud", "clusters", "masks"});
  // A block of 4 x 4 pixels in each 64 x 48 image: counts "..." as COCO writes them, or a list.
  write_file(program_.path("seams/masks.json"),
             R"([{"image_id": 0, "category_id": 1, "score": 0.9, "instance_id": 0,
                  "segmentation": {"size": [48, 64], "counts": [970, 4, 44, 4, 44, 4, 44, 4, 1954]}}])");
  const Outcome read = perceive(stages);
  EXPECT_EQ(read.code, 0) << read.err;
  EXPECT_EQ(read_silhouettes(program_.path("est/000000")).at(0).outline.size(), 17U);
  write_file(
      program_.path("seams/masks.json"),
      R"([{"image_id": 0, "instance_id": 0, "segmentation": {"size": [24, 32], "counts": [768]}}])");
  const Outcome resized = perceive(stages);
  EXPECT_EQ(resized.code, 3);
  EXPECT_THAT(resized.err, AllOf(HasSubstr("stage masks: "), HasSubstr("masks.json"),
                                 HasSubstr("is not the image's [height, width] = [48, 64]")));
}

TEST_F(AppBadInput, WhatAStagesProgramPrintsIsNotAmongTheResults) {
  const fs::path stage = program_.path("stage.sh");
  write_traits(program_.path("seams"), {});
  write_file(stage, "#!/bin/sh\necho hello\ncp seams/traits.json \"$2\"/\n");
  fs::permissions(stage, fs::perms::owner_all);
  const Outcome outcome = perceive({"--json", "--stage", "traits=exec:" + stage.string()});
  EXPECT_EQ(outcome.out, "[]\n");
  EXPECT_THAT(outcome.err, HasSubstr("hello\n"));
}

TEST_F(AppBadInput, AMeshThatIsNotClosedNamesFileAndEdge) {
  write_file(program_.path("open.obj"),
             "v 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nv 0 0 0.01\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  for (const char* verb : {"run", "render"}) {
    const auto outcome = [&](const std::string& file) {
      return program_.run({verb, "seeds", "--out", "out", "--set", "specimen=" + file});
    };
    const Outcome open = outcome("mesh:open.obj");
    EXPECT_EQ(open.code, 3);
    EXPECT_THAT(open.err, AllOf(HasSubstr("open.obj"), HasSubstr("not a closed mesh"),
                                HasSubstr("edge 0-2")));
    const Outcome absent = outcome("mesh:absent.ply");
    EXPECT_EQ(absent.code, 3);
    EXPECT_THAT(absent.err, HasSubstr("absent.ply"));
    const Outcome nameless = outcome("open.obj");
    EXPECT_EQ(nameless.code, 2);
    EXPECT_THAT(nameless.err, HasSubstr("specimen = \"open.obj\" is not \"mesh:FILE\""));
  }
  // Before any work, not hours later.
  for (const Words& words : {Words{"run", "seeds", "--plan"}, {"bench"}}) {
    const Outcome absent =
        program_.run(words + Words{"--out", "new", "--set", "specimen=mesh:absent.ply"});
    EXPECT_EQ(absent.code, 3) << words[0];
    EXPECT_THAT(absent.err, HasSubstr("there is no file absent.ply"));
    EXPECT_FALSE(fs::exists(program_.path("new")));
  }
}

}  // namespace
}  // namespace cousin
