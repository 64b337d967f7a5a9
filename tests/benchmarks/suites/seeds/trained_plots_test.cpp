#include "benchmarks/suites/seeds/trained_plots.h"

#include <gtest/gtest.h>

#include <string>

#include "benchmarks/score/score_columns.h"

namespace cousin {
namespace {

ScoreRow row_of(const char* method, const char* case_name, const char* metric, double wall_s,
                double value) {
  ScoreRow row;
  row.method = method;
  row.scene = std::string(case_name).substr(0, 1);
  row.case_name = case_name;
  settings_of_schema_1(row);
  row.metric = metric;
  row.wall_s = wall_s;
  row.value = value;
  return row;
}

TEST(TrainedPlots, ATrainingIsOneLineInTheOrderOfItsSeconds) {
  const char* metric = "train.psnr_whole_small";
  const std::vector<LinePlot> plots = trained_plots(
      {row_of("splats", "a run 0 60 views 8x6, 1200 steps", metric, 30, 40),
       row_of("splats", "a run 0 60 views 8x6, 300 steps", metric, 10, 35),
       row_of("instant-ngp", "a run 0 60 views 8x6, 500 steps", metric, 20, 33),
       row_of("splats", "b run 0 60 views 8x6, 300 steps", metric, 11, 36),
       row_of("splats", "b run 0 60 views 8x6, 300 steps", "held_out.psnr_whole_small", 11, 30),
       row_of("splats", "b run 0 60 views 8x6, 300 steps", "train.ssim", 11, 0.9)});
  ASSERT_EQ(plots.size(), 3U);
  ASSERT_EQ(plots[0].series.size(), 2U);
  const LineSeries& first = plots[0].series[0];
  ASSERT_EQ(first.points.size(), 2U);
  EXPECT_EQ(first.points[0].x, 10);
  EXPECT_EQ(first.points[1].y.value, 40);
  EXPECT_EQ(plots[0].title, "a run 0 60 views 8x6: PSNR over training time, views trained on");
  EXPECT_EQ(plots[2].title, "b run 0 60 views 8x6: PSNR over training time, views held out");
}

}  // namespace
}  // namespace cousin
