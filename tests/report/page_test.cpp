// The page in a real browser: headless Chromium prints the document after its scripts have run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "benchmarks/report/report.h"
#include "example_report.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// A folder of its own, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (fs::temp_directory_path() / "report_test_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make " + pattern);
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// The document after its scripts have run; empty if the browser could not start.
std::string dump_dom(const std::string& html, const std::string& more_flags) {
  const TemporaryFolder folder;
  const fs::path page = folder.path() / "report.html";
  std::ofstream(page, std::ios::binary) << html;
  const std::string command =
      std::string(COUSIN_CHROMIUM) +
      " --headless --no-sandbox --disable-quic --no-first-run --disable-background-networking"
      " --disable-component-update --disable-sync --hide-scrollbars --window-size=1280,1000 "
      "--virtual-time-budget=30000" +
      more_flags + " --user-data-dir='" + (folder.path() / "profile").string() +
      "' --dump-dom 'file://" + page.string() + "' 2>/dev/null";
  std::string dom;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return dom;
  std::array<char, 65536> buffer{};
  for (std::size_t n; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    dom.append(buffer.data(), n);
  pclose(pipe);
  return dom;
}

/// The root element's tag, which carries what the page says of itself.
std::string root_tag(const std::string& dom) {
  const std::size_t begin = dom.find("<html");
  return begin == std::string::npos ? "" : dom.substr(begin, dom.find('>', begin) - begin + 1);
}

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++found;
  return found;
}

class Page : public testing::Test {
 protected:
  void SetUp() override {
    if (std::string(COUSIN_CHROMIUM).empty() || !fs::exists(COUSIN_CHROMIUM)) {
      GTEST_SKIP() << "Chromium is not installed (Debian package chromium): the page is not tested";
    }
  }
};

TEST_F(Page, LoadsWithoutErrorsAndDrawsEveryPlotAndShape) {
  const std::string dom = dump_dom(make_report(example_report()),
                                   " --use-angle=swiftshader --enable-unsafe-swiftshader");
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-errors=\"0\""));
  // Four scatter plots, four histograms, one distribution, one curve, one waterfall, one timing
  // plot.
  EXPECT_EQ(count(dom, "data-plot-ok=\"true\""), 12);
  EXPECT_EQ(count(dom, "data-plot-ok=\"false\""), 0);
  EXPECT_EQ(count(dom, "data-warnings"), 0);
  EXPECT_EQ(count(dom, "data-view-ok=\"webgl\"") + count(dom, "data-view-ok=\"canvas\""), 2);
}

TEST_F(Page, PaintsShapesOnACanvasWithoutWebgl) {
  const std::string dom =
      dump_dom(make_report(example_report()), " --disable-gpu --disable-3d-apis");
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-errors=\"0\""));
  EXPECT_EQ(count(dom, "data-view-ok=\"canvas\""), 2);
}

TEST_F(Page, StandsWithoutTheLibraries) {
  const std::string dom =
      dump_dom(make_report(example_report(), {.javascript = "/nonexistent"}), " --disable-gpu");
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-ready=\"true\""));
  EXPECT_THAT(root_tag(dom), testing::HasSubstr("data-errors=\"0\""));
  EXPECT_EQ(count(dom, "This plot needs Vega, which was not found"),
            12 + 1);  // once in the script itself
  EXPECT_EQ(count(dom, "data-view-ok=\"canvas\""), 2);
}

}  // namespace
}  // namespace cousin
