#include "benchmarks/seeds/report_scene.h"

#include <gmock/gmock.h>

#include "benchmarks/seeds/seeds_report.h"
#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "tests/dataset/temporary_folder.h"

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
  write_report_folder(folder.path(), small_report());
  const std::string page = read_file(folder.path() / "report.html");
  EXPECT_THAT(page, HasSubstr("data:image/jpeg"));
  EXPECT_THAT(page, HasSubstr("views = 60"));
  write_report(folder.path() / "report.html", read_report_folder(folder.path()));
  EXPECT_TRUE(read_file(folder.path() / "report.html") == page);
}

}  // namespace
}  // namespace cousin
