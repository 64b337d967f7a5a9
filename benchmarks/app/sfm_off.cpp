// In place of perception/sfm in the first part of the program.
#include "benchmarks/app/parts.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/types/not_built.h"

namespace cousin {

void require_sfm() { throw NotBuilt("poses by COLMAP are " + how_to_build(kScenesPart.name)); }

SfmEstimate estimate_poses_sfm(const Capture& /*capture*/, const SfmConfig& /*config*/) {
  require_sfm();
  return {};
}

SfmEstimate estimate_poses_sfm(const Capture& /*capture*/, const Corners& /*corners*/,
                               const SeedBoard& /*board*/, const SfmConfig& /*config*/) {
  require_sfm();
  return {};
}

}  // namespace cousin
