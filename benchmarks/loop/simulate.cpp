#include "benchmarks/loop/simulate.h"

#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "sim/dataset/environment_io.h"
#include "sim/geometry/user_mesh.h"
#include "sim/render/view_match.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

std::optional<UserMesh> user_specimen(const SeedsSceneConfig& config) {
  const std::string file = specimen_file(config);
  if (file.empty()) return std::nullopt;
  UserMesh user = welded(read_user_mesh(file));
  for (Eigen::Vector3d& vertex : user.mesh.vertices_m) vertex *= config.specimen_scale;
  return user;
}

/// What there is of every camera; the rest is of the first, of the whole rig or of all views.
TruthNeeds of_any_sensor(TruthNeeds needs) {
  needs.leaf_area = needs.flow = needs.disparity = false;
  needs.noise_free_depth = needs.invalid_reason = false;
  return needs;
}

std::optional<Environment> user_environment(const SeedsSceneConfig& config) {
  if (config.environment.empty()) return std::nullopt;
  return read_environment(config.environment, config.environment_scale);
}

}  // namespace

struct SeedsSimulation::Impl {
  SeedsRunConfig asked;
  SeedsCousin cousin;
  const SeedsRunConfig& config;  ///< of this scene
  std::uint64_t seed;
  Rng rng;
  Scene scene;
  RayScene rays;
  RigCapture rig;
  std::optional<PathTracer> paths;  ///< if they make the light
  mutable std::mutex cache_mutex;
  mutable std::map<std::uint64_t, IrradianceCache>
      caches;  ///< one for each repeat; nodes stay in place

  Impl(const SeedsRunConfig& run_config, std::uint64_t run_seed, int scene_index)
      : asked(run_config),
        cousin(cousin_of(run_config, run_seed, scene_index)),
        config(cousin.config),
        seed(run_seed),
        rng(Rng(run_seed).fork("scene").fork(static_cast<std::uint64_t>(scene_index))),
        scene(build_seeds_scene(config.scene, rng.fork("build"), user_specimen(config.scene),
                                user_environment(config.scene))),
        rays(scene),
        rig(config.rig, config.capture, rays, scene, rng) {
    if (config.radiance == RadianceBy::paths) paths.emplace(rays, scene);
  }

  const std::vector<TrueView>& views() const { return rig.views().front().views; }

  const IrradianceCache& cache(std::uint64_t repeat) const {
    const std::lock_guard lock(cache_mutex);
    const auto found = caches.find(repeat);
    if (found != caches.end()) return found->second;
    return caches
        .emplace(repeat,
                 IrradianceCache(rays, scene, config.render, rng.fork("light").fork(repeat)))
        .first->second;
  }

  Image<Rgbf> light(const TrueView& view, std::uint64_t repeat, const Rng& stream) const {
    if (paths) return paths->render(view, config.paths, stream).radiance;
    return render_radiance(rays, scene, cache(repeat), view, config.render, stream);
  }
};

SeedsSimulation::SeedsSimulation(const SeedsRunConfig& config, std::uint64_t seed, int scene_index)
    : impl_(std::make_unique<Impl>(config, seed, scene_index)) {}
SeedsSimulation::~SeedsSimulation() = default;
SeedsSimulation::SeedsSimulation(SeedsSimulation&&) noexcept = default;

const Scene& SeedsSimulation::scene() const { return impl_->scene; }
const RayScene& SeedsSimulation::rays() const { return impl_->rays; }
const std::vector<TrueView>& SeedsSimulation::views() const { return impl_->views(); }

Image<Rgbf> SeedsSimulation::radiance(int frame, std::uint64_t repeat) const {
  const Rng rng = impl_->rng.fork("radiance").fork(repeat).fork(static_cast<std::uint64_t>(frame));
  return impl_->light(impl_->views().at(static_cast<std::size_t>(frame)), repeat, rng);
}

const RigCapture& SeedsSimulation::rig() const { return impl_->rig; }

RadianceRenderer SeedsSimulation::renderer() const {
  const Impl* impl = impl_.get();
  return [impl](const TrueView& view, const Rng& rng) { return impl->light(view, 0, rng); };
}

RigFrame SeedsSimulation::take(int frame, const Streams& streams, std::uint64_t repeat) const {
  return impl_->rig.take(frame, streams, renderer(), repeat);
}

TruthImages SeedsSimulation::truth(int frame, const TruthNeeds& needs, std::size_t sensor) const {
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

void add_other_sensors(const std::vector<std::size_t>& sensors,
                       const std::function<TruthImages(int frame, std::size_t sensor)>& truth_of,
                       SceneTruth& truth) {
  for (const std::size_t s : sensors) {
    SensorViews& other = truth.other_sensors.at(s - 1);
    for (const TrueView& view : other.views) other.images.push_back(truth_of(view.frame, s));
  }
}

Capture SeedsSimulation::capture_header() const {
  Capture capture;
  capture.pipeline = "seeds";
  capture.board = impl_->scene.board;
  capture.rig = impl_->rig.reports();
  return capture;
}

SceneTruth SeedsSimulation::scene_truth() const {
  SceneTruth truth;
  truth.seed = impl_->seed;
  truth.config_toml = resolved_toml(impl_->asked) + comments_of(impl_->cousin.changes);
  truth.scene = impl_->scene;
  truth.views = impl_->views();
  truth.other_sensors.assign(impl_->rig.views().begin() + 1, impl_->rig.views().end());
  return truth;
}

SimulatedRun simulate_seeds(const SeedsRunConfig& config, std::uint64_t seed, int scene_index,
                            const TruthNeeds& needs, const Progress& progress) {
  return simulate_seeds(config, seed, scene_index, planned_streams(config), needs, progress);
}

SimulatedRun simulate_seeds(const SeedsRunConfig& config, std::uint64_t seed, int scene_index,
                            const Streams& streams, const TruthNeeds& needs,
                            const Progress& progress) {
  const auto say = [&](const std::string& what, int done, int total) {
    if (progress) progress(what, done, total);
  };
  SimulatedRun run;
  say("scene", 0, 1);
  const StageClock scene_clock("scene");
  const SeedsSimulation simulation(config, seed, scene_index);
  run.timings.push_back(scene_clock.finish());

  const int frames = static_cast<int>(simulation.views().size());
  run.capture = simulation.capture_header();
  const StageClock render_clock("render");
  run.radiance.stage =
      config.radiance == RadianceBy::paths ? "radiance_by_paths" : "radiance_by_cached";
  const RadianceRenderer renderer = [&](const TrueView& view, const Rng& rng) {
    const StageClock clock(run.radiance.stage);
    Image<Rgbf> image = simulation.renderer()(view, rng);
    const StageTiming timing = clock.finish();
    run.radiance.wall_s += timing.wall_s;
    run.radiance.cpu_s += timing.cpu_s;
    run.radiance.peak_rss_mb = timing.peak_rss_mb;  // of the process so far
    run.radiance.peak_above_start_mb = timing.peak_above_start_mb;
    return image;
  };
  RigRun taken = take_all(simulation.rig(), streams, needs, renderer,
                          [&](int done, int total) { say("render", done, total); });
  run.capture.frames = std::move(taken.frames);
  run.timings.push_back(render_clock.finish());

  const StageClock truth_clock("truth");
  run.truth = simulation.scene_truth();
  const bool any = needs != TruthNeeds{};
  for (int frame = 0; any && frame < frames; ++frame) {
    say("truth", frame, frames);
    TruthImages& images = run.truth.images.emplace_back(simulation.truth(frame, needs));
    TruthImages& of_depth = taken.truth[static_cast<std::size_t>(frame)];
    images.noise_free_depth_m = std::move(of_depth.noise_free_depth_m);
    images.invalid_reason = std::move(of_depth.invalid_reason);
  }
  add_other_sensors(
      other_true_sensors(simulation.rig(), streams, needs),
      [&](int frame, std::size_t sensor) { return simulation.truth(frame, needs, sensor); },
      run.truth);
  run.timings.push_back(truth_clock.finish());
  return run;
}

}  // namespace cousin
