#pragma once

#include <vector>

#include "benchmarks/loop/plan.h"

namespace cousin {

/// The simulator's passes alone: what a reader of the images makes it render; null: nobody reads
/// them yet, as in a dataset.
std::vector<PlanEntry> simulator_plan(const SeedsRunConfig& config, const StreamReader* reader);

}  // namespace cousin
