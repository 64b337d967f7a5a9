#pragma once

#include "sim/render/ray_scene.h"
#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// The truth pass (depth, normal, ids; one sample; rays prepared; no files) beside Embree's packets
/// alone, on the same rays in the same run.
struct TruthThroughput {
  double raw_rays_per_s = 0;
  double truth_rays_per_s = 0;
  double share = 0;  ///< truth / raw; the medians of both over the repeats
};

/// Casts `view` alternately both ways, `repeats` times each after one unmeasured round.
TruthThroughput measure_truth_throughput(const RayScene& rays, const Scene& scene,
                                         const TrueView& view, int repeats = 21);

}  // namespace cousin
