// A small run that measures its seeds, and the page it writes, in a real browser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "tests/app/program.h"
#include "tests/report/browser.h"

namespace cousin {
namespace {

using testing::HasSubstr;

TEST(AppMeasuredRun, ItsPageShowsPicturesCloudScatterPlotsCommandsAndConfiguration) {
  if (!has_chromium()) {
    GTEST_SKIP() << "Chromium is not installed (Debian package chromium): the page is not tested";
  }
  const Program program;
  const Outcome run = program.run(Words{"run", "seeds", "--out", "r", "--set", "seeds=2"} +
                                  measured_scene() + quick_pipeline());
  ASSERT_EQ(run.code, 0) << run.err;
  ASSERT_EQ(count(read_file(program.path("r/specimens.csv")), ",ok\n"), 10);  // two of five traits

  const std::string html = read_file(program.path("r/report.html"));
  const std::string page = shown_document(html, kWithWebgl);
  // An image that does not decode is an error of the page.
  EXPECT_THAT(root_tag(page), HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(page), HasSubstr("data-errors=\"0\""));
  // A scatter plot and a histogram a trait, and the seconds of each stage.
  EXPECT_EQ(count(html, "class=\"plot\" data-spec="), 11);
  EXPECT_EQ(count(page, "data-plot-ok=\"true\""), 11);
  EXPECT_EQ(count(page, "data-plot-ok=\"false\""), 0);
  EXPECT_EQ(count(page, "data-warnings"), 0);
  EXPECT_EQ(count(html, "class=\"shape\" data-shape="), 3);
  EXPECT_EQ(count(page, "data-view-ok=\"webgl\"") + count(page, "data-view-ok=\"canvas\""), 3);

  for (const char* heading :
       {"Images", "Shapes to turn", "Measured against true", "Distribution of errors", "Run time",
        "Scores", "How this was made"}) {
    EXPECT_EQ(count(page, ">" + std::string(heading) + "</h2>"), 1) << heading;
  }
  for (const char* shape : {"Cloud", "Measured surfaces", "True surfaces"}) {
    EXPECT_EQ(count(page, "<h3>" + std::string(shape) + "</h3>"), 1) << shape;
  }
  for (const char* trait : {"length", "width", "height", "area", "volume"}) {
    EXPECT_EQ(count(page, "<h3>" + std::string(trait) + "</h3>"), 2) << trait;
  }
  EXPECT_THAT(page, testing::ContainsRegex("Points of the multi-view stereo: [0-9]+\\. Shown: "));
  // Three views and the outlines found in two of them.
  EXPECT_EQ(count(page, "<figure><img alt=\"View "), 3);
  EXPECT_EQ(count(page, "<figure><img alt=\"Outlines found in view "), 2);
  EXPECT_THAT(page, HasSubstr("<pre>cousin run seeds --out r --set seeds=2 --set views=18"));
  EXPECT_THAT(page, HasSubstr("\nviews = 18"));
  EXPECT_THAT(page, HasSubstr("\nstep_px = 1.5"));
}

}  // namespace
}  // namespace cousin
