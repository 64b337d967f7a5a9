#include "benchmarks/stability/splat_cases.h"

#include <gtest/gtest.h>

#include <cmath>

#include "benchmarks/stability/splat_train_cases.h"

namespace cousin {
namespace {

void expect_all_pass(const std::vector<StabilityRow>& rows) {
  for (const StabilityRow& row : rows) {
    EXPECT_TRUE(row.pass) << row.case_name << ": " << row.quantity << " = " << row.value
                          << ", limit " << row.limit;
  }
}

TEST(SplatCases, ExtremeGaussiansHaveFiniteValuesAndTheReferencesGradients) {
  expect_all_pass(splat_cases());
}

TEST(SplatCases, PoorPhotographsAndFilesHaveAStatus) { expect_all_pass(splat_train_cases(true)); }

}  // namespace
}  // namespace cousin
