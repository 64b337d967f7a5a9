#pragma once

#include <string>
#include <vector>

#include "benchmarks/seeds/simulate.h"
#include "perception/pipelines/seeds.h"
#include "sim/truth/specimens.h"

namespace cousin {

/// Names of the seams in the order of the flow.
const std::vector<std::string>& seeds_stage_names();

/// Truth passes that the true seams below read.
TruthNeeds truth_stage_needs();

/// Stages that hand over the truth instead of an estimate, in the same form and with the same
/// visibility limits: corners where the board is seen, depth of first surfaces, points of surfaces
/// that some view sees, outlines where nothing else cuts them. `run.truth.images` must hold
/// truth_stage_needs(). The run must outlive the stages.
SeedsStages truth_stages(const SimulatedRun& run, const SeedBoard& board);

/// `base` with the named stages taken from `replacement`. @throws std::invalid_argument for an
/// unknown name.
SeedsStages replace_stages(SeedsStages base, const SeedsStages& replacement,
                           const std::vector<std::string>& names);

}  // namespace cousin
