// Text of somebody's files on the page: it is shown, and nothing of it runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "benchmarks/report/html.h"
#include "benchmarks/report/report.h"
#include "sim/types/utf8.h"
#include "tests/benchmarks/report/browser.h"
#include "tests/benchmarks/report/example_report.h"
#include "tests/benchmarks/report/hostile_text.h"

namespace cousin {
namespace {

void spoil(ScoreRow& row) {
  for (std::string* text : {&row.suite, &row.scene, &row.case_name, &row.method, &row.metric})
    *text += hostile_text();
  row.unit = hostile_text();
}

void spoil(SpecimenRow& row) {
  for (std::string* text :
       {&row.dataset, &row.scene, &row.cultivar, &row.run, &row.method, &row.trait, &row.unit})
    *text += hostile_text();
}

void spoil(Headline& headline) {
  for (std::string* text : {&headline.label, &headline.limit, &headline.group})
    *text += hostile_text();
  headline.unit = hostile_text();
}

/// The example with every text of it spoiled.
ReportInput hostile_report() {
  const std::string bad = hostile_text();
  ReportInput input = example_report();
  input.title += bad;
  input.summary += bad;
  input.commands.push_back(bad);
  input.config_toml += bad;
  input.notes.push_back(bad);
  ScoreHeader& header = input.scores.header;
  header = {bad, bad, bad, bad, {{bad, bad}, {"note", bad}}};
  for (ScoreRow& row : input.scores.scores) spoil(row);
  for (SpecimenRow& row : input.scores.specimens) spoil(row);
  for (SpecimenRow& row : input.plotted) spoil(row);
  for (Headline& headline : input.headlines) spoil(headline);
  for (Headline& headline : input.limits) spoil(headline);
  input.tables.push_back({bad, bad, {bad}, {{bad}}});
  for (ReportImage& image : input.images) image.name = image.caption = bad;
  for (ReportShape& shape : input.shapes) shape.name = shape.caption = bad;
  for (Distribution& distribution : input.distributions) {
    distribution.title = distribution.quantity = distribution.unit = bad;
    for (DistributionGroup& group : distribution.groups) group.name = group.kind = bad + group.name;
  }
  for (ErrorTimeCurve& curve : input.curves) {
    curve.title = curve.metric = curve.unit = bad;
    for (ErrorTimePoint& point : curve.points) point.method = point.setting = bad + point.method;
  }
  for (LinePlot& plot : input.lines) {
    plot.title = plot.x_label = plot.y_label = plot.section = bad;
    plot.caption = {bad};
    for (LineSeries& series : plot.series) series.name = bad + series.name;
  }
  for (Attribution& attribution : input.attributions) {
    attribution.title = attribution.metric = attribution.unit = bad;
    for (AttributionStep& step : attribution.steps) step.stage = bad + step.stage;
  }
  for (StageTiming& timing : input.timings) timing.stage = bad + timing.stage;
  return input;
}

TEST(HostilePage, NoTextOfFilesIsMarkupOnThePage) {
  const std::string page = make_report(hostile_report());
  EXPECT_EQ(count(page, "<hostile"), 0);
  EXPECT_EQ(count(page, "<img src=x"), 0);
  EXPECT_EQ(count(page, "<svg onload"), 0);
  EXPECT_EQ(count(page, "href=\"javascript:"), 0);
  EXPECT_EQ(count(page, "\x1b"), 0);
  EXPECT_GT(count(page, "&lt;hostile&gt;"), 50);
  EXPECT_TRUE(is_utf8(page));
}

TEST(HostilePage, HasAsManyElementsAsAPlainOne) {
  ReportInput plain = example_report();
  plain.notes.emplace_back("x");
  plain.commands.emplace_back("x");
  plain.tables.push_back({"x", "x", {"x"}, {{"x"}}});
  const std::string page = make_report(hostile_report()), other = make_report(plain);
  EXPECT_EQ(count(page, "</script>"), count(other, "</script>"));
  EXPECT_EQ(count(page, "<script"), count(other, "<script"));
  EXPECT_EQ(count(page, "</style>"), 1);
  EXPECT_EQ(count(page, "</pre>"), count(other, "</pre>"));
}

TEST(HostilePage, RunsNoScriptOfAnyText) {
  if (!has_chromium())
    GTEST_SKIP() << "Chromium is not installed (Debian package chromium): the page is not opened";
  const std::string dom = shown_document(make_report(hostile_report()), kWithoutWebgl);
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), testing::Not(testing::HasSubstr("data-hostile")));
  EXPECT_EQ(count(dom, "<hostile"), 0);
}

TEST(HostilePage, TheTestSeesAScriptThatRuns) {
  if (!has_chromium())
    GTEST_SKIP() << "Chromium is not installed (Debian package chromium): the page is not opened";
  const std::string dom =
      shown_document("<html><body>" + hostile_text() + "</body></html>", kWithoutWebgl);
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-hostile"));
}

}  // namespace
}  // namespace cousin
