#include "benchmarks/scenes/plant_simulation.h"

#include <mutex>
#include <optional>
#include <utility>

#include "benchmarks/seeds/simulate.h"

namespace cousin {

struct PlantSimulation::Impl {
  PlantRunConfig config;
  std::uint64_t seed;
  int scene_index;
  Scene scene;
  RayScene rays;
  RigCapture rig;
  mutable std::once_flag tracer_once;
  mutable std::optional<PathTracer> tracer;  ///< made on the first photograph

  Impl(const PlantRunConfig& run_config, std::uint64_t run_seed, int index)
      : config(run_config),
        seed(run_seed),
        scene_index(index),
        scene(build_scene(config.scene, seed, index)),
        rays(scene),
        rig(config.rig, config.capture, rays, scene,
            Rng(seed).fork("scene").fork(static_cast<std::uint64_t>(index))) {}

  const PathTracer& path_tracer() const {
    std::call_once(tracer_once, [&] { tracer.emplace(rays, scene); });
    return *tracer;
  }
};

PlantSimulation::PlantSimulation(const PlantRunConfig& config, std::uint64_t seed, int scene_index)
    : impl_(std::make_unique<Impl>(config, seed, scene_index)) {}
PlantSimulation::~PlantSimulation() = default;
PlantSimulation::PlantSimulation(PlantSimulation&&) noexcept = default;

const Scene& PlantSimulation::scene() const { return impl_->scene; }
const std::vector<TrueView>& PlantSimulation::views() const {
  return impl_->rig.views().front().views;
}
const RigCapture& PlantSimulation::rig() const { return impl_->rig; }

RigFrame PlantSimulation::take(int frame, const Streams& streams) const {
  const Impl* impl = impl_.get();
  return impl_->rig.take(frame, streams, [impl](const TrueView& view, const Rng& rng) {
    return impl->path_tracer().render(view, impl->config.render, rng).radiance;
  });
}

TruthImages PlantSimulation::truth(int frame, const TruthNeeds& needs) const {
  return true_images(impl_->rays, impl_->scene, impl_->rig, frame, needs);
}

Capture PlantSimulation::capture_header() const {
  Capture capture;
  capture.pipeline = impl_->scene.name;
  capture.board = impl_->scene.board;
  capture.rig = impl_->rig.reports();
  return capture;
}

SceneTruth PlantSimulation::scene_truth() const {
  SceneTruth truth;
  truth.seed = impl_->seed;
  truth.config_toml = resolved_toml(impl_->config);
  truth.scene = impl_->scene;
  truth.shared_plants = shared_plants(impl_->config.scene, impl_->scene_index);
  truth.views = views();
  truth.other_sensors.assign(impl_->rig.views().begin() + 1, impl_->rig.views().end());
  return truth;
}

}  // namespace cousin
