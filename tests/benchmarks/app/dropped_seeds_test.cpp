// What needs seeds dropped on the board: runs that measure them or say why not, and the page of a
// run in a real browser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/seam_io.h"
#include "tests/benchmarks/app/program.h"
#include "tests/benchmarks/app/specimen_files.h"
#include "tests/benchmarks/report/browser.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// Three grains of 10 x 8 x 5 mm on the plane, in millimetres: two side by side, one apart.
std::vector<Mesh> two_that_touch_and_one_apart() {
  std::vector<Mesh> grains;
  for (const Eigen::Vector3d& centre :
       {Eigen::Vector3d(0, -4.01, 0), Eigen::Vector3d(0, 4.01, 0), Eigen::Vector3d(20, 0, 0)}) {
    grains.push_back(ellipsoid_solid({5, 4, 2.5}));
    for (Eigen::Vector3d& v : grains.back().vertices_m) v += centre;
  }
  return grains;
}

TEST(AppDroppedSeeds, PhotographsInAFolderAreMeasuredAndGrainsThatTouchAreSaidToTouch) {
  const Program program;
  write_obj(program.path("grains.obj"), two_that_touch_and_one_apart());
  const Outcome rendered =
      program.run(Words{"render", "seeds", "--out", "data", "--set", "seeds=1", "--set",
                        "specimen=mesh:grains.obj", "--set", "specimen_scale=0.001"} +
                  measured_scene());
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  // What a person with a camera has: images, and one calibration for all of them.
  const Camera lens = read_capture(program.path("data/000000")).rig[0].camera;
  fs::rename(program.path("data/000000/rgb"), program.path("photos"));
  std::string intrinsics;
  for (const double number :
       {lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px, lens.distortion[0], lens.distortion[1],
        lens.distortion[2], lens.distortion[3], lens.distortion[4]}) {
    intrinsics += (intrinsics.empty() ? "" : ",") + std::to_string(number);
  }
  fs::remove_all(program.path("data"));
  const Outcome imported = program.run(
      {"import", "photos", "--format", "folder", "--intrinsics", intrinsics, "--out", "real"});
  ASSERT_EQ(imported.code, 0) << imported.err;

  const Outcome perceived =
      program.run(Words{"perceive", "real", "--pipeline", "seeds", "--out", "est", "--json"} +
                  quick_pipeline());
  ASSERT_EQ(perceived.code, 0) << perceived.err;
  auto rows = nlohmann::json::parse(perceived.out);
  ASSERT_EQ(rows.size(), 2U) << perceived.out;
  std::sort(rows.begin(), rows.end(),
            [](const auto& a, const auto& b) { return a["status"] > b["status"]; });
  EXPECT_EQ(rows[0]["status"], "ok");
  // A pixel spans 0.37 mm.
  EXPECT_NEAR(rows[0]["traits"]["length"]["value"], 0.010, 3e-4);
  EXPECT_NEAR(rows[0]["traits"]["width"]["value"], 0.008, 3e-4);
  EXPECT_NEAR(rows[0]["traits"]["height"]["value"], 0.005, 3e-4);
  EXPECT_EQ(rows[1]["status"], "not_solved");
  EXPECT_EQ(rows[1]["reason"], "surface: touching");
}

TEST(AppDroppedSeeds, OneViewOfASeedIsPosedAndSaysWhyItIsNotMeasured) {
  const Program program;
  Words one = measured_scene() + Words{"--set", "seeds=1", "--set", "views=1"};
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "one"} + one).code, 0);
  const bool all_built = program.run({"methods"}).out.find("not built") == std::string::npos;
  for (const std::string method : {"ours", "paper"}) {
    if (method == "paper" && !all_built) continue;  // PCL is off
    const Outcome outcome = program.run({"perceive", "one", "--out", "est", "--method", method});
    EXPECT_EQ(outcome.code, 3) << method;
    EXPECT_THAT(outcome.err,
                HasSubstr("cousin: one/000000: 1 of 1 views posed, 0 of at least 1 "
                          "objects measured: no view has depth, which takes more views beside it"))
        << method;
    EXPECT_EQ(read_poses(program.path("est/000000")).at(0).status, PoseStatus::ok);
  }
  // The whole loop counts the seed as missed.
  const Outcome run = program.run(Words{"run", "seeds", "--out", "r"} + one);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(read_file(program.path("r/specimens.csv")), HasSubstr(",length,m,"));
  EXPECT_THAT(read_file(program.path("r/specimens.csv")), Not(HasSubstr(",ok\n")));
}

TEST(AppDroppedSeeds, SeedsThatAreSeenAndHaveNoPointsAreNothingMeasured) {
  const Program program;
  const Words far = {"--set",    "seeds=2",
                     "--set",    "rig.width_px=320",
                     "--set",    "rig.height_px=180",
                     "--set",    "rig=phone_video_720p",
                     "--frames", "18"};
  ASSERT_EQ(program.run(Words{"render", "seeds", "--out", "far"} + far).code, 0);
  const Outcome outcome = program.run({"perceive", "far", "--out", "est"});
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("0 of at least 2 objects measured: no object has enough "
                                     "points of the cloud"));
  EXPECT_THAT(outcome.err, HasSubstr("specimen 1 is not measured: seen in "));
}

TEST(AppDroppedSeeds, AMeshInMillimetresNamesItsSizeAndTheKeyThatScalesIt) {
  const Program program;
  write_box_obj(program.path("box.obj"), {10, 8, 5});
  const Words render = Words{"render", "seeds", "--out", "out", "--set", "specimen=mesh:box.obj"} +
                       tiny_scene() + Words{"--set", "seeds=1"};
  const Outcome metres = program.run(render);
  EXPECT_EQ(metres.code, 3);
  EXPECT_THAT(metres.err, AllOf(HasSubstr("a specimen is 13.74"), HasSubstr("m across"),
                                HasSubstr("specimen_scale")));
  const Outcome none = program.run(render + Words{"--set", "specimen_scale=0"});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("specimen_scale = 0: must be in"));
  // In millimetres it is the box that was drawn.
  const Outcome millimetres = program.run(render + Words{"--set", "specimen_scale=0.001"});
  ASSERT_EQ(millimetres.code, 0) << millimetres.err;
  const auto truth = nlohmann::json::parse(read_file(program.path("out/000000/truth/traits.json")));
  const std::map<std::string, double> expected = {
      {"length", 0.01}, {"width", 0.008}, {"height", 0.005}, {"area", 3.4e-4}, {"volume", 4e-7}};
  std::size_t compared = 0;
  for (const auto& trait : truth["instances"][0]["traits"]) {
    const auto value = expected.find(trait["name"]);
    if (value == expected.end()) continue;
    EXPECT_NEAR(trait["value"], value->second, 1e-9 * value->second) << trait["name"];
    ++compared;
  }
  EXPECT_EQ(compared, expected.size());
}

TEST(AppDroppedSeeds, ThePageOfTheirRunShowsPicturesCloudScatterPlotsCommandsAndConfiguration) {
  if (!has_chromium()) {
    GTEST_SKIP() << "Chromium is not installed (Debian package chromium): the page is not tested";
  }
  const Program program;
  const Outcome run = program.run(Words{"run", "seeds", "--out", "r", "--set", "seeds=2"} +
                                  measured_scene() + quick_pipeline());
  ASSERT_EQ(run.code, 0) << run.err;
  ASSERT_EQ(count(read_file(program.path("r/specimens.csv")), ",ok\n"), 10);  // two of five traits

  const std::string html = read_file(program.path("r/report.html"));
  const std::string page = shown_document(html, kWithWebgl);
  // An image that does not decode is an error of the page.
  EXPECT_THAT(root_tag(page), HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(page), HasSubstr("data-errors=\"0\""));
  // A scatter plot and a histogram a trait, and the seconds of each stage.
  EXPECT_EQ(count(html, "class=\"plot\" data-spec="), 11);
  EXPECT_EQ(count(page, "data-plot-ok=\"true\""), 11);
  EXPECT_EQ(count(page, "data-plot-ok=\"false\""), 0);
  EXPECT_EQ(count(page, "data-warnings"), 0);
  EXPECT_EQ(count(html, "class=\"shape\" data-shape="), 3);
  EXPECT_EQ(count(page, "data-view-ok=\"webgl\"") + count(page, "data-view-ok=\"canvas\""), 3);

  for (const char* heading :
       {"Images", "Shapes to turn", "Measured against true", "Distribution of errors", "Run time",
        "Scores", "How this was made"}) {
    EXPECT_EQ(count(page, ">" + std::string(heading) + "</h2>"), 1) << heading;
  }
  for (const char* shape : {"Cloud", "Measured surfaces", "True surfaces"}) {
    EXPECT_EQ(count(page, "<h3>" + std::string(shape) + "</h3>"), 1) << shape;
  }
  for (const char* trait : {"length", "width", "height", "area", "volume"}) {
    EXPECT_EQ(count(page, "<h3>" + std::string(trait) + "</h3>"), 2) << trait;
  }
  EXPECT_THAT(page, testing::ContainsRegex("Points of the multi-view stereo: [0-9]+\\. Shown: "));
  // Three views and the outlines found in two of them.
  EXPECT_EQ(count(page, "<figure><img alt=\"View "), 3);
  EXPECT_EQ(count(page, "<figure><img alt=\"Outlines found in view "), 2);
  EXPECT_THAT(page, HasSubstr("<pre>cousin run seeds --out r --set seeds=2 --set views=18"));
  EXPECT_THAT(page, HasSubstr("\nviews = 18"));
  EXPECT_THAT(page, HasSubstr("\nstep_px = 1.5"));
}

TEST(AppDroppedSeeds, AShardOfABenchSaysHowManyJobsAreNotThereYet) {
  const Program program;
  const Words bench = Words{"bench",
                            "seeds",
                            "--quick",
                            "--out",
                            "b",
                            "--only",
                            "quick_zhengdan958,quick_jimai22,quick_suijing18,quick_noise"} +
                      tiny_scene();
  const Outcome first = program.run(bench + Words{"--shard", "0/2"});
  EXPECT_EQ(first.code, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("2 of 4 jobs are not there yet"));
  const fs::path page = program.path("b/seeds/report.html");
  EXPECT_THAT(read_file(page), HasSubstr("2 of 4 jobs are not there yet"));
  // What the first shard left is read for the page, not written again.
  const fs::path scenes = program.path("b/seeds/report");
  EXPECT_TRUE(fs::exists(scenes / "quick_zhengdan958/scene.json"));
  const auto written = fs::last_write_time(scenes / "quick_zhengdan958/scene.json");
  // A scene of the whole suite, as that suite leaves it.
  const std::string scene = R"({"name": "x", "pictures": 3})";
  write_file(scenes / "zhengdan958_run0/scene.json", scene);
  const fs::path list = program.path("b/seeds/.cousin.bench");
  write_file(list,
             read_file(list) + "+ " + sha256_hex(scene) + " report/zhengdan958_run0/scene.json\n");
  const Outcome second = program.run(bench + Words{"--shard", "1/2"});
  EXPECT_EQ(second.code, 0) << second.err;
  EXPECT_THAT(second.err, Not(HasSubstr("not there yet")));
  EXPECT_THAT(read_file(page),
              AllOf(Not(HasSubstr("not there yet")), HasSubstr("quick_suijing18: "),
                    HasSubstr("quick_zhengdan958: ")));
  EXPECT_EQ(fs::last_write_time(scenes / "quick_zhengdan958/scene.json"), written);
}

}  // namespace
}  // namespace cousin
