#pragma once

#include <string>
#include <vector>

#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"
#include "sim/types/seams.h"

namespace cousin {

/// What one part of the suite gives: numbers, and what the page shows of it.
struct RealPart {
  std::vector<ScoreRow> rows;
  std::vector<ReportImage> images;
  std::vector<ReportShape> shapes;
  std::vector<Distribution> distributions;
};

/// A row of the suite "real".
ScoreRow real_row(const std::string& scene, const std::string& case_name, const std::string& method,
                  const std::string& metric, double value, const std::string& unit, std::int64_t n);

/// A row that says what could not be done, and why, in its metric.
ScoreRow not_solved_row(const std::string& scene, const std::string& case_name,
                        const std::string& why);

/// A cloud for the page, with its colours.
ReportShape cloud_shape(const std::string& name, const std::string& caption, const Cloud& cloud);

}  // namespace cousin
