#pragma once

#include "sim/render/ray_packet.h"

namespace cousin {

/// Gives lanes without a ray one that meets nothing. Processors without AVX-512 have no packet of
/// sixteen in Embree 3.13: there rtcIntersect16 traces all lanes, whatever the mask says, and what
/// was left in them may be no number, which Debian's library asserts against.
template <class Packet>
inline void idle_lanes(const LaneMask& mask, Packet& ray) {
  for (int i = 0; i < kLanes; ++i) {
    if (!mask.lane[i]) set_ray(ray, i, 0, 0, 0, 0, 0, 1, -std::numeric_limits<float>::infinity());
  }
}

}  // namespace cousin
