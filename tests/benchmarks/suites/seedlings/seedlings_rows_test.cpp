#include "benchmarks/suites/seedlings/seedlings_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "benchmarks/score/score_columns.h"

namespace cousin {
namespace {

ScoreRow row_of(const std::string& case_name, const std::string& method, double value,
                double wall_s) {
  ScoreRow row;
  row.suite = kSeedlingsSuite;
  row.scene = "D1";
  row.case_name = case_name;
  settings_of_schema_1(row);
  row.method = method;
  row.metric = "held_out.psnr";
  row.unit = "dB";
  row.value = value;
  row.wall_s = wall_s;
  row.cpu_s = 2 * wall_s;
  row.n = 7;
  return row;
}

TEST(SeedlingsRows, NamesOfSchema1GiveTheSettings) {
  const ScoreRow row = row_of("sample 2, 30 views, 400x300, 7000 steps", kOurs, 1, 1);
  EXPECT_EQ(row.run, 2);
  EXPECT_EQ(row.views, 30);
  EXPECT_EQ(row.width_px, 400);
  EXPECT_EQ(row.height_px, 300);
  EXPECT_EQ(row.steps, 7000);
  EXPECT_EQ(row_of("sample 0, 30 views, 400x300", kOurs, 1, 1).steps, 0);
  const ScoreRow seeds = row_of(
      "zhengdan958 run 3 60 views 1280x720, one in 8 held out, poses sfm, 900 steps", kOurs, 1, 1);
  EXPECT_EQ(seeds.run, 3);
  EXPECT_EQ(seeds.views, 60);
  EXPECT_EQ(seeds.height_px, 720);
  EXPECT_EQ(seeds.held_out_every, 8);
  EXPECT_EQ(seeds.poses, "sfm");
  EXPECT_EQ(seeds.steps, 900);
  EXPECT_EQ(row_of("", kOurs, 1, 1).views, 0);
  EXPECT_EQ(row_of("x run y views, poses ", kOurs, 1, 1).run, -1);
}

TEST(SeedlingsRows, MeansThatStandBesideOneAnotherAreOfTheSameSamples) {
  const std::string rest = ", 30 views, 400x300, 7000 steps";
  const std::vector<ScoreRow> rows = {
      row_of("sample 0" + rest, kReference, 30, 1), row_of("sample 0" + rest, kOurs, 33, 1),
      row_of("sample 0" + rest, kOurs, 33, 9),  // another job's, of the same training
      row_of("sample 1" + rest, kOurs, 39, 1),
      row_of("sample 1, 30 views, 400x300, 2000 steps", kOurs, 38, 1)};
  const std::vector<ScoreRow> means = mean_rows(rows);
  ASSERT_EQ(means.size(), 3u);
  EXPECT_DOUBLE_EQ(means[1].value, 33);  // of ours, without the sample that the reference lacks
  EXPECT_EQ(means[1].n, 1);
  EXPECT_DOUBLE_EQ(means[2].value, 38);  // no other method has that case
}

TEST(SeedlingsRows, MeansAreOverTheSamplesOfOneCase) {
  std::vector<ScoreRow> rows = {row_of("sample 0, 30 views, 400x300, 500 steps", kOurs, 20, 4),
                                row_of("sample 1, 30 views, 400x300, 500 steps", kOurs, 24, 8),
                                row_of("sample 0, 30 views, 400x300, 900 steps", kOurs, 30, 9)};
  rows.push_back(row_of("sample 2, 30 views, 400x300, 500 steps", kOurs, 99, 1));
  rows.back().status = ScoreStatus::not_solved;
  const std::vector<ScoreRow> means = mean_rows(rows);
  ASSERT_EQ(means.size(), 2u);
  EXPECT_EQ(means[0].case_name, "mean, 30 views, 400x300, 500 steps");
  EXPECT_DOUBLE_EQ(means[0].value, 22);
  EXPECT_DOUBLE_EQ(means[0].wall_s, 6);
  EXPECT_EQ(means[0].n, 2);
  // Of two values 4 apart: standard error 2, and t(0.975, 1) = 12.7062.
  EXPECT_NEAR(means[0].ci_high - 22, 2 * 12.7062, 1e-3);
  EXPECT_NEAR(means[0].ci_low - 22, -2 * 12.7062, 1e-3);
  EXPECT_EQ(means[1].n, 1);
  EXPECT_TRUE(std::isnan(means[1].ci_low));
}

TEST(SeedlingsRows, OursIsItsLastTrainingThatTookNoLonger) {
  const std::string at = "sample 0, 30 views, 400x300, ";
  std::vector<ScoreRow> rows = {row_of(at + "500 steps", kReference, 20, 5),
                                row_of(at + "7000 steps", kReference, 25, 100),
                                row_of(at + "30000 steps", kReference, 30, 900),
                                row_of(at + "1000 steps", kOurs, 24, 10),
                                row_of(at + "2000 steps", kOurs, 26, 90),
                                row_of(at + "5000 steps", kOurs, 28, 101)};
  const std::vector<ScoreRow> gains = equal_time_rows(rows, 7000);
  ASSERT_EQ(gains.size(), 2u);
  // Of 10, 90 and 101 s the second was there after 100.
  EXPECT_NEAR(gains[0].value, 1, 1e-12);
  EXPECT_EQ(gains[0].metric, "held_out.psnr_gain_at_equal_seconds");
  EXPECT_EQ(gains[0].case_name, at + "7000 steps");
  EXPECT_EQ(gains[0].method, kOurs);
  // By CPU time it is the same, as long as nothing runs beside ours.
  EXPECT_EQ(gains[1].metric, "held_out.psnr_gain_at_equal_cpu_seconds");
  EXPECT_NEAR(gains[1].value, 1, 1e-12);
  rows[4].wall_s *= 10;
  const std::vector<ScoreRow> disturbed = equal_time_rows(rows, 7000);
  EXPECT_NEAR(disturbed.at(0).value, -1, 1e-12);
  EXPECT_NEAR(disturbed.at(1).value, 1, 1e-12);
  // As long counts; where none of ours was there, or without one of both, there is nothing.
  rows[4].wall_s = 100;
  EXPECT_NEAR(equal_time_rows(rows, 7000).at(0).value, 1, 1e-12);
  EXPECT_TRUE(equal_time_rows({rows[1], rows[5]}, 7000).empty());
  EXPECT_TRUE(equal_time_rows({rows[3], rows[4]}, 7000).empty());
  EXPECT_TRUE(equal_time_rows({rows[2], rows[4]}, 7000).empty());
  // Of another machine than the reference's a training's seconds say nothing beside it.
  const TrainingMachines machines = {{training_of(rows[1]), "slow"},
                                     {training_of(rows[3]), "slow"},
                                     {training_of(rows[4]), "fast"}};
  EXPECT_NEAR(equal_time_rows(rows, 7000, machines).at(0).value, -1, 1e-12);
}

TEST(SeedlingsRows, ATrainingThatFailedSaysWhy) {
  SeedlingsJob job;
  job.set = {"10 views", 10, false};
  job.plan = {kNgp, {100}};
  TrainedField field;
  field.status = "no_volume, because";
  const std::vector<ScoreRow> rows = sample_rows(job, 3, field, {}, {});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].status, ScoreStatus::not_solved);
  EXPECT_EQ(rows[0].metric, "training: no_volume, because");
  EXPECT_EQ(rows[0].case_name, "sample 0, 10 views, 400x300");
}

}  // namespace
}  // namespace cousin
