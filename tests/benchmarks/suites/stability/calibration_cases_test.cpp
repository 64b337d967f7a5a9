#include "benchmarks/suites/stability/calibration_cases.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

TEST(CalibrationCases, WhatViewsDoNotDetermineIsSaidSo) {
  for (const StabilityRow& row : calibration_cases()) {
    if (std::isnan(row.limit)) continue;  // shown only, or not built in
    EXPECT_TRUE(row.pass) << row.case_name << ": " << row.quantity << " = " << row.value
                          << ", limit " << row.limit;
  }
}

}  // namespace
}  // namespace cousin
