#include "benchmarks/suites/sfm/sfm_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iomanip>

#include "benchmarks/suites/sfm/sfm_rows.h"
#include "sim/imaging/image_io.h"
#include "tests/perception/sfm/plant_views.h"
#include "tests/perception/sfm/stand_in_colmap.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// The views as somebody's photographs with their poses; what the photographs show does not matter
/// to a stand-in.
void write_photographs(const fs::path& folder, const PlantViews& views) {
  std::ofstream out(folder / "transforms.json");
  out << std::setprecision(17) << "{\"fl_x\":" << views.lens.fx_px
      << ",\"fl_y\":" << views.lens.fy_px << ",\"cx\":" << views.lens.cx_px + 0.5
      << ",\"cy\":" << views.lens.cy_px + 0.5 << ",\"w\":" << views.lens.width_px
      << ",\"h\":" << views.lens.height_px << ",\"frames\":[";
  for (std::size_t i = 0; i < views.camera_from_world.size(); ++i) {
    const std::string name = std::to_string(100 + i) + ".png";
    write_png(folder / name, Image<Rgb8>(views.lens.width_px, views.lens.height_px));
    const Pose pose = inverse(views.camera_from_world[i]);
    Eigen::Matrix3d turn = pose.rotation.toRotationMatrix();
    turn.rightCols<2>() *= -1;  // y up, z backward
    out << (i > 0 ? "," : "") << "{\"file_path\":\"" << name << "\",\"transform_matrix\":[";
    for (int r = 0; r < 3; ++r)
      out << "[" << turn(r, 0) << "," << turn(r, 1) << "," << turn(r, 2) << ","
          << pose.translation_m(r) << "],";
    out << "[0,0,0,1]]}";
  }
  out << "]}";
}

class SfmSuiteNeutral : public testing::Test {
 protected:
  std::vector<ScoreRow> rows_of(const std::vector<int>& lost) {
    PlantViewsConfig what;
    what.images = 8;
    what.noise_px = 0;
    what.lost = lost;
    const PlantViews views = plant_views(what, 4);
    write_photographs(folder_.path(), views);
    StandInColmap colmap(folder_.path() / "program");
    colmap.add_model(0, views);
    SfmSuiteConfig config;
    config.folder = folder_.path() / "runs";
    config.neutral = folder_.path();
    config.program = colmap.program();
    return neutral_rows(config);
  }
  static const ScoreRow* find(const std::vector<ScoreRow>& rows, const std::string& method,
                              const std::string& metric) {
    const auto found = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& row) {
      return row.method == method && row.metric == metric;
    });
    return found == rows.end() ? nullptr : &*found;
  }

  TemporaryFolder folder_;
};

TEST_F(SfmSuiteNeutral, BothChoicesOfPairsAreScoredAndHeldAgainstEachOther) {
  const std::vector<ScoreRow> rows = rows_of({});
  for (const char* pairs : {"ordered", "exhaustive"}) {
    const std::string method = std::string(pairs) + " pairs";
    const ScoreRow* placed = find(rows, method, "views placed");
    ASSERT_NE(placed, nullptr) << method;
    EXPECT_EQ(placed->value, 8);
    EXPECT_EQ(placed->n, 8);
    ASSERT_NE(find(rows, method, "seconds of matches"), nullptr);
    const ScoreRow* centres = find(rows, method + ", COLMAP's own", "camera.centre_rms");
    ASSERT_NE(centres, nullptr);
    EXPECT_LT(centres->value, 1e-6);  // exact poses, in another frame and unit
    EXPECT_EQ(centres->unit, "m");
  }
  const ScoreRow* all = find(rows, "exhaustive pairs", "pairs matched");
  const ScoreRow* some = find(rows, "ordered pairs", "pairs matched");
  ASSERT_TRUE(all != nullptr && some != nullptr);
  EXPECT_EQ(all->value, 8 * 7 / 2);
  EXPECT_LE(some->value, all->value);
  const char* against = "ordered against exhaustive";
  const ScoreRow* lost = find(rows, against, "views lost (at most 0)");
  ASSERT_NE(lost, nullptr);
  EXPECT_EQ(lost->status, ScoreStatus::pass);
  EXPECT_NE(find(rows, against, "CPU seconds of matching over all pairs' (at most 0.333)"),
            nullptr);
}

TEST_F(SfmSuiteNeutral, AViewThatIsLostFails) {
  const std::vector<ScoreRow> rows = rows_of({3});
  const ScoreRow* lost = find(rows, "ordered against exhaustive", "views lost (at most 0)");
  ASSERT_NE(lost, nullptr);
  EXPECT_EQ(lost->value, 1);
  EXPECT_EQ(lost->status, ScoreStatus::fail);
}

TEST_F(SfmSuiteNeutral, WhatIsAbsentIsARowAndAProgramThatFailsAnError) {
  SfmSuiteConfig config;
  config.folder = folder_.path() / "runs";
  config.neutral = folder_.path() / "nowhere";
  std::vector<ScoreRow> rows = neutral_rows(config);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].status, ScoreStatus::not_built);
  EXPECT_NE(rows[0].metric.find("nowhere"), std::string::npos);
  const PlantViews views = plant_views({.images = 4}, 4);
  write_photographs(folder_.path(), views);
  config.neutral = folder_.path();
  config.program = (folder_.path() / "no_program").string();
  rows = neutral_rows(config);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].status, ScoreStatus::not_built);
  const StandInColmap failing(folder_.path() / "program", "[ $command = help ] || exit 1");
  config.program = failing.program();
  EXPECT_THROW((void)neutral_rows(config), std::runtime_error);
}

}  // namespace
}  // namespace cousin
