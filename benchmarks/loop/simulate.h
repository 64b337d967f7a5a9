#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "sim/dataset/truth_io.h"
#include "sim/render/truth_pass.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// Called as work goes on: what is being done, steps finished, steps in all.
using Progress = std::function<void(const std::string& what, int done, int total)>;

/// One scene of the virtual world, ready to be photographed. Where something moves, each frame has
/// rays over its own exposures. A frame is a pure function of (configuration, seed, scene index,
/// frame index): any subset may be rendered, in any order.
class Simulation {
 public:
  /// Builds the scene, lets it settle, draws the rig's unit. What the light needs is computed on
  /// the first photograph.
  Simulation(const RunConfig& config, std::uint64_t seed, int scene_index);
  ~Simulation();
  Simulation(Simulation&&) noexcept;

  const Scene& scene() const;
  const RayScene& rays() const;  ///< of the scene at rest
  const RigCapture& rig() const;
  const std::vector<TrueView>& views() const;  ///< of the rig's first sensor

  /// Linear radiance of one view of a still scene, before the sensor, by the renderer that the
  /// configuration names. `repeat` draws other Monte-Carlo samples of the same view and of the
  /// light cache, to measure the renderer's own noise.
  Image<Rgbf> radiance(int frame, std::uint64_t repeat = 0) const;
  /// What the rig hands over for one view, of the streams asked for, and what is true of its depth.
  /// @param repeat  another number: the same with other noise of the colour
  /// @param light_time  where there is one, adds the seconds of the renderer
  RigFrame take(int frame, const Streams& streams, std::uint64_t repeat = 0,
                StageTiming* light_time = nullptr) const;
  /// What a sensor sees. The depth sensor's truth comes with take().
  TruthImages truth(int frame, const TruthNeeds& needs, std::size_t sensor = 0) const;

  /// The capture without frames: rig, pipeline, board.
  Capture capture_header() const;
  /// Truth without images.
  SceneTruth scene_truth() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The scene that a run builds, before any photograph.
Scene built_scene(const RunConfig& config, std::uint64_t seed, int scene_index);

/// What a sensor of the rig sees in one frame, of what is asked for; flow, disparity and leaf areas
/// are of the first sensor alone, the depth sensor's truth comes with RigCapture::take.
TruthImages true_images(const RayScene& rays, const Scene& scene, const RigCapture& rig, int frame,
                        const TruthNeeds& needs, std::size_t sensor = 0);

/// Places in the rig of the cameras beside the first that `streams` hold pictures of: truth is of
/// what they see, too. None if `needs` asks for nothing that is of them.
std::vector<std::size_t> other_true_sensors(const RigCapture& rig, const Streams& streams,
                                            const TruthNeeds& needs);
/// What these see in all frames, into `truth.other_sensors`.
void add_other_sensors(const std::vector<std::size_t>& sensors, const Simulation& simulation,
                       const TruthNeeds& needs, SceneTruth& truth);

/// All frames of a scene and the truth that `needs` asks for, in memory, with the seconds of each
/// pass. Streams are those of planned_streams().
struct SimulatedRun {
  Capture capture;
  SceneTruth truth;
  std::vector<std::string> categories;  ///< of boxes, id 1 first
  std::vector<StageTiming> timings;
  StageTiming radiance;  ///< part of `render`: "radiance_by_cached" or "radiance_by_paths"
};
SimulatedRun simulate(const RunConfig& config, std::uint64_t seed, int scene_index,
                      const TruthNeeds& needs, const Progress& progress = {});

}  // namespace cousin
