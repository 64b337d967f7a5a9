#include "benchmarks/loop/simulate.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "benchmarks/loop/rest_folder.h"
#include "benchmarks/loop/rig_sight.h"
#include "sim/dataset/environment_io.h"
#include "sim/render/view_match.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

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

  Moment(const RunConfig& config, const Scene& scene, const TimeSpan& span, const Rng& rng)
      : rays(scene, span), rig(config.rig, config.capture, rays, scene, rng) {}
};

/// What there is of every camera; the rest is of the first, of the whole rig or of all views.
TruthNeeds of_any_sensor(TruthNeeds needs) {
  needs.leaf_area = needs.flow = needs.disparity = false;
  needs.noise_free_depth = needs.invalid_reason = false;
  return needs;
}

std::string light_stage(RadianceBy by) {
  return by == RadianceBy::paths ? "radiance_by_paths" : "radiance_by_cached";
}

void add_time(const StageTiming& timing, StageTiming& sum) {
  sum.wall_s += timing.wall_s;
  sum.cpu_s += timing.cpu_s;
  sum.peak_rss_mb = timing.peak_rss_mb;  // of the process so far
  sum.peak_above_start_mb = timing.peak_above_start_mb;
}

}  // namespace

Scene built_scene(const RunConfig& config, std::uint64_t seed, int scene_index) {
  SceneConfig scene = config.scene;
  see(scene, sight_of(config.rig));
  std::string* const cache = cache_folder(scene);
  std::optional<RestFolder> rests;
  if (cache && !cache->empty()) rests.emplace(*cache);
  return build_scene(scene, {.seed = seed,
                             .index = scene_index,
                             .rests = rests ? &*rests : nullptr,
                             .read_environment = read_environment});
}

struct Simulation::Impl {
  RunConfig asked;
  RunCousin cousin;
  const RunConfig& config;  ///< of this scene
  std::uint64_t seed;
  int index;
  Rng rng;
  Scene scene;
  RayScene rays;
  RigCapture rig;
  mutable std::once_flag tracer_once;
  mutable std::optional<PathTracer> tracer;  ///< made on the first photograph, if nothing moves
  mutable std::mutex cache_mutex;
  mutable std::map<std::uint64_t, IrradianceCache>
      caches;  ///< one for each repeat; nodes stay in place

  Impl(const RunConfig& run_config, std::uint64_t run_seed, int scene_index)
      : asked(run_config),
        cousin(cousin_of(run_config, run_seed, scene_index)),
        config(cousin.config),
        seed(run_seed),
        index(scene_index),
        rng(SceneBuild{.seed = run_seed, .index = scene_index}.rng()),
        scene(built_scene(config, seed, index)),
        rays(scene),
        rig(config.rig, config.capture, rays, scene, rng) {}

  const std::vector<TrueView>& views() const { return rig.views().front().views; }
  bool moves() const {
    return std::any_of(scene.instances.begin(), scene.instances.end(),
                       [](const Instance& instance) { return !instance.motion.empty(); });
  }
  Moment moment(int frame) const { return {config, scene, span_of(rig, frame), rng}; }

  const PathTracer& path_tracer() const {
    std::call_once(tracer_once, [&] { tracer.emplace(rays, scene); });
    return *tracer;
  }
  const IrradianceCache& cache(std::uint64_t repeat) const {
    const std::lock_guard lock(cache_mutex);
    const auto found = caches.find(repeat);
    if (found != caches.end()) return found->second;
    return caches
        .emplace(repeat,
                 IrradianceCache(rays, scene, config.cached, rng.fork("light").fork(repeat)))
        .first->second;
  }

  /// The radiance of one view of the scene at rest.
  Image<Rgbf> light(const TrueView& view, std::uint64_t repeat, const Rng& stream) const {
    if (config.radiance == RadianceBy::paths)
      return path_tracer().render(view, config.paths, stream).radiance;
    return render_radiance(rays, scene, cache(repeat), view, config.cached, stream);
  }

  /// Where the next view sees what this one does. Each has rays of its own time: one span over both
  /// would take the motion between them in coarse steps.
  TruthImages with_flow(const Moment& now, int frame, const TruthNeeds& needs) const {
    const auto i = static_cast<std::size_t>(frame);
    const bool flows = needs.flow && i + 1 < views().size();
    TruthNeeds own = needs;
    own.flow = false;
    own.depth |= flows;
    own.instance |= flows;
    TruthImages truth = true_images(now.rays, scene, now.rig, frame, own);
    if (!flows) return truth;
    const Moment next = moment(frame + 1);
    truth.flow = match_views(scene, {now.rays, views()[i]}, truth.depth_m, truth.instance,
                             {next.rays, views()[i + 1]});
    if (!needs.depth) truth.depth_m = {};
    if (!needs.instance) truth.instance = {};
    return truth;
  }
};

Simulation::Simulation(const RunConfig& config, std::uint64_t seed, int scene_index)
    : impl_(std::make_unique<Impl>(config, seed, scene_index)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

const Scene& Simulation::scene() const { return impl_->scene; }
const RayScene& Simulation::rays() const { return impl_->rays; }
const RigCapture& Simulation::rig() const { return impl_->rig; }
const std::vector<TrueView>& Simulation::views() const { return impl_->views(); }

Image<Rgbf> Simulation::radiance(int frame, std::uint64_t repeat) const {
  const Rng rng = impl_->rng.fork("radiance").fork(repeat).fork(static_cast<std::uint64_t>(frame));
  return impl_->light(impl_->views().at(static_cast<std::size_t>(frame)), repeat, rng);
}

RigFrame Simulation::take(int frame, const Streams& streams, std::uint64_t repeat,
                          StageTiming* light_time) const {
  const Impl* impl = impl_.get();
  const auto timed = [&](const auto& light) {
    if (!light_time) return light();
    const StageClock clock("light");
    Image<Rgbf> image = light();
    add_time(clock.finish(), *light_time);
    return image;
  };
  if (!impl->moves()) {
    return impl->rig.take(
        frame, streams,
        [&](const TrueView& view, const Rng& rng) {
          return timed([&] { return impl->light(view, 0, rng); });
        },
        repeat);
  }
  const Moment moment = impl->moment(frame);
  const PathTracer tracer(moment.rays, impl->scene);
  return moment.rig.take(
      frame, streams,
      [&](const TrueView& view, const Rng& rng) {
        return timed([&] { return tracer.render(view, impl->config.paths, rng).radiance; });
      },
      repeat);
}

TruthImages Simulation::truth(int frame, const TruthNeeds& needs, std::size_t sensor) const {
  if (impl_->moves()) {
    const Moment moment = impl_->moment(frame);
    if (sensor > 0) return true_images(moment.rays, scene(), moment.rig, frame, needs, sensor);
    return impl_->with_flow(moment, frame, needs);
  }
  return true_images(impl_->rays, impl_->scene, impl_->rig, frame, needs, sensor);
}

TruthImages true_images(const RayScene& rays, const Scene& scene, const RigCapture& rig, int frame,
                        const TruthNeeds& needs, std::size_t sensor) {
  if (sensor > 0) {
    const std::vector<TrueView>& own = rig.views().at(sensor).views;
    return render_truth(rays, scene, own.at(static_cast<std::size_t>(frame)), of_any_sensor(needs));
  }
  const std::vector<TrueView>& views = rig.views().front().views;
  const TrueView& view = views.at(static_cast<std::size_t>(frame));
  const auto next = static_cast<std::size_t>(frame) + 1;
  const bool flow = needs.flow && next < views.size();
  TruthNeeds more = needs;
  if (flow) more.depth = more.instance = true;
  TruthImages truth = render_truth(rays, scene, view, more);
  if (flow) {
    truth.flow =
        match_views(scene, {rays, view}, truth.depth_m, truth.instance, {rays, views[next]});
  }
  if (needs.disparity) truth.stereo = rig.disparity(frame);
  if (!needs.depth) truth.depth_m = {};
  if (!needs.instance) truth.instance = {};
  return truth;
}

std::vector<std::size_t> other_true_sensors(const RigCapture& rig, const Streams& streams,
                                            const TruthNeeds& needs) {
  std::vector<std::size_t> sensors;
  if (of_any_sensor(needs) == TruthNeeds{} || rig.views().front().views.empty()) return sensors;
  const Frame pictures = rig.outline(0, {.color = streams.color, .raw = streams.raw});
  for (std::size_t s = 1; s < pictures.sensors.size(); ++s) {
    const SensorFrame& sensor = pictures.sensors[s];
    if (!sensor.color.empty() || !sensor.raw.empty()) sensors.push_back(s);
  }
  return sensors;
}

void add_other_sensors(const std::vector<std::size_t>& sensors, const Simulation& simulation,
                       const TruthNeeds& needs, SceneTruth& truth) {
  for (const std::size_t s : sensors) {
    SensorViews& other = truth.other_sensors.at(s - 1);
    for (const TrueView& view : other.views)
      other.images.push_back(simulation.truth(view.frame, needs, s));
  }
}

Capture Simulation::capture_header() const {
  Capture capture;
  capture.pipeline = impl_->scene.name;
  capture.board = impl_->scene.board;
  capture.rig = impl_->rig.reports();
  return capture;
}

SceneTruth Simulation::scene_truth() const {
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

SimulatedRun simulate(const RunConfig& config, std::uint64_t seed, int scene_index,
                      const TruthNeeds& needs, const Progress& progress) {
  const auto say = [&](const std::string& what, int done, int total) {
    if (progress) progress(what, done, total);
  };
  const Streams streams = planned_streams(config);
  SimulatedRun run;
  run.categories = specimen_categories(config.scene);
  say("scene", 0, 1);
  const StageClock scene_clock("scene");
  const Simulation simulation(config, seed, scene_index);
  run.timings.push_back(scene_clock.finish());

  const int frames = static_cast<int>(simulation.views().size());
  run.capture = simulation.capture_header();
  run.radiance.stage = light_stage(config.radiance);
  std::vector<TruthImages> of_depth;  // what is true of the depth taken
  const StageClock render_clock("render");
  for (int i = 0; i < frames; ++i) {
    say("render", i, frames);
    RigFrame taken = simulation.take(i, streams, 0, &run.radiance);
    run.capture.frames.push_back(std::move(taken.frame));
    TruthImages& own = of_depth.emplace_back();
    if (needs.noise_free_depth) own.noise_free_depth_m = std::move(taken.noise_free_depth_m);
    if (needs.invalid_reason) own.invalid_reason = std::move(taken.invalid_reason);
  }
  run.timings.push_back(render_clock.finish());

  const StageClock truth_clock("truth");
  run.truth = simulation.scene_truth();
  const bool any = needs != TruthNeeds{};
  for (int i = 0; any && i < frames; ++i) {
    say("truth", i, frames);
    TruthImages& images = run.truth.images.emplace_back(simulation.truth(i, needs));
    TruthImages& own = of_depth[static_cast<std::size_t>(i)];
    images.noise_free_depth_m = std::move(own.noise_free_depth_m);
    images.invalid_reason = std::move(own.invalid_reason);
  }
  add_other_sensors(other_true_sensors(simulation.rig(), streams, needs), simulation, needs,
                    run.truth);
  run.timings.push_back(truth_clock.finish());
  return run;
}

}  // namespace cousin
