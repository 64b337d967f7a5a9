#include "benchmarks/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "benchmarks/report/html.h"
#include "benchmarks/report/shape_json.h"
#include "tests/benchmarks/report/example_report.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ParetoFront, KeepsWhatNothingBeats) {
  const auto point = [](double s, double e) { return ErrorTimePoint{"m", "", s, {.value = e}}; };
  EXPECT_EQ(pareto_front({point(1, 5), point(2, 3), point(3, 4), point(4, 3), point(5, 1),
                          point(0.5, std::nan(""))}),
            (std::vector<bool>{true, true, false, false, true, false}));
  // Two equal points do not beat each other.
  EXPECT_EQ(pareto_front({point(1, 1), point(1, 1)}), (std::vector<bool>{true, true}));
}

TEST(Report, LoadsNothingFromAnywhere) {
  const std::string html = make_report(example_report());
  // Addresses occur inside the libraries as names (SVG's namespace); none is in a tag that would
  // load it.
  for (const char* tag : {"<script src", "<link rel=\"stylesheet", "<img src=\"http", "@import",
                          "url(http", "<iframe"}) {
    EXPECT_THAT(html.find(tag), std::string::npos) << tag;
  }
}

TEST(Report, ManyNumbersAreFoldedBelowThePlotsAndThoseThatFailedComeFirst) {
  ReportInput input = example_report();
  EXPECT_EQ(make_report(input).find("<details class=\"numbers\">"), std::string::npos);
  input.headlines.clear();
  for (int i = 0; i < 55; ++i)
    input.headlines.push_back({"number " + std::to_string(i), {1.0}, "m", "", ScoreStatus::ok});
  input.headlines[40].status = ScoreStatus::fail;
  const std::string page = make_report(input);
  const std::size_t folded = page.find("<details class=\"numbers\">");
  const std::size_t failed = page.find(">number 40<"), other = page.find(">number 41<");
  const std::size_t plots = page.find("<h2 id=\"errors\"");
  ASSERT_NE(folded, std::string::npos);
  ASSERT_NE(plots, std::string::npos);
  EXPECT_LT(failed, plots);
  EXPECT_LT(plots, folded);
  EXPECT_GT(other, folded);
}

TEST(Report, PlotsStandUnderTheHeadingThatTheyName) {
  ReportInput input = example_report();
  LinePlot plot;
  plot.title = "over distance";
  plot.series = {{.name = "a", .points = {{0, {1}}, {1, {2}}}}};
  input.lines = {plot};
  EXPECT_NE(make_report(input).find(">Along one quantity<"), std::string::npos);
  input.lines[0].section = "Along the axes of distance";
  const std::string page = make_report(input);
  EXPECT_NE(page.find(">Along the axes of distance<"), std::string::npos);
  EXPECT_EQ(page.find(">Along one quantity<"), std::string::npos);
  EXPECT_EQ(page.find(">Against theory<"), std::string::npos);
}

TEST(Report, ASeriesHasTheColourThatItNames) {
  ReportInput input;
  LinePlot plot;
  plot.series = {{.name = "a", .points = {{0, {1}}, {1, {2}}}}};
  input.lines = {plot};
  EXPECT_NE(make_report(input).find("\"range\":[\"#2b83c6\"]"), std::string::npos);
  input.lines[0].series[0].color = 1;
  EXPECT_NE(make_report(input).find("\"range\":[\"#d55e00\"]"), std::string::npos);
}

TEST(Report, TextNeverBecomesMarkup) {
  const std::string html = make_report(example_report());
  EXPECT_EQ(html.find("<b>not markup</b>"), std::string::npos);
  EXPECT_NE(html.find("Seeds: example &lt;report&gt; &amp; &quot;quotes&quot;"), std::string::npos);
  ReportInput hostile;
  hostile.title = "</title><script>alert(1)</script>";
  SpecimenRow row;
  row.trait = "</script><script>alert(2)</script>";
  row.unit = "m";
  row.truth = row.measured = 1;
  hostile.scores.specimens = hostile.plotted = {row};
  const std::string page = make_report(hostile);
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
}

TEST(Report, WhatIsNotPlottedIsInTheFilesOnly) {
  ReportInput input = example_report();
  const std::string point = "\"cultivar\":\"tianguinuo932\"";  // of a plot's data
  ASSERT_NE(make_report(input).find(point), std::string::npos);
  std::erase_if(input.plotted, [](const SpecimenRow& r) { return r.cultivar == "tianguinuo932"; });
  const std::string html = make_report(input);
  EXPECT_EQ(html.find(point), std::string::npos);
  EXPECT_NE(html.find("specimens.csv"), std::string::npos);
}

TEST(Report, LimitsAreATableOfGroupsWithTheCountOfThoseKept) {
  const std::string html = make_report(example_report());
  EXPECT_NE(html.find("3 of 4 numbers keep their limit"), std::string::npos);
  EXPECT_NE(html.find("within 0.03 mm</span> <span class=\"status fail\">"), std::string::npos);
  // One line for both species.
  const std::string line = "<tr><td>length.rmse</td>";
  const std::size_t first = html.find(line);
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(html.find(line, first + 1), std::string::npos);
}

TEST(Report, TablesAreOnThePageAndInTheTerminal) {
  ScoreRow row;
  row.value = 0.000304;
  ReportInput input;
  input.tables = {
      {"Sizes",
       "of <50> seeds",
       {"way", "RMSE mm", "n"},
       {{"3DGS", table_cell(&row, 1000, 3), "50"}, {"µ", table_cell(nullptr, 1, 1), ""}}}};
  const std::string html = make_report(input);
  EXPECT_NE(html.find("<td>0.304</td><td>50</td>"), std::string::npos);
  EXPECT_NE(html.find("of &lt;50&gt; seeds"), std::string::npos);
  EXPECT_EQ(table_text(input.tables[0]),
            "Sizes\nof <50> seeds\nway   RMSE mm  n\n3DGS  0.304    50\nµ              \n");
  row.value = ScoreRow::kNone;
  EXPECT_EQ(table_cell(&row, 1000, 3), "");
  input.tables[0].lines[1].pop_back();
  EXPECT_THROW(make_report(input), std::invalid_argument);
}

TEST(Report, IsTheSameBytesEachTime) {
  EXPECT_TRUE(make_report(example_report()) == make_report(example_report()));
}

TEST(Report, SaysWhichLibrariesWereMissing) {
  const std::string html = make_report(example_report(), {.javascript = "/nonexistent"});
  EXPECT_NE(html.find("/nonexistent/vega/vega-util.min.js (Debian package libjs-vega)"),
            std::string::npos);
  EXPECT_NE(html.find("libjs-three"), std::string::npos);
  EXPECT_LT(html.size(), 1000000U);
}

TEST(Report, ThinsLargeCloudsAndSaysSo) {
  ReportInput input;
  ReportShape cloud{
      "cloud", "Fused.", std::vector<Eigen::Vector3f>(1000, Eigen::Vector3f::Zero()), {}, {}};
  input.shapes = {cloud};
  EXPECT_NE(make_report(input, {.max_points = 100}).find("Fused. Shown: 100 of 1000 points."),
            std::string::npos);
}

ReportShape two_gaussians() {
  const Eigen::Quaternionf straight = Eigen::Quaternionf::Identity();
  return {"model",
          "Trained.",
          {Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones()},
          {{10, 20, 30}, {40, 50, 60}},
          {},
          {{Eigen::Vector3f(1, 1, 0.1F), straight, 0.9F},
           {Eigen::Vector3f(0.1F, 0.1F, 0.1F), straight, 0.9F}}};
}

TEST(Report, KeepsTheGaussiansThatHideMost) {
  const ReportShape kept = thinned(two_gaussians(), 1);
  ASSERT_EQ(kept.positions_m.size(), 1U);
  EXPECT_EQ(kept.positions_m[0], Eigen::Vector3f::Zero());
  EXPECT_EQ(kept.colors[0].g, 20);
  EXPECT_EQ(kept.caption, "Trained. Shown: 1 of 2 Gaussians, those that hide most.");
}

TEST(Report, GaussiansAreCodedWithinTheirRange) {
  const auto json = shape_json(two_gaussians());
  EXPECT_NEAR(json["log_scale"][0].get<double>(), std::log(0.1), 1e-6);
  EXPECT_NEAR(json["log_scale"][1].get<double>(), 0, 1e-6);
  // 1, 1, 0.1 are the largest, the largest and the least code; an unturned axis is 127, 0, 0, 0.
  EXPECT_EQ(json["scales"].get<std::string>().substr(0, 8),
            base64(std::string("\xff\xff\xff\xff\0\0", 6)));
  EXPECT_EQ(json["rotations"].get<std::string>(), base64(std::string("\x7f\0\0\0\x7f\0\0\0", 8)));
}

TEST(Report, RejectsGaussiansThatCannotBeDrawn) {
  ReportInput input;
  input.shapes = {two_gaussians()};
  EXPECT_NO_THROW(make_report(input));
  input.shapes[0].splats[1].scale_m.y() = 0;
  EXPECT_THROW(make_report(input), std::invalid_argument);
  input.shapes = {two_gaussians()};
  input.shapes[0].splats[1].opacity = NAN;
  EXPECT_THROW(make_report(input), std::invalid_argument);
  input.shapes = {two_gaussians()};
  input.shapes[0].splats[1].rotation.coeffs().setZero();
  EXPECT_THROW(make_report(input), std::invalid_argument);
  input.shapes = {two_gaussians()};
  input.shapes[0].splats.pop_back();
  EXPECT_THROW(make_report(input), std::invalid_argument);
}

TEST(Report, RejectsShapesAndTimesThatCannotBeDrawn) {
  ReportInput input;
  input.shapes = {{"bad", "", {Eigen::Vector3f::Zero()}, {}, {{0, 0, 1}}}};
  EXPECT_THROW(make_report(input), std::invalid_argument);
  input.shapes = {{"bad", "", {Eigen::Vector3f::Constant(NAN)}, {}, {}}};
  EXPECT_THROW(make_report(input), std::invalid_argument);
  input.shapes = {{"bad", "", {Eigen::Vector3f::Zero()}, {{}, {}}, {}}};
  EXPECT_THROW(make_report(input), std::invalid_argument);
  input.shapes.clear();
  input.curves = {{"c", "e", "m", {{"m", "s", 0, {.value = 1}}}}};
  EXPECT_THROW(make_report(input), std::invalid_argument);
}

TEST(Report, DistributionsSayMeanAndSpreadOfEachGroup) {
  ReportInput input;
  input.distributions = {
      {"Lengths", "length", "m", {{"lot", "real", {0.006, 0.008}}, {"none", "real", {}}}}};
  const std::string html = make_report(input);
  // 7 mm, and sqrt(2) of a millimetre between two grains that are 2 mm apart.
  EXPECT_NE(html.find("7.00 ± 1.41 mm (20.2 %)"), std::string::npos);
  EXPECT_NE(html.find("lot, n = 2"), std::string::npos);
  EXPECT_EQ(html.find("none, n"), std::string::npos);
  input.distributions[0].groups = {{"alike", "real", {0.006, 0.006}}};
  EXPECT_NE(make_report(input).find("6.00 ± 0 mm (0 %)"), std::string::npos);
  input.distributions[0].groups[0].values = {NAN};
  EXPECT_THROW(make_report(input), std::invalid_argument);
  input.distributions[0].groups[0].values.clear();
  EXPECT_EQ(make_report(input).find("id=\"distributions\""), std::string::npos);
}

TEST(Report, AnEmptyReportIsAPage) {
  const std::string html = make_report({});
  EXPECT_NE(html.find("How this was made"), std::string::npos);
  EXPECT_EQ(html.find("id=\"scores\""), std::string::npos);
}

}  // namespace
}  // namespace cousin
