#include "perception/splats/splat_train_state.h"

#include <cmath>

namespace cousin {

SplatTrainState start_training(const SplatModel& start) {
  SplatTrainState state;
  state.origin_in_world_m = start.origin_in_world_m;
  const SplatPlanes all = to_planes(start.splats);
  std::vector<int> finite;
  for (int i = 0; i < all.size(); ++i) {
    bool good = true;
    for (int k = 0; k < SplatPlane::count; ++k) good = good && std::isfinite(all.at(k, i));
    if (good) finite.push_back(i);
  }
  state.values = all;
  state.first_moment = SplatPlanes(SplatPlane::count, all.size());
  state.second_moment = state.first_moment;
  gather(state, finite);
  state.started_with = state.values.size();
  return state;
}

void gather(SplatTrainState& state, const std::vector<int>& source) {
  std::vector<int> values = source, moments = source;
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (source[i] >= 0) continue;
    values[i] = -1 - source[i];
    moments[i] = -1;
  }
  state.values = state.values.gathered(values);
  state.first_moment = state.first_moment.gathered(moments);
  state.second_moment = state.second_moment.gathered(moments);
  state.gradient_sum.assign(static_cast<std::size_t>(state.values.padded()), 0);
  state.gradient_count.assign(static_cast<std::size_t>(state.values.padded()), 0);
}

}  // namespace cousin
