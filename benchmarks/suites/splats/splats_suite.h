#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "benchmarks/study/shard.h"

namespace cousin {

struct SplatsSuiteConfig {
  /// A folder with transforms.json, points.ply and split.txt (a line "FILE train" or "FILE test"
  /// for each view); absent gives rows with status not_solved.
  std::filesystem::path photographs;
  std::filesystem::path
      fox;  ///< a transforms.json, every eighth view of which is held out; likewise
  std::filesystem::path chair;  ///< photographs without poses and the camera's intrinsics; likewise
  std::uint64_t seed = 1;
  bool quick = false;  ///< without the long training, the fox and the chair
};

/// Gaussian splatting in four jobs: `kernels`, core time of each blended pair, wall time of a
/// training step and core time of a radiance field's sample; `training`, held-out PSNR against wall
/// time on a set of posed photographs; `choices`, the same without one technique each; `fields`,
/// beside Instant-NGP there, on the fox and on the chair. Limits are in the metrics' names; those
/// of time hold on two quiet cores.
std::vector<ShardJob> splats_jobs(const SplatsSuiteConfig& config);

}  // namespace cousin
