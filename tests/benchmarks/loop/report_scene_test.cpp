#include "benchmarks/loop/report_scene.h"

#include <gmock/gmock.h>

#include <set>

#include "benchmarks/loop/seeds_report.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::HasSubstr;

ReportScene small_scene() {
  Image<Rgb8> image(8, 4);
  image(3, 2) = {250, 10, 40};
  ReportScene scene;
  scene.name = "jimai22";
  scene.pictures = {{"View 3", "as it is", encode_jpeg(image, 90)},
                    {"Outlines", "drawn in", encode_png(image)}};
  CloudPoint point;
  point.position_m = {0.01F, 0.02F, 0.003F};
  point.color = {9, 8, 7};
  scene.cloud = {point};
  scene.truth.vertices_m = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}};
  scene.truth.triangles = {{0, 1, 2}};
  return scene;
}

SeedsReport small_report() {
  SeedsReport report;
  report.title = "Cousin: seeds";
  report.command_line = "cousin run seeds --seed 4";
  report.config_toml = "[scene]\nviews = 60\n";
  report.plan = "render: radiance";
  report.scores.header.more = {{"command", report.command_line}, {"title", report.title}};
  report.scenes = {small_scene()};
  return report;
}

std::string error_of(const std::filesystem::path& folder) {
  try {
    read_report_scenes(folder);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(ReportScene, ComesBackAsItWas) {
  const TemporaryFolder folder;
  write_report_scene(folder.path(), small_scene());
  const std::vector<ReportScene> scenes = read_report_scenes(folder.path());
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0].name, "jimai22");
  ASSERT_EQ(scenes[0].pictures.size(), 2U);
  EXPECT_EQ(scenes[0].pictures[0].file, small_scene().pictures[0].file);
  EXPECT_EQ(scenes[0].pictures[1].caption, "drawn in");
  ASSERT_EQ(scenes[0].cloud.size(), 1U);
  EXPECT_EQ(scenes[0].cloud[0].color, small_scene().cloud[0].color);
  EXPECT_TRUE(scenes[0].measured.triangles.empty());
  EXPECT_EQ(scenes[0].truth.triangles.size(), 1U);
}

TEST(ReportScene, NothingOfAnEarlierSceneStays) {
  const TemporaryFolder folder;
  write_report_scene(folder.path(), small_scene());
  ReportScene later = small_scene();
  later.pictures.pop_back();
  later.cloud.clear();
  later.truth = {};
  write_report_scene(folder.path(), later);
  const std::vector<ReportScene> scenes = read_report_scenes(folder.path());
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_TRUE(scenes[0].cloud.empty());
  EXPECT_TRUE(scenes[0].truth.triangles.empty());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "jimai22" / "picture_1.png"));
  const std::filesystem::directory_iterator entries(folder.path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 1);  // and nothing lies beside it
}

TEST(ReportScene, ANameThatCannotBeAFoldersIsRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"", ".", "..", ".hidden", "../up", "a/b", "a b"}) {
    ReportScene scene = small_scene();
    scene.name = name;
    EXPECT_THROW(write_report_scene(folder.path() / "report", scene), std::invalid_argument)
        << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  write_file(folder.path() / "jimai22" / "scene.json", R"({"name": "../up", "pictures": []})");
  EXPECT_THAT(error_of(folder.path()), HasSubstr("jimai22/scene.json: \"name\": \"../up\""));
}

TEST(ReportScene, OnlyThoseThatAreWantedAreRead) {
  const TemporaryFolder folder;
  for (const char* name : {"quick_jimai22", "jimai22_run0"}) {
    ReportScene scene = small_scene();
    scene.name = name;
    write_report_scene(folder.path(), scene);
  }
  write_file(folder.path() / ".jimai22.1.part" / "scene.json", "{");  // of a killed run
  EXPECT_EQ(read_report_scenes(folder.path()).size(), 2U);
  const auto scenes = read_report_scenes(
      folder.path(), [](const std::string& name) { return name == "jimai22_run0"; });
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0].name, "jimai22_run0");
}

TEST(ReportScene, NoViewIsShownTwice) {
  for (const int views : {1, 2, 3, 60}) {
    SimulatedRun run;
    run.capture.frames.resize(static_cast<std::size_t>(views));
    for (int i = 0; i < views; ++i) {
      Frame& frame = run.capture.frames[static_cast<std::size_t>(i)];
      frame.id = i;
      frame.sensors.resize(1);
      frame.sensors[0].color = Image<Rgb8>(8, 4);
    }
    std::set<std::string> names;
    const ReportScene scene = report_scene("a", run, {});
    for (const ReportPicture& picture : scene.pictures) names.insert(picture.name);
    EXPECT_EQ(names.size(), scene.pictures.size()) << views;
    EXPECT_EQ(names.size(), std::min<std::size_t>(3, run.capture.frames.size()));
  }
}

TEST(ReportScene, AFolderThatIsNotWholeIsNotRead) {
  const TemporaryFolder folder;
  write_report_scene(folder.path(), small_scene());
  std::filesystem::remove(folder.path() / "jimai22" / "scene.json");
  EXPECT_TRUE(read_report_scenes(folder.path()).empty());
  EXPECT_TRUE(read_report_scenes(folder.path() / "nowhere").empty());
}

TEST(ReportScene, BadFilesAreNamed) {
  const TemporaryFolder folder;
  write_report_scene(folder.path(), small_scene());
  const auto index = folder.path() / "jimai22" / "scene.json";
  write_file(index, R"({"name": "x", "pictures": [{"file": "../../a.png"}]})");
  EXPECT_THAT(error_of(folder.path()), HasSubstr("leads out of the folder"));
  write_file(index, R"({"name": "x", "pictures": 3})");
  EXPECT_THAT(error_of(folder.path()), HasSubstr("scene.json: \"pictures\""));
  write_file(index, "{");
  EXPECT_THAT(error_of(folder.path()), HasSubstr("is not JSON"));
  write_file(index, R"({"name": "x", "pictures": [{"file": "a.png"}]})");
  write_file(folder.path() / "jimai22" / "a.png", "no picture");
  EXPECT_THAT(error_of(folder.path()), HasSubstr("a.png"));
}

// `cousin report` once replaced a run's page by one without pictures and configuration.
TEST(ReportFolder, MakesTheSamePageAgain) {
  const TemporaryFolder folder;
  write_report_scene(report_scenes_folder(folder.path()), small_scene());
  write_report_folder(folder.path(), small_report());
  const std::string page = read_file(folder.path() / "report.html");
  EXPECT_THAT(page, HasSubstr("data:image/jpeg"));
  EXPECT_THAT(page, HasSubstr("views = 60"));
  write_report(folder.path() / "report.html", read_report_folder(folder.path()));
  EXPECT_TRUE(read_file(folder.path() / "report.html") == page);
}

TEST(ReportFolder, ShowsTheScenesThatItsTablesName) {
  const TemporaryFolder folder;
  ReportScene quick = small_scene();
  quick.name = "quick_jimai22";
  write_report_scene(report_scenes_folder(folder.path()), quick);
  write_report_scene(report_scenes_folder(folder.path()), small_scene());
  SeedsReport report = small_report();
  report.scores.header.more["scenes"] = "other jimai22";
  write_report_folder(folder.path(), report);
  const SeedsReport again = read_report_folder(folder.path());
  ASSERT_EQ(again.scenes.size(), 1U);
  EXPECT_EQ(again.scenes[0].name, "jimai22");
}

}  // namespace
}  // namespace cousin
