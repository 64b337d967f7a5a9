#include "benchmarks/suites/stability/truth_throughput.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/render/ray_query.h"
#include "sim/render/truth_pass.h"

namespace cousin {
namespace {

template <class Function>
double seconds_of(const Function& function) {
  const auto begin = std::chrono::steady_clock::now();
  function();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

TruthThroughput measure_truth_throughput(const RayScene& rays, const Scene& scene,
                                         const TrueView& view, int repeats) {
  if (repeats < 1)
    throw std::invalid_argument("truth throughput: repeats = " + std::to_string(repeats));
  const PreparedRays prepared = prepare_rays(rays, view);
  const TruthNeeds needs{.depth = true, .normal = true, .instance = true};
  std::int64_t hits = 0;
  std::size_t pixels = 0;
  std::vector<double> raw_s, truth_s;
  for (int i = -1; i < repeats; ++i) {
    const double raw = seconds_of([&] { hits += cast_packets(rays, prepared); });
    const double truth = seconds_of(
        [&] { pixels += render_truth(rays, scene, view, prepared, needs).instance.size(); });
    if (i < 0) continue;
    raw_s.push_back(raw);
    truth_s.push_back(truth);
  }
  if (hits < 0 || pixels == 0) throw std::logic_error("truth throughput: nothing was cast");
  const double count = static_cast<double>(prepared.width) * prepared.height;
  TruthThroughput result;
  result.raw_rays_per_s = count / median(raw_s);
  result.truth_rays_per_s = count / median(truth_s);
  result.share = result.truth_rays_per_s / result.raw_rays_per_s;
  return result;
}

}  // namespace cousin
