#include "benchmarks/loop/plant_simulation.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <utility>

#include "benchmarks/loop/simulate.h"
#include "sim/render/view_match.h"

namespace cousin {

namespace {

Rng rig_rng(std::uint64_t seed, int index) {
  return Rng(seed).fork("scene").fork(static_cast<std::uint64_t>(index));
}

/// From the first row's begin to the last row's end, of all sensors.
TimeSpan span_of(const RigCapture& rig, int frame) {
  const auto i = static_cast<std::size_t>(frame);
  const double start_s = rig.views().front().views.at(i).time_s;
  constexpr double kInfrared_s = 0.05;  // exposures that views do not tell
  TimeSpan span{start_s, start_s};
  for (const SensorViews& sensor : rig.views()) {
    const TrueView& view = sensor.views.at(i);
    span.begin_s = std::min(span.begin_s, view.time_s - 0.5 * view.exposure_s);
    span.end_s =
        std::max(span.end_s, view.time_s + view.readout_s + 0.5 * view.exposure_s + kInfrared_s);
  }
  return span;
}

/// Drops what no frame sees of the motion of organs, of which there are many: between frames motion
/// means nothing.
void keep_seen_motion(Scene& scene, const std::vector<TimeSpan>& spans) {
  for (Instance& instance : scene.instances) {
    if (instance.part_of < 0) continue;
    const std::vector<TimedPose>& all = instance.motion;
    std::vector<TimedPose> seen;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double before_s = all[i > 0 ? i - 1 : i].time_s;
      const double after_s = all[std::min(i + 1, all.size() - 1)].time_s;
      const bool is_seen = std::any_of(spans.begin(), spans.end(), [&](const TimeSpan& span) {
        return after_s >= span.begin_s && before_s <= span.end_s;
      });
      if (is_seen) seen.push_back(all[i]);
    }
    instance.motion = std::move(seen);
  }
}

/// The scene during one frame, where something moves.
struct Moment {
  RayScene rays;
  RigCapture rig;

  Moment(const PlantRunConfig& config, const Scene& scene, const TimeSpan& span, const Rng& rng)
      : rays(scene, span), rig(config.rig, config.capture, rays, scene, rng) {}
};

}  // namespace

struct PlantSimulation::Impl {
  PlantRunConfig asked;
  PlantCousin cousin;
  const PlantRunConfig& config;  ///< of this scene
  std::uint64_t seed;
  int index;
  Scene scene;
  RayScene rays;
  RigCapture rig;
  mutable std::once_flag tracer_once;
  mutable std::optional<PathTracer> tracer;  ///< made on the first photograph, if nothing moves

  Impl(const PlantRunConfig& run_config, std::uint64_t run_seed, int scene_index)
      : asked(run_config),
        cousin(cousin_of(run_config, run_seed, scene_index)),
        config(cousin.config),
        seed(run_seed),
        index(scene_index),
        scene(build_scene(seen_by(config.scene, config.rig), seed, index)),
        rays(scene),
        rig(config.rig, config.capture, rays, scene, rig_rng(seed, index)) {}

  bool moves() const {
    return std::any_of(scene.instances.begin(), scene.instances.end(),
                       [](const Instance& instance) { return !instance.motion.empty(); });
  }
  Moment moment(int frame) const {
    return {config, scene, span_of(rig, frame), rig_rng(seed, index)};
  }

  /// Where the next view sees what this one does. Each has rays of its own time: one span over both
  /// would take the motion between them in coarse steps.
  TruthImages with_flow(const Moment& now, int frame, const TruthNeeds& needs) const {
    const std::vector<TrueView>& all = rig.views().front().views;
    const auto i = static_cast<std::size_t>(frame);
    const bool flows = needs.flow && i + 1 < all.size();
    TruthNeeds own = needs;
    own.flow = false;
    own.depth |= flows;
    own.instance |= flows;
    TruthImages truth = true_images(now.rays, scene, now.rig, frame, own);
    if (!flows) return truth;
    const Moment next = moment(frame + 1);
    truth.flow = match_views(scene, {now.rays, all[i]}, truth.depth_m, truth.instance,
                             {next.rays, all[i + 1]});
    if (!needs.depth) truth.depth_m = {};
    if (!needs.instance) truth.instance = {};
    return truth;
  }

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
  if (impl->moves()) {
    const Moment moment = impl->moment(frame);
    const PathTracer tracer(moment.rays, impl->scene);
    return moment.rig.take(frame, streams, [&](const TrueView& view, const Rng& rng) {
      return tracer.render(view, impl->config.render, rng).radiance;
    });
  }
  return impl_->rig.take(frame, streams, [impl](const TrueView& view, const Rng& rng) {
    return impl->path_tracer().render(view, impl->config.render, rng).radiance;
  });
}

TruthImages PlantSimulation::truth(int frame, const TruthNeeds& needs, std::size_t sensor) const {
  if (impl_->moves()) {
    const Moment moment = impl_->moment(frame);
    if (sensor > 0) return true_images(moment.rays, scene(), moment.rig, frame, needs, sensor);
    return impl_->with_flow(moment, frame, needs);
  }
  return true_images(impl_->rays, impl_->scene, impl_->rig, frame, needs, sensor);
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
  truth.config_toml = resolved_toml(impl_->asked) + comments_of(impl_->cousin.changes);
  truth.scene = impl_->scene;
  std::vector<TimeSpan> spans;
  for (std::size_t i = 0; i < views().size(); ++i)
    spans.push_back(span_of(impl_->rig, static_cast<int>(i)));
  keep_seen_motion(truth.scene, spans);
  truth.shared_plants = shared_plants(impl_->config.scene, impl_->index);
  truth.views = views();
  truth.other_sensors.assign(impl_->rig.views().begin() + 1, impl_->rig.views().end());
  return truth;
}

}  // namespace cousin
