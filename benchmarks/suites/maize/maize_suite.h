#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/study/shard.h"

namespace cousin {

struct MaizeSuiteConfig {
  std::uint64_t seed = 1;
  bool quick = false;
  int runs = 0;  ///< captures of each stage; 0 = 4
  std::vector<std::string> sets;
};

/// How a detector errs in a case of the suite, and how often its errors are drawn anew on the same
/// capture.
struct NodeErrorCase {
  std::string name;
  std::vector<std::string> sets;  ///< keys of KeypointNoiseConfig
  bool has_height = false;        ///< the plant's height is measured too, for the first draw
};
/// truth, own_1px, both_1px, own_6px, both_6px, gross (mean error of 6 px as the paper's, of one
/// point in eight that is far beside), detector (gross, and the paper's precision and recall).
const std::vector<NodeErrorCase>& node_error_cases();

/// Captures of single plants from V6 to V8 before a ZED (0.6 to 1.2 m, HD720), of a row of plants,
/// of plants in wind whose exposures are apart, and with a calibration that is exact; on each every
/// case of errors, and methods paper, triangulation, ours, and stem (ours without the images).
std::vector<ShardJob> maize_suite_jobs(const MaizeSuiteConfig& config);

}  // namespace cousin
