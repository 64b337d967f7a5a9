// In place of perception/sfm in the first part of the program.
#include <stdexcept>

#include "benchmarks/app/parts.h"
#include "perception/sfm/sfm_poses.h"

namespace cousin {
namespace {

[[noreturn]] void refuse() {
  throw std::invalid_argument("poses by COLMAP are " + how_to_build(kScenesPart.name));
}

}  // namespace

SfmEstimate estimate_poses_sfm(const Capture& /*capture*/, const SfmConfig& /*config*/) {
  refuse();
}

SfmEstimate estimate_poses_sfm(const Capture& /*capture*/, const Corners& /*corners*/,
                               const SeedBoard& /*board*/, const SfmConfig& /*config*/) {
  refuse();
}

}  // namespace cousin
