#include "benchmarks/suites/calibration/calibration_row.h"

#include <cstdio>

namespace cousin {

ScoreRow calibration_row(const std::string& scene, const std::string& case_name,
                         const std::string& method, std::uint64_t seed) {
  ScoreRow row;
  row.suite = "calibration";
  row.scene = scene;
  row.case_name = case_name;
  row.method = method;
  row.seed = seed;
  row.unit = "1";
  row.n = 1;
  return row;
}

ScoreRow at_most(ScoreRow row, const std::string& metric, const std::string& unit, double value,
                 double limit) {
  char text[32];
  std::snprintf(text, sizeof text, " (at most %g)", limit);
  row.metric = metric + text;
  row.unit = unit;
  row.value = value;
  return limited(row, at_most(limit));
}

ScoreRow not_built(ScoreRow row, const std::string& reason) {
  row.metric = reason;
  row.status = ScoreStatus::not_built;
  return row;
}

CornerViewsConfig close_views() {
  CornerViewsConfig config;
  config.near_m = 0.2;
  config.far_m = 0.45;
  return config;
}

}  // namespace cousin
