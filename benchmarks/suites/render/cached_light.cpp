#include "benchmarks/suites/render/cached_light.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/render/path_tracer.h"

namespace cousin {
namespace {

constexpr int kBlock = 8;

struct Sums {
  std::int64_t blocks = 0;
  double cached = 0, paths = 0;
  double squared_difference = 0, noise = 0;
};

double luminance(const Rgbf& c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; }

/// Name of what a block shows, or empty if it shows several things or none.
std::string category_of_block(const Scene& scene, const Image<std::int32_t>& instance, int x0,
                              int y0) {
  const std::int32_t first = instance(x0, y0);
  for (int y = y0; y < y0 + kBlock; ++y) {
    for (int x = x0; x < x0 + kBlock; ++x) {
      if (instance(x, y) != first) return {};
    }
  }
  for (const Instance& i : scene.instances) {
    if (i.id == first) return i.is_specimen ? "specimens" : i.category;
  }
  return {};
}

}  // namespace

std::vector<CachedLightError> compare_cached_light(const Simulation& simulation, int frame,
                                                   int samples, int max_bounces) {
  const TrueView& view = simulation.views()[static_cast<std::size_t>(frame)];
  const Image<Rgbf> cached = simulation.radiance(frame);
  const PathTracer tracer(simulation.rays(), simulation.scene());
  PathConfig config;
  config.pixel_samples = samples;
  config.max_bounces = max_bounces;
  const PathImage paths = tracer.render(view, config, Rng(11));
  const Image<std::int32_t> instance = simulation.truth(frame, {.instance = true}).instance;
  std::map<std::string, Sums> sums;
  for (int y0 = 0; y0 + kBlock <= cached.height(); y0 += kBlock) {
    for (int x0 = 0; x0 + kBlock <= cached.width(); x0 += kBlock) {
      double mine = 0, theirs = 0, variance = 0;
      for (int y = y0; y < y0 + kBlock; ++y) {
        for (int x = x0; x < x0 + kBlock; ++x) {
          mine += luminance(cached(x, y));
          theirs += luminance(paths.radiance(x, y));
          variance += std::pow(paths.luminance_error(x, y), 2);
        }
      }
      if (!(theirs > 0)) continue;
      const std::string category = category_of_block(simulation.scene(), instance, x0, y0);
      for (const std::string& name : {category, std::string("all")}) {
        if (name.empty()) continue;
        Sums& s = sums[name];
        ++s.blocks;
        s.cached += mine;
        s.paths += theirs;
        s.squared_difference += std::pow((mine - theirs) / theirs, 2);
        s.noise += variance / (theirs * theirs);
      }
    }
  }
  std::vector<CachedLightError> errors;
  for (const auto& [name, s] : sums) {
    const auto n = static_cast<double>(s.blocks);
    errors.push_back({name, s.blocks * kBlock * kBlock, s.cached / s.paths,
                      std::sqrt(std::max(0.0, (s.squared_difference - s.noise) / n))});
  }
  return errors;
}

}  // namespace cousin
