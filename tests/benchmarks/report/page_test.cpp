// The page in a real browser: headless Chromium prints the document after its scripts have run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "benchmarks/report/report.h"
#include "tests/benchmarks/report/browser.h"
#include "tests/benchmarks/report/example_report.h"

namespace cousin {
namespace {

class Page : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_chromium()) {
      GTEST_SKIP() << "Chromium is not installed (Debian package chromium): the page is not tested";
    }
  }
};

TEST_F(Page, LoadsWithoutErrorsAndDrawsEveryPlotAndShape) {
  const std::string dom = shown_document(make_report(example_report()), kWithWebgl);
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-errors=\"0\""));
  // Four scatter plots, four histograms, one line plot, one distribution, one curve, one waterfall,
  // one timing plot.
  EXPECT_EQ(count(dom, "data-plot-ok=\"true\""), 13);
  EXPECT_EQ(count(dom, "data-plot-ok=\"false\""), 0);
  EXPECT_EQ(count(dom, "data-warnings"), 0);
  EXPECT_EQ(count(dom, "data-view-ok=\"webgl\"") + count(dom, "data-view-ok=\"canvas\""), 3);
}

TEST_F(Page, PaintsShapesOnACanvasWithoutWebgl) {
  const std::string dom = shown_document(make_report(example_report()), kWithoutWebgl);
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-errors=\"0\""));
  EXPECT_EQ(count(dom, "data-view-ok=\"canvas\""), 3);
}

TEST_F(Page, StandsWithoutTheLibraries) {
  const std::string dom = shown_document(
      make_report(example_report(), {.javascript = "/nonexistent"}), " --disable-gpu");
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-errors=\"0\""));
  EXPECT_EQ(count(dom, "This plot needs Vega, which was not found"),
            13 + 1);  // once in the script itself
  EXPECT_EQ(count(dom, "data-view-ok=\"canvas\""), 3);
}

}  // namespace
}  // namespace cousin
