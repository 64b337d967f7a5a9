#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks/loop/plant_run.h"
#include "sim/dataset/truth_io.h"
#include "sim/types/capture.h"

namespace cousin {

/// One scene of plants, ready to be photographed: as SeedsSimulation, with light by the path
/// tracer. Where plants move, each frame has rays over its own exposures. A frame is a pure
/// function of (configuration, seed, scene index, frame index).
class PlantSimulation {
 public:
  PlantSimulation(const PlantRunConfig& config, std::uint64_t seed, int scene_index);
  ~PlantSimulation();
  PlantSimulation(PlantSimulation&&) noexcept;

  const Scene& scene() const;
  const std::vector<TrueView>& views() const;  ///< of the rig's first sensor
  const RigCapture& rig() const;
  RigFrame take(int frame, const Streams& streams) const;
  TruthImages truth(int frame, const TruthNeeds& needs, std::size_t sensor = 0) const;
  Capture capture_header() const;  ///< the capture without frames
  SceneTruth scene_truth() const;  ///< truth without images

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cousin
