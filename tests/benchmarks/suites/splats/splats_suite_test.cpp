#include "benchmarks/suites/splats/splats_suite.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "benchmarks/suites/splats/ngp_kernel_rows.h"
#include "benchmarks/suites/splats/posed_set.h"
#include "benchmarks/suites/splats/splats_page.h"
#include "benchmarks/suites/splats/training_rows.h"
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

TEST(SplatsSuite, EachPartOfARadianceFieldHasItsTimeASample) {
  std::set<std::string> found;
  for (const ScoreRow& row : ngp_kernel_rows(1, 256)) {
    EXPECT_TRUE(found.insert(row.method + " " + row.metric).second);
    EXPECT_GT(row.value, 0);
    EXPECT_EQ(row.n, 256);
  }
  for (const char* part :
       {"hash grid seconds.encode", "hash grid seconds.derivatives",
        "networks, portable seconds.forward", "networks, portable seconds.backward"})
    EXPECT_TRUE(found.contains(part)) << part;
}

TEST(SplatsSuite, ATrainingHasRowsOfViewsHeldOutSecondsAndMemory) {
  const fs::path folder = fs::path(testing::TempDir()) / "splats_suite_training";
  fs::create_directories(folder);
  write_two_views(folder);
  Image<Rgb8> grey(32, 32);
  for (Rgb8& pixel : grey) pixel = {120, 130, 140};
  for (const char* name : {"000.png", "001.png"}) write_png(folder / name, grey);
  std::ofstream(folder / "points.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
         "end_header\n-.2 -.2 0 120 130 140\n.2 -.2 0 120 130 140\n-.2 .2 0 120 130 140\n"
         ".2 .2 0 120 130 140\n";
  std::ofstream(folder / "split.txt") << "000.png train\n001.png test\n";
  const std::vector<ScoreRow> rows = splat_training_rows(folder, 1, true);
  fs::remove_all(folder);
  const auto find = [&](const std::string& start) -> const ScoreRow* {
    for (const ScoreRow& row : rows) {
      if (row.metric.starts_with(start)) return &row;
    }
    return nullptr;
  };
  for (const ScoreRow& row : rows) EXPECT_EQ(row.case_name, "short");
  const ScoreRow* psnr = find("held_out.psnr (at least 30.85 dB)");
  ASSERT_NE(psnr, nullptr);
  EXPECT_EQ(psnr->n, 1);
  EXPECT_EQ(psnr->status, psnr->value >= 30.85 ? ScoreStatus::pass : ScoreStatus::fail);
  EXPECT_GT(psnr->value, 20);  // the view held out is the one trained on
  const ScoreRow* seconds = find("seconds.wall (at most 40 s)");
  ASSERT_NE(seconds, nullptr);
  EXPECT_GT(seconds->value, 0);
  EXPECT_EQ(seconds->value, psnr->wall_s);
  ASSERT_NE(find("steps"), nullptr);
  EXPECT_EQ(find("steps")->value, 2000);
  ASSERT_NE(find("gaussians"), nullptr);
  EXPECT_GT(find("gaussians")->value, 3);
  EXPECT_NE(find("memory.above_start (at most 150 MB)"), nullptr);
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

/// A ring of ten cameras 3 m about the origin that look at it, 00.png to 09.png of 64 x 32.
void write_ring(const fs::path& folder) {
  fs::create_directories(folder);
  std::ofstream list(folder / "transforms.json");
  list << "{\"fl_x\":60,\"fl_y\":60,\"cx\":32,\"cy\":16,\"w\":64,\"h\":32,\"frames\":[";
  for (int i = 0; i < 10; ++i) {
    const double c = std::cos(0.2 * M_PI * i), s = std::sin(0.2 * M_PI * i);
    const std::string name = "0" + std::to_string(i) + ".png";
    // Columns: to the right, up, to the back, centre.
    list << (i > 0 ? "," : "") << "{\"file_path\":\"" << name << "\",\"transform_matrix\":[[" << -s
         << ",0," << c << "," << 3 * c << "],[" << c << ",0," << s << "," << 3 * s
         << "],[0,1,0,0],[0,0,0,1]]}";
    write_png(folder / name, Image<Rgb8>(64, 32, Rgb8{static_cast<std::uint8_t>(20 * i), 100, 50}));
  }
  list << "]}";
}

TEST(EveryEighth, ItsViewsAreHeldOutAndTheStartIsWhatCamerasLookAt) {
  const fs::path folder = fs::path(testing::TempDir()) / "splats_suite_eighth";
  write_ring(folder);
  const PosedSet set = read_every_eighth(folder / "transforms.json", 32, 200, 1);
  ASSERT_EQ(set.test.size(), 2U);
  ASSERT_EQ(set.train.size(), 8U);
  EXPECT_EQ(set.test[0].frame, 0);
  EXPECT_EQ(set.test[1].frame, 8);
  for (const SplatView& view : set.train) EXPECT_NE(view.frame % 8, 0);
  EXPECT_EQ(set.test[0].full.camera.width_px, 32);
  ASSERT_EQ(set.start.splats.size(), 200U);
  int near = 0;
  for (const Splat& splat : set.start.splats)
    near += (set.start.origin_in_world_m + splat.centre_m.cast<double>()).norm() < 12;
  EXPECT_EQ(near, 200);
  EXPECT_NE(read_every_eighth(folder / "transforms.json", 32, 200, 2).start.splats[0].centre_m,
            set.start.splats[0].centre_m);
  fs::remove_all(folder);
}

TEST(EveryEighth, TheFoxIsPosedAndHeldOut) {
  const fs::path fox = real_data() / "multiview" / "instantngp_fox" / "transforms.json";
  if (!fs::exists(fox)) GTEST_SKIP() << "no real data at " << fox;
  const PosedSet set = read_every_eighth(fox, 100, 500, 1);
  EXPECT_EQ(set.test.size(), 7U);
  EXPECT_EQ(set.train.size(), 43U);
  EXPECT_EQ(set.start.splats.size(), 500U);
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
