#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Of the first row of that metric; fails and is NaN where there is none.
inline double value_of(const std::vector<ScoreRow>& rows, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.metric == metric) return row.value;
  }
  ADD_FAILURE() << "no row " << metric;
  return ScoreRow::kNone;
}

}  // namespace cousin
