#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/suites/light/image_error.h"
#include "benchmarks/suites/light/leafy_scene.h"
#include "benchmarks/suites/light/light_suite.h"
#include "sim/render/cycles/cycles.h"
#include "sim/render/path_tracer.h"

namespace cousin {

struct LeafyScene {
  explicit LeafyScene(const LightConfig& config);
  Scene scene;
  TrueView view;
  RayScene rays;
  PathTracer tracer;
};

/// One setting of one renderer: two images of independent draws and the seconds of one.
struct LeafyRun {
  std::string setting;  ///< "64 samples", "adaptive, 64 samples", "adaptive, threshold 0.02"
  bool is_adaptive = false;
  Image<Rgbf> images[2];
  double seconds = 0;
};

using Say = std::function<void(const std::string& what)>;

std::vector<LeafyRun> our_runs(const LeafyScene& leafy, const LightConfig& config, const Say& say);

struct CyclesRuns {
  std::vector<LeafyRun> runs;
  CyclesImage geometry;    ///< at pixel centres
  Image<Rgbf> one_sample;  ///< tells whether scene or program have changed
};
CyclesRuns cycles_runs(const LeafyScene& leafy, const LightConfig& config);

/// Converged images of each renderer, from references/ or rendered; none below two passes.
std::optional<Reference> our_reference(const LeafyScene& leafy, const LightConfig& config,
                                       const Say& say);
std::optional<Reference> cycles_reference(const LeafyScene& leafy, const LightConfig& config,
                                          const Image<Rgbf>& one_sample, const Say& say);

}  // namespace cousin
