#pragma once

#include <vector>

#include "benchmarks/seeds/plan.h"

namespace cousin {

/// The simulator's passes alone: what a reader of the images makes it render.
std::vector<PlanEntry> simulator_plan(const SeedsRunConfig& config, Reader reader);

}  // namespace cousin
