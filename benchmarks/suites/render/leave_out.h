#pragma once

#include <cstdint>

namespace cousin {

/// What a rig's passes cost, and so what leaving them out of a run saves: a D457 before the seeds'
/// setting, all in one process. Wall seconds; the scene itself is needed either way.
struct LeaveOutSeconds {
  int views = 0;               ///< of the scene, over which the light cache is shared
  double light_cache_s = 0;    ///< once
  double color_s = 0;          ///< a view: radiance and camera
  double depth_matched_s = 0;  ///< a view: infrared pair, matching
  double depth_model_s = 0;    ///< a view
  /// A whole capture of depth alone, and of depth and colour.
  double depth_only_s() const { return views * depth_matched_s; }
  double everything_s() const { return light_cache_s + views * (color_s + depth_matched_s); }
};
/// @param measured  views that are timed, after one that warms up.
LeaveOutSeconds measure_leave_out(std::uint64_t seed, int measured);

}  // namespace cousin
