#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/metrics/scores.h"

namespace cousin {

/// A row of the suite "real".
ScoreRow real_row(const std::string& scene, const std::string& case_name, const std::string& method,
                  const std::string& metric, double value, const std::string& unit, std::int64_t n);

/// A row that says what could not be done, and why, in its metric.
ScoreRow not_solved_row(const std::string& scene, const std::string& case_name,
                        const std::string& why);

}  // namespace cousin
