// In place of command_score_detections.cpp in the first part of the program.
#include "benchmarks/app/commands.h"
#include "benchmarks/app/parts.h"
#include "sim/types/not_built.h"

namespace cousin {

ExitCode command_score_detections(const JobContext& /*context*/) {
  throw NotBuilt("scoring of detections is " + how_to_build(kScenesPart.name));
}

}  // namespace cousin
