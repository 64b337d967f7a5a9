#include "benchmarks/splats/splats_suite.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "benchmarks/splats/posed_set.h"
#include "benchmarks/splats/splats_page.h"
#include "benchmarks/splats/training_rows.h"
#include "sim/imaging/image_io.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// 000.png and 001.png with their poses, without a split.
void write_two_views(const fs::path& folder) {
  const char* pose = "[[1,0,0,0],[0,1,0,0],[0,0,1,1],[0,0,0,1]]";
  std::ofstream(folder / "transforms.json")
      << "{\"fl_x\":60,\"fl_y\":60,\"cx\":16,\"cy\":16,\"w\":32,\"h\":32,\"frames\":["
      << "{\"file_path\":\"000.png\",\"transform_matrix\":" << pose << "},"
      << "{\"file_path\":\"001.png\",\"transform_matrix\":" << pose << "}]}";
  for (const char* name : {"000.png", "001.png"}) write_png(folder / name, Image<Rgb8>(32, 32));
}

TEST(SplatsSuite, PhotographsThatAreAbsentGiveARowThatIsNotSolved) {
  const std::vector<ScoreRow> rows = splat_training_rows("/no/such/folder", 1, true);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].status, ScoreStatus::not_solved);
  EXPECT_NE(rows[0].metric.find("/no/such/folder"), std::string::npos);
}

TEST(SplatsSuite, AWordThatIsNeitherTrainNorTestIsNamed) {
  const fs::path folder = fs::path(testing::TempDir()) / "splats_suite_split";
  fs::create_directories(folder);
  std::ofstream(folder / "split.txt") << "000.png train\n001.png trial\n";
  try {
    (void)splat_training_rows(folder, 1, true);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("\"trial\""), std::string::npos) << error.what();
  }
  fs::remove_all(folder);
}

TEST(SplatsSuite, AJobIsKnownByItsPhotographsAndExtent) {
  SplatsSuiteConfig config;
  config.photographs = "/no/such/folder";
  const std::vector<ShardJob> jobs = splats_jobs(config);
  ASSERT_EQ(jobs.size(), 4U);
  EXPECT_EQ(jobs[2].name, "choices.json");
  EXPECT_NE(jobs[2].run().find("no photographs at"), std::string::npos);
  EXPECT_EQ(jobs[1].name, "training.json");
  EXPECT_NE(jobs[1].key.find("/no/such/folder absent"), std::string::npos);
  EXPECT_NE(jobs[1].run().find("no photographs at"), std::string::npos);
  const fs::path folder = fs::path(testing::TempDir()) / "splats_suite_jobs";
  fs::create_directories(folder);
  config.photographs = folder;
  const std::string empty = splats_jobs(config)[1].key;
  std::ofstream(folder / "000.png") << "other bytes under the same name";
  EXPECT_EQ(splats_jobs(config)[0].key, jobs[0].key);  // kernels have none
  EXPECT_NE(splats_jobs(config)[1].key, empty);
  fs::remove_all(folder);
  config.quick = true;
  EXPECT_EQ(splats_jobs(config)[0].name, "kernels.quick.json");
}

// One that is cut off leaves views without a line: they would be trained on.
TEST(SplatsSuite, EveryViewNeedsItsLineInTheSplit) {
  const fs::path folder = fs::path(testing::TempDir()) / "splats_suite_lines";
  fs::create_directories(folder);
  write_two_views(folder);
  const auto refusal = [&](const char* split) {
    std::ofstream(folder / "split.txt") << split;
    try {
      (void)read_split_set(folder);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal("000.png train\n").find("no line for \"001.png\""), std::string::npos);
  EXPECT_NE(refusal("000.png train\n001.png").find("line 2"), std::string::npos);
  EXPECT_NE(refusal("000.png train\n000.png test\n").find("occurs twice"), std::string::npos);
  EXPECT_NE(refusal("000.png train test\n").find("line 1"), std::string::npos);
  fs::remove_all(folder);
}

// Else a held-out photograph would be trained on.
TEST(SplatsSuite, AHeldOutNameThatNoViewHasIsNamed) {
  const fs::path folder = fs::path(testing::TempDir()) / "splats_suite_names";
  fs::create_directories(folder);
  write_two_views(folder);
  std::ofstream(folder / "split.txt") << "000.png train\n001.jpg test\n";
  try {
    (void)read_split_set(folder);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("\"001.jpg\" is the image of 0 views"),
              std::string::npos)
        << error.what();
  }
  fs::remove_all(folder);
}

// Photographs without poses: COLMAP 3.8 by hand registers all 21.
TEST(PlacedPhotographs, TheChairIsPlacedAndHeldOut) {
  const fs::path chair = real_data() / "multiview" / "boofcv_chair";
  if (!fs::exists(chair)) GTEST_SKIP() << "no real data at " << chair;
  const PlacedSet placed = place_photographs(
      chair / "img", (chair / "intrinsic_DSC-HX5_3648x2736_to_640x480.yaml").string());
  if (placed.status == SfmStatus::not_built) GTEST_SKIP() << placed.reason;
  EXPECT_EQ(placed.status, SfmStatus::ok) << placed.reason;
  EXPECT_EQ(placed.photographs, 21);
  EXPECT_EQ(placed.placed, 21);
  EXPECT_EQ(placed.set.test.size(), 3u);
  EXPECT_EQ(placed.set.train.size(), 18u);
  EXPECT_GT(placed.set.start.splats.size(), 1000u);
}

TEST(SplatsPage, HeldOutPsnrBecomesItsErrorOverSeconds) {
  ScoreRow row;
  row.suite = "splats";
  row.scene = "fox";
  row.method = "splats";
  row.metric = "held_out.psnr";
  row.value = 20;  // an error of a tenth
  row.wall_s = 3;
  ScoreRow other = row;
  other.metric = "gaussians";
  const std::vector<ErrorTimeCurve> curves = splats_curves({row, other});
  ASSERT_EQ(curves.size(), 1u);
  ASSERT_EQ(curves[0].points.size(), 1u);
  EXPECT_NEAR(curves[0].points[0].error.value, 0.1, 1e-12);
  EXPECT_EQ(curves[0].points[0].wall_s, 3);
}

}  // namespace
}  // namespace cousin
