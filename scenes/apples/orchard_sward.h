#pragma once

#include <cstdint>

#include "scenes/apples/orchard.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

/// Private to scenes/apples: where the orchard's floor lies and what grows there.
struct OrchardFloor {
  const OrchardConfig& config;
  std::uint64_t key = 0;  ///< of its relief

  /// 0 on the bare strips below the rows, 1 in the alleys.
  double alley(double x_m, double y_m) const;
  double height_m(double x_m, double y_m) const;
};

/// Patches of mown sward in the alleys: grass, some dry, clover in places; coarse ones beyond
/// ground.reach_m. Weeds' rosettes on the strips' edges.
void add_sward(Scene& scene, const OrchardFloor& floor, const Rng& rng);

}  // namespace cousin
