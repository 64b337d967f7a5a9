#include "benchmarks/suites/render/leave_out.h"

#include <algorithm>
#include <vector>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/simulate.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

double median_seconds(const Simulation& simulation, const Streams& streams, int measured) {
  simulation.take(0, streams);  // the first also fills caches
  const int views = static_cast<int>(simulation.views().size());
  std::vector<double> seconds;
  for (int i = 0; i < measured; ++i) {
    const StageClock clock("view");
    simulation.take(i * views / measured, streams);
    seconds.push_back(clock.finish().wall_s);
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[seconds.size() / 2];
}

}  // namespace

LeaveOutSeconds measure_leave_out(std::uint64_t seed, int measured) {
  const Simulation matched(seeds_run_config({"rig=d457", "sphere=true"}), seed, 0);
  LeaveOutSeconds result;
  result.views = static_cast<int>(matched.views().size());
  const StageClock first_clock("first");
  matched.take(0, {.color = true});
  const double first_s = first_clock.finish().wall_s;
  result.color_s = median_seconds(matched, {.color = true}, measured);
  result.light_cache_s = std::max(0.0, first_s - result.color_s);
  result.depth_matched_s = median_seconds(matched, {.depth = true}, measured);
  const Simulation model(seeds_run_config({"rig=d457", "sphere=true", "depth_by=model"}), seed, 0);
  result.depth_model_s = median_seconds(model, {.depth = true}, measured);
  return result;
}

}  // namespace cousin
