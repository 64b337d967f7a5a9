#pragma once

#include <cstdint>
#include <string>

#include "benchmarks/score/scores.h"

namespace cousin {

/// What the rows of one sensor have in common.
struct SensorRows {
  std::string sensor;  ///< name of the preset
  std::uint64_t seed = 0;
};

inline ScoreRow sensor_row(const SensorRows& of, const std::string& case_name,
                           const std::string& metric, double value, const std::string& unit,
                           std::int64_t n) {
  ScoreRow row;
  row.suite = "sensors";
  row.scene = of.sensor;
  row.case_name = of.sensor + ", " + case_name;
  row.method = "ours";
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  row.seed = of.seed;
  return row;
}

}  // namespace cousin
