#include "benchmarks/suites/light/light_suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "benchmarks/suites/light/light_page.h"
#include "sim/render/cycles/cycles.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// Small enough for a test: 64 x 48 pixels, few samples.
LightConfig small(const fs::path& folder) {
  LightConfig config;
  config.folder = folder;
  config.width_px = 64;
  config.height_px = 48;
  config.samples = {4, 16};
  config.adaptive_samples = {32};
  config.thresholds = {0.05};
  config.most_samples = 64;
  config.reference_passes = 2;
  config.reference_samples = 64;
  config.closed_form_samples = 1 << 13;
  return config;
}

const ScoreRow* row_of(const ScoreFile& file, const std::string& method,
                       const std::string& case_name, const std::string& metric) {
  const auto found = std::find_if(file.scores.begin(), file.scores.end(), [&](const ScoreRow& row) {
    return row.method == method && row.case_name == case_name && row.metric == metric;
  });
  return found == file.scores.end() ? nullptr : &*found;
}

TEST(LightSuite, ReportsErrorsAgainstEachOnesOwnConvergedImage) {
  const fs::path folder = fs::path(testing::TempDir()) / "light_suite";
  fs::remove_all(folder);
  const LightResult result = light_suite(small(folder));
  const auto error = [&](const char* method, const char* setting, const char* metric) {
    const ScoreRow* row = row_of(result.file, method, setting, metric);
    EXPECT_NE(row, nullptr) << method << " " << setting << " " << metric;
    return row ? row->value : std::nan("");
  };
  // Four times the samples: half the error and less, as samples are stratified; 3,072 pixels.
  const double few = error("ours", "4 samples", "relative_error");
  const double many = error("ours", "16 samples", "relative_error");
  EXPECT_GT(few, 1.5 * many);
  EXPECT_NEAR(error("ours", "16 samples", "relative_error.pair"), many, 0.25 * many);
  // Deviations are about 0, with their interval.
  const ScoreRow* form = row_of(result.file, "ours", "Lambert sphere in the sun", "deviation");
  ASSERT_NE(form, nullptr);
  EXPECT_NEAR(form->value, 0, 0.2);
  EXPECT_LT(form->ci_low, form->ci_high);
  if (!has_cycles()) {
    EXPECT_EQ(row_of(result.file, "ours", "beside Cycles", "time_ratio.plain")->status,
              ScoreStatus::not_built);
    return;
  }
  EXPECT_GT(error("cycles", "4 samples", "relative_error"),
            error("cycles", "16 samples", "relative_error"));
  const ScoreRow* mean = row_of(result.file, "ours", "beside Cycles", "mean_radiance_ratio");
  ASSERT_NE(mean, nullptr);
  EXPECT_NEAR(mean->value, 1, 0.02);
  EXPECT_EQ(result.pictures.pictures.size(), 4U);
  // Two curves of two renderers, plain and adaptive.
  const std::vector<ErrorTimeCurve> curves = light_curves(result.file.scores);
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_EQ(curves[0].points.size(), 6U);
  fs::remove_all(folder);
}

TEST(LightPage, RowsOfOtherSuitesMakeNoCurve) {
  ScoreRow row;
  row.suite = "seeds";
  row.metric = "relative_error";
  row.value = row.wall_s = 1;
  EXPECT_TRUE(light_curves({row}).empty());
}

}  // namespace
}  // namespace cousin
