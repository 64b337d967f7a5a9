#include "benchmarks/suites/fruits/fruit_suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

FruitSuite suite() {
  return {.name = "fruits", .seed = 1, .plain = "plain", .traits = {"volume"}, .fruits_timed = 10};
}

/// 60 fruits whose relative errors and sigmas are `share` in the first half, thrice in the second.
ScoreFile fruits(double share, double sigma_share) {
  ScoreFile file;
  for (int i = 0; i < 60; ++i) {
    SpecimenRow row;
    row.scene = "plain";
    row.run = "a_run" + std::to_string(i % 2);
    row.frame = 0;
    row.instance = i;
    row.method = "ours";
    row.cultivar = "fuji, unoccluded";
    row.trait = "volume";
    row.unit = "m3";
    row.truth = 1e-4;
    const double factor = i < 30 ? 1 : 3;
    row.measured = row.truth * (1 + (i % 2 == 0 ? share : -share) * factor);
    row.sigma = sigma_share * factor * row.truth;
    file.specimens.push_back(row);
  }
  return file;
}

const ScoreRow* find(const std::vector<ScoreRow>& rows, const std::string& name,
                     const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.case_name == name && row.metric == metric) return &row;
  }
  return nullptr;
}

TEST(FruitSuite, WideIntervalsAreWhereErrorsAreLarge) {
  const std::vector<ScoreRow> rows = fruit_pooled_rows(suite(), fruits(0.02, 0.02));
  const ScoreRow* ratio = find(rows, "all", "volume.rmse_by_width");
  ASSERT_NE(ratio, nullptr);
  EXPECT_NEAR(ratio->value, 3, 0.3);
  // Intervals that say nothing of it are of one width: any third is as good.
  ScoreFile same = fruits(0.02, 0.02);
  for (SpecimenRow& row : same.specimens) row.sigma = 0.04 * row.measured;
  const std::vector<ScoreRow> other = fruit_pooled_rows(suite(), same);
  EXPECT_LT(find(other, "all", "volume.rmse_by_width")->value, 2);
}

TEST(FruitSuite, TheSurestBoxesErrLess) {
  const std::vector<ScoreRow> rows = fruit_pooled_rows(suite(), fruits(0.02, 0.02));
  const ScoreRow* half = find(rows, "all, surest 50 %", "volume.mape");
  ASSERT_NE(half, nullptr);
  EXPECT_EQ(half->n, 30);
  EXPECT_NEAR(half->value, 0.02, 1e-9);
  EXPECT_NEAR(find(rows, "all", "volume.mape")->value, 0.04, 1e-9);
  const LinePlot plot = abstention_plot(rows, "ours", "volume", "volume.mape", "Error, %", 100);
  ASSERT_EQ(plot.series.size(), 1U);
  EXPECT_EQ(plot.series[0].points.size(), 5U);
  EXPECT_NEAR(plot.series[0].points.back().y.value, 4, 1e-9);
}

TEST(FruitSuite, BoxesOfAnotherSceneAreApartAndPointsGoWithTheirBox) {
  ScoreFile file = fruits(0.02, 0.02);
  for (int i = 0; i < 60; ++i) {
    SpecimenRow row = file.specimens[static_cast<std::size_t>(i)];
    row.trait = "point_x";
    row.unit = "m";
    row.cultivar = "fuji";
    row.truth = 0;
    row.measured = i < 30 ? 0.001 : 0.003;
    if (i >= 30) row.scene = "family";
    if (i >= 30) file.specimens[static_cast<std::size_t>(i)].scene = "family";
    file.specimens.push_back(row);
  }
  const std::vector<ScoreRow> rows = fruit_pooled_rows(suite(), file);
  EXPECT_NEAR(find(rows, "all", "point.rmse_x")->value, 0.001, 1e-12);
  EXPECT_NEAR(find(rows, "family, all", "point.rmse_x")->value, 0.003, 1e-12);
  EXPECT_NEAR(find(rows, "family, unoccluded", "volume.mape")->value, 0.06, 1e-9);
}

TEST(FruitSuite, ACaptureOfWhichNothingIsMeasuredTakesNoPlaceFromTheOthers) {
  ScoreFile file = fruits(0.02, 0.02);
  std::vector<SpecimenRow> with_places;
  for (const SpecimenRow& row : file.specimens) {
    with_places.push_back(row);
    if (row.instance % 3 == 0) continue;  // of another capture, whose estimate has no centre
    for (const char* axis : {"x", "y", "z"}) {
      SpecimenRow place = row;
      place.trait = std::string("centre_") + axis;
      place.unit = "m";
      place.truth = 0.5;
      place.measured = 0.501;
      with_places.push_back(place);
    }
  }
  file.specimens = with_places;
  const std::vector<ScoreRow> rows = fruit_pooled_rows(suite(), file);
  const ScoreRow* off = find(rows, "all", "centre.rmse_3d");
  ASSERT_NE(off, nullptr);
  EXPECT_EQ(off->n, 40);
  EXPECT_NEAR(off->value, 0.001 * std::sqrt(3), 1e-9);
}

TEST(FruitSuite, SharesAreOfAllBoxesAndNoMoreAreReportedThanAreMeasured) {
  ScoreFile file = fruits(0.02, 0.02);
  // Of every third box a point alone is measured, whose relative sigma is far smaller; a sixth are
  // of a capture that has no volumes at all.
  std::vector<SpecimenRow> rows_with_points;
  for (SpecimenRow row : file.specimens) {
    const bool has_volume = row.instance % 3 != 0, has_row = row.instance % 6 != 0;
    if (!has_volume) row.status = ScoreStatus::not_solved;
    if (has_row) rows_with_points.push_back(row);
    row.trait = "point_z";
    row.unit = "m";
    row.status = ScoreStatus::ok;
    row.truth = row.measured = 0.5;
    row.sigma = 1e-4;
    rows_with_points.push_back(row);
  }
  file.specimens = rows_with_points;
  const std::vector<ScoreRow> rows = fruit_pooled_rows(suite(), file);
  const ScoreRow* measured = find(rows, "all", "volume.measured");
  ASSERT_NE(measured, nullptr);
  EXPECT_EQ(measured->n, 60);
  EXPECT_NEAR(measured->value, 2.0 / 3, 1e-12);
  EXPECT_EQ(find(rows, "all, surest 75 %", "volume.mape"), nullptr);
  EXPECT_EQ(find(rows, "all, surest 50 %", "volume.mape")->n, 30);
  const LinePlot plot = abstention_plot(rows, "ours", "volume", "volume.mape", "Error, %", 100);
  std::vector<double> shares;
  for (const PlotPoint& point : plot.series.at(0).points) shares.push_back(point.x);
  EXPECT_THAT(shares, testing::ElementsAre(25, 50, testing::DoubleNear(100 * 2.0 / 3, 1e-9)));
}

TEST(FruitSuite, PairsAreOfOneCaseAndStandOnce) {
  ScoreFile file = fruits(0.02, 0.02);
  const ScoreFile twice = fruits(0.04, 0.02);
  for (SpecimenRow row : twice.specimens) {
    row.method = "paper";
    file.specimens.push_back(row);
  }
  for (SpecimenRow row : fruits(0.2, 0.02).specimens) {  // of another family, ours alone is worse
    row.scene = "family";
    row.run = "b_run0";
    file.specimens.push_back(row);
    row.method = "paper";
    file.specimens.push_back(row);
  }
  int all = 0;
  for (const ScoreRow& row : fruit_pooled_rows(suite(), file)) {
    if (row.metric != "volume.rmse_ratio" || row.case_name != "all") continue;
    ++all;
    EXPECT_EQ(row.n, 60);
    EXPECT_NEAR(row.value, 0.5, 1e-9);
  }
  EXPECT_EQ(all, 1);
}

TEST(FruitSuite, ATraitThatMayBeZeroHasNoRelativeError) {
  FruitSuite own = suite();
  own.traits = {"red_share"};
  ScoreFile file = fruits(0.02, 0.02);
  for (SpecimenRow& row : file.specimens) {
    row.trait = "red_share";
    row.unit = "1";
    row.truth = row.instance % 2;
    row.measured = row.truth + 0.01;
  }
  const std::vector<ScoreRow> rows = fruit_pooled_rows(own, file);
  EXPECT_EQ(find(rows, "all", "red_share.mape"), nullptr);
  EXPECT_NEAR(find(rows, "all", "red_share.rmse")->value, 0.01, 1e-12);
}

}  // namespace
}  // namespace cousin
