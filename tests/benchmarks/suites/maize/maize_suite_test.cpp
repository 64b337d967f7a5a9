#include "benchmarks/suites/maize/maize_suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "benchmarks/loop/keypoint_noise_config.h"
#include "benchmarks/suites/maize/maize_rows.h"

namespace cousin {
namespace {

TEST(MaizeSuite, HasACaptureOfEachStageAndOfEachSpecialCase) {
  const std::vector<ShardJob> quick = maize_suite_jobs({.quick = true});
  ASSERT_EQ(quick.size(), 3U);
  EXPECT_EQ(quick.front().name, "quick_V6.json");
  const std::vector<ShardJob> full = maize_suite_jobs({});
  EXPECT_EQ(full.size(), 4U * 3U + 2U * 4U);
  EXPECT_EQ(full.front().name, "V6_run0.json");
  EXPECT_EQ(full.back().name, "wind_apart_run1.json");
  std::set<std::string> keys;
  for (const ShardJob& job : full) keys.insert(job.key);
  EXPECT_EQ(keys.size(), full.size());
}

TEST(MaizeSuite, CasesOfErrorsAreKeysThatThereAre) {
  std::set<std::string> names;
  for (const NodeErrorCase& node_case : node_error_cases()) {
    EXPECT_TRUE(names.insert(node_case.name).second) << node_case.name;
    KeypointNoiseConfig noise;
    for (const std::string& set : node_case.sets) EXPECT_NO_THROW(set_field(fields(noise), set));
    EXPECT_NO_THROW(validate(noise));
  }
}

/// 40 internodes of four plants that err by `error_m`, one up, the next down.
void add_internodes(const std::string& method, double error_m, double sigma_m,
                    std::vector<SpecimenRow>& rows) {
  for (int i = 0; i < 40; ++i) {
    SpecimenRow row;
    row.dataset = "own_1px";
    row.scene = "plants";
    row.run = "run" + std::to_string(i / 10);
    row.frame = 0;
    row.instance = i;
    row.method = method;
    row.trait = "internode";
    row.unit = "m";
    row.truth = i < 38 ? 0.05 + 0.001 * i : 0.002;
    row.measured = row.truth + (i % 2 == 0 ? error_m : -error_m);
    row.sigma = sigma_m;
    rows.push_back(row);
  }
}

TEST(MaizeSuite, RowsAreOfLongInternodesAndAreHeldToTheirLimits) {
  std::vector<SpecimenRow> specimens;
  add_internodes("paper", 0.003, std::numeric_limits<double>::quiet_NaN(), specimens);
  add_internodes("triangulation", 0.0025, 0.002, specimens);
  add_internodes("ours", 0.001, 0.001, specimens);
  std::vector<ScoreRow> rows = maize_pooled_rows(specimens, 1);
  hold_maize_to_limits(rows);
  const auto row_of = [&](const std::string& method, const std::string& metric) {
    for (const ScoreRow& row : rows) {
      if (row.method == method && row.metric == metric) return row;
    }
    ADD_FAILURE() << method << " " << metric;
    return ScoreRow{};
  };
  EXPECT_EQ(row_of("ours", "internode.solved").n, 38);
  EXPECT_NEAR(row_of("ours", "internode.median_error").value, 0.001, 1e-9);
  EXPECT_EQ(row_of("ours", "internode.median_error").status, ScoreStatus::pass);
  EXPECT_EQ(row_of("triangulation", "internode.median_error").status, ScoreStatus::fail);
  EXPECT_NEAR(row_of("ours/paper", "internode.rmse_ratio").value, 1.0 / 3, 1e-9);
  EXPECT_NEAR(row_of("ours", "internode.width_over_rmse").value, 2 * 1.959963985, 1e-6);
  EXPECT_EQ(row_of("ours", "internode.width_over_rmse").status, ScoreStatus::pass);
  // All within one sigma: intervals hold more than they say.
  EXPECT_EQ(row_of("ours", "internode.coverage_95").status, ScoreStatus::fail);
}

}  // namespace
}  // namespace cousin
