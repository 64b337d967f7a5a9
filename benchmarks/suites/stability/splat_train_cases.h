#pragma once

#include <vector>

#include "benchmarks/suites/stability/stability_row.h"

namespace cousin {

/// Trainings of Gaussians on photographs that teach little, nothing or wrong things, by every kind
/// of growth; and PLY files with rows that are no Gaussian, or with as many as may be read.
/// @param quick  the longest file has 200,000 Gaussians, not 10 M (560 MB of disk, 7 GB of memory)
std::vector<StabilityRow> splat_train_cases(bool quick);

}  // namespace cousin
