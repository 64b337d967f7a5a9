#include "benchmarks/suites/seedlings/seedlings_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "benchmarks/score/score_columns.h"
#include "benchmarks/suites/seedlings/field_training.h"
#include "benchmarks/suites/seedlings/published_psnr.h"
#include "benchmarks/suites/seedlings/seedlings_rows.h"

namespace cousin {
namespace {

ScoreRow row_of(const std::string& case_name, const std::string& method, const std::string& metric,
                double value, double wall_s) {
  ScoreRow row;
  row.suite = kSeedlingsSuite;
  row.scene = "D1";
  row.case_name = case_name;
  settings_of_schema_1(row);
  row.method = method;
  row.metric = metric;
  row.value = value;
  row.wall_s = wall_s;
  return row;
}

/// Two sets of photographs of one sample, as the suite's rows have them.
std::vector<ScoreRow> some_rows() {
  std::vector<ScoreRow> rows;
  for (const auto& [set, psnr_db, covered] :
       {std::tuple{"30 views", 24.0, 0.9}, std::tuple{"10 views", 15.0, 0.3}}) {
    const std::string photographs = std::string("sample 0, ") + set + ", 400x300";
    rows.push_back(row_of(photographs + ", 7000 steps", kReference, "held_out.psnr", psnr_db, 100));
    rows.push_back(
        row_of(photographs + ", 7000 steps", kReference, "train.psnr", psnr_db + 4, 100));
    rows.push_back(
        row_of(photographs, "photographs", "coverage.seen_by_3", covered, ScoreRow::kNone));
  }
  rows.push_back(
      row_of("sample 0, 30 views, 400x300, 500 steps", kReference, "held_out.psnr", 20, 5));
  rows.push_back(row_of("sample 0, 30 views, 400x300, 500 steps", kOurs, "held_out.psnr", 22, 5));
  for (ScoreRow& row : published_rows()) rows.push_back(row);
  const std::vector<ScoreRow> means = mean_rows(rows);
  rows.insert(rows.end(), means.begin(), means.end());
  return rows;
}

const LinePlot& plot_named(const std::vector<LinePlot>& plots, const std::string& title) {
  const auto plot =
      std::find_if(plots.begin(), plots.end(), [&](const LinePlot& p) { return p.title == title; });
  if (plot == plots.end()) throw std::runtime_error("no plot " + title);
  return *plot;
}

TEST(SeedlingsPage, TablesHoldEachMethodBesideWhatWasPublished) {
  const std::vector<ReportTable> tables = seedlings_tables(some_rows());
  ASSERT_GE(tables.size(), 2u);
  EXPECT_EQ(tables[0].title, "Seedlings, D1: three methods, PSNR in dB");
  std::map<std::string, std::vector<std::string>> lines;
  for (const auto& line : tables[0].lines) lines[line[0] + " " + line[1]] = line;
  const std::vector<std::string>& reference = lines.at(std::string(kReference) + " 7000");
  EXPECT_EQ(reference[3], "28.0");
  EXPECT_EQ(reference[4], "24.0");
  EXPECT_EQ(reference[10], "100");
  EXPECT_EQ(lines.at("published: 3DGS 7000")[3].substr(0, 5), "25.0 ");
  EXPECT_EQ(lines.at("published: 3DGS 7000")[2], "12");
  EXPECT_FALSE(lines.contains(std::string(kOurs) + " 500"));  // it has no views trained on
  const ReportTable& covered = tables.back();
  ASSERT_EQ(covered.lines.size(), 2u);
  EXPECT_EQ(covered.lines[1][1], "10 views");
  EXPECT_EQ(covered.lines[1][2], "30.0");
  EXPECT_EQ(covered.lines[1][4], "15.0");
}

TEST(SeedlingsPage, PsnrIsDrawnOverTheSecondsOfEachMethod) {
  const std::vector<LinePlot> plots = seedlings_plots(some_rows());
  const LinePlot& held_out = plot_named(plots, "D1: PSNR of held-out views over training time");
  ASSERT_EQ(held_out.series.size(), 2u);
  ASSERT_EQ(held_out.series[0].points.size(), 2u);
  EXPECT_EQ(held_out.series[0].name, kReference);
  EXPECT_EQ(held_out.series[0].points[0].x, 5);
  EXPECT_EQ(held_out.series[0].points[1].y.value, 24);
  EXPECT_NE(held_out.x_label.find("(s)"), std::string::npos);
  EXPECT_NE(held_out.y_label.find("(dB)"), std::string::npos);
  // The published means stand beside views trained on alone.
  const LinePlot& trained = plot_named(plots, "D1: PSNR of views trained on over training time");
  ASSERT_EQ(trained.series.size(), 2u);
  EXPECT_NEAR(trained.series[1].points.at(0).y.value, 25.0, 0.05);
}

TEST(SeedlingsPage, AMethodHasItsColourWhereOthersAreMissing) {
  std::vector<ScoreRow> rows = some_rows();
  for (ScoreRow& row : rows) {
    if (row.metric == "held_out.psnr") row.method = kOurs;
  }
  const std::vector<LinePlot> plots = seedlings_plots(rows);
  const LinePlot& alone = plot_named(plots, "D1: PSNR of held-out views over training time");
  ASSERT_EQ(alone.series.size(), 1u);
  EXPECT_EQ(alone.series[0].color, 1u);
}

TEST(SeedlingsPage, PsnrIsDrawnOverTheNumberOfViews) {
  std::vector<ScoreRow> rows;
  for (const int views : {120, 30, 60}) {
    const std::string photographs = "sample 0, " + std::to_string(views) + " views, 400x300, ";
    rows.push_back(row_of(photographs + std::to_string(kMoreViewsSteps) + " steps", kOurs,
                          "held_out.psnr_exposed", 20 + 0.05 * views, 9));
    rows.push_back(row_of(photographs + "500 steps", kOurs, "held_out.psnr_exposed", 1, 3));
  }
  const std::vector<LinePlot> plots = seedlings_plots(rows);
  const LinePlot& plot = plot_named(plots, "PSNR over the number of views trained on");
  ASSERT_EQ(plot.series.size(), 1u);  // nothing is said of views trained on
  EXPECT_EQ(plot.series[0].name, "D1, held-out views");
  ASSERT_EQ(plot.series[0].points.size(), 3u);
  EXPECT_EQ(plot.series[0].points[0].x, 30);
  EXPECT_EQ(plot.series[0].points[2].x, 120);
  EXPECT_EQ(plot.series[0].points[2].y.value, 26);
}

TEST(SeedlingsPage, PsnrIsDrawnOverCoverageWhereAllSetsWereScoredAlike) {
  const std::vector<LinePlot> plots = seedlings_plots(some_rows());
  const LinePlot& plot = plot_named(plots, "PSNR of held-out views over view coverage");
  ASSERT_EQ(plot.series.size(), 2u);
  EXPECT_EQ(plot.series[0].name, "10 views");
  ASSERT_EQ(plot.series[0].points.size(), 1u);
  EXPECT_DOUBLE_EQ(plot.series[0].points[0].x, 30);
  EXPECT_EQ(plot.series[0].points[0].y.value, 15);
  EXPECT_FALSE(plot.series[0].is_joined);
  EXPECT_NE(plot.caption.at(0).find("7000 steps"), std::string::npos);
}

TEST(SeedlingsPage, CurvesHaveTheErrorThatPsnrStandsFor) {
  const std::vector<ErrorTimeCurve> curves = seedlings_curves(some_rows());
  ASSERT_EQ(curves.size(), 1u);
  ASSERT_EQ(curves[0].points.size(), 3u);
  EXPECT_NEAR(curves[0].points[1].error.value, 0.1, 1e-12);  // 20 dB
}

TEST(SeedlingsPage, OtherSuitesDrawNothing) {
  ScoreRow row = row_of("mean, 30 views, 400x300, 500 steps", kOurs, "held_out.psnr", 20, 5);
  row.suite = "splats";
  EXPECT_TRUE(seedlings_plots({row}).empty());
  EXPECT_TRUE(seedlings_curves({row}).empty());
}

}  // namespace
}  // namespace cousin
