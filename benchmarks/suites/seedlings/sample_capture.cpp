#include "benchmarks/suites/seedlings/sample_capture.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "benchmarks/score/image_fidelity.h"
#include "scenes/seedlings/seedlings_scene.h"
#include "sim/render/path_tracer.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/phone.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr double kShown = 0.999;  ///< least weight of a pixel that shows something
/// Above the substrate, beyond the tray, below its foot; and of the bench what is swept too.
constexpr double kPlants_m = 0.1, kBeside_m = 0.5, kBench_m = 0.01, kRim_m = 0.03;
constexpr double kBenchOpacity = 0.9, kAirOpacity = 0.02;

struct TraySize {
  double half_x_m, half_y_m, depth_m;
};
TraySize tray_of(const SeedlingsSample& sample) {
  const RunConfig config = sample_config(sample);
  const auto& tray = config.scene.get_if<SeedlingsSceneConfig>()->setting.tray;
  return {0.5 * tray.columns * tray.pitch_m, 0.5 * tray.rows * tray.pitch_m, tray.depth_m};
}

/// One phone before one scene. Streams are forked by purpose and frame.
class Photographer {
 public:
  Photographer(const RunConfig& config, SamplePlan plan, std::uint64_t seed, int number)
      : paths_(config.paths),
        phone_(std::get<PhoneConfig>(config.rig)),
        of_unit_(Rng(seed).fork("seedlings").fork(static_cast<std::uint64_t>(number))),
        rng_(of_unit_.fork(plan == SamplePlan::one_side ? "one side" : "whole tray")),
        scene_(build_scene(config.scene, {.seed = seed, .index = number})),
        rays_(scene_),
        tracer_(rays_, scene_),
        unit_(make_phone(phone_, of_unit_.fork("unit"))) {}

  int count() const { return static_cast<int>(scene_.views.size()); }

  TrueView view(int frame) const {
    return true_view(phone_, unit_, scene_, frame,
                     rng_.fork("view").fork(static_cast<std::uint64_t>(frame)));
  }
  /// @param draw  names the streams of paths and noise
  Image<Rgb8> take(const TrueView& view, const std::string& draw) const {
    const Rng own = rng_.fork(draw).fork(static_cast<std::uint64_t>(view.frame));
    const Image<Rgbf> radiance = tracer_.render(view, paths_, own.fork("radiance")).radiance;
    return sense(radiance, phone_, unit_, view, own.fork("sensor")).color;
  }
  TruthImages truth(const TrueView& view) const {
    return render_truth(rays_, scene_, view, {.depth = true, .position = true, .instance = true});
  }
  bool is_seedling(std::int32_t id) const {
    return std::any_of(scene_.instances.begin(), scene_.instances.end(),
                       [&](const Instance& i) { return i.id == id && i.is_specimen; });
  }

 private:
  PathConfig paths_;
  PhoneConfig phone_;
  Rng of_unit_;  ///< one phone for both plans
  Rng rng_;
  Scene scene_;
  RayScene rays_;
  PathTracer tracer_;
  PhoneUnit unit_;
};

/// The pose while the middle row is read.
Pose middle_pose(const TrueView& view) {
  return interpolate(view.camera_from_world, view.camera_from_world_end, 0.5);
}

SplatView pinhole_photograph(const Image<Rgb8>& image, const TrueView& view) {
  Capture capture;
  Frame frame;
  frame.sensors.resize(1);
  frame.sensors[0].color = image;
  capture.frames.push_back(frame);
  FramePose pose;
  pose.status = PoseStatus::ok;
  pose.camera_from_world = middle_pose(view);
  pose.camera = view.camera;
  return splat_views(capture, {pose}).front();
}

/// The view of a pinhole camera that stands still.
TrueView still(const SplatView& photograph) {
  TrueView view;
  view.camera = photograph.full.camera;
  view.camera_from_world = view.camera_from_world_end = photograph.camera_from_world;
  return view;
}

SampleView sample_view(const Photographer& photographer, const TrueView& view) {
  SampleView result;
  result.photograph = pinhole_photograph(photographer.take(view, "first"), view);
  result.photograph.frame = view.frame;
  TruthImages truth = photographer.truth(still(result.photograph));
  const Image<float>& weight = result.photograph.full.weight;
  result.shown = Image<std::uint8_t>(truth.instance.width(), truth.instance.height(), 255);
  result.seedlings = Image<std::uint8_t>(result.shown.width(), result.shown.height());
  std::int32_t last = -1;
  bool last_is_seedling = false;
  for (std::size_t i = 0; i < result.shown.size(); ++i) {
    if (!weight.empty() && !(weight.data()[i] >= kShown)) result.shown.data()[i] = 0;
    const std::int32_t id = truth.instance.data()[i];
    if (id != last) last_is_seedling = photographer.is_seedling(id);
    last = id;
    if (last_is_seedling) result.seedlings.data()[i] = result.shown.data()[i];
  }
  result.depth_m = std::move(truth.depth_m);
  result.position_m = std::move(truth.position_m);
  return result;
}

/// Noise of so many of the views that are not held out, evenly spread.
void measure_noise(const Photographer& photographer, int views, SampleCapture& capture) {
  std::vector<const SampleView*> trained;
  for (const SampleView& view : capture.views) {
    if (!is_held_out(view.photograph.frame)) trained.push_back(&view);
  }
  const std::size_t count = std::min(trained.size(), static_cast<std::size_t>(std::max(0, views)));
  for (std::size_t i = 0; i < count; ++i) {
    const SampleView& first = *trained[i * trained.size() / count];
    const TrueView view = photographer.view(first.photograph.frame);
    const SplatView again = pinhole_photograph(photographer.take(view, "again"), view);
    const FidelityPlanes& photograph = first.photograph.full.color.channel;
    capture.noise_psnr_db += psnr_db(again.full.color.channel, photograph, first.shown);
    ++capture.noise_views;
    const double plants_db = psnr_db(again.full.color.channel, photograph, first.seedlings);
    if (std::isnan(plants_db)) continue;  // it shows none
    capture.noise_seedlings_db += plants_db;
    ++capture.noise_views_of_seedlings;
  }
  if (capture.noise_views > 0) capture.noise_psnr_db /= capture.noise_views;
  if (capture.noise_views_of_seedlings > 0)
    capture.noise_seedlings_db /= capture.noise_views_of_seedlings;
}

std::vector<StartPoint> points_over_bench(const SeedlingsSample& sample, int points,
                                          const Rng& rng) {
  const TraySize tray = tray_of(sample);
  return random_start_points(
      {-tray.half_x_m - kBeside_m, -tray.half_y_m - kBeside_m, -tray.depth_m - kBench_m},
      {tray.half_x_m + kBeside_m, tray.half_y_m + kBeside_m, -tray.depth_m}, points,
      rng.fork("bench"));
}

std::vector<StartPoint> points_over_plants(const SeedlingsSample& sample, int points,
                                           const Rng& rng) {
  const TraySize tray = tray_of(sample);
  return random_start_points({-tray.half_x_m, -tray.half_y_m, -tray.depth_m},
                             {tray.half_x_m, tray.half_y_m, kPlants_m}, points, rng.fork("tray"));
}

}  // namespace

PhoneConfig with_picture(PhoneConfig phone, int width_px, int height_px) {
  const double side = static_cast<double>(phone.width_px) / width_px;
  const double count = side * side;
  phone.width_px = width_px;
  phone.height_px = height_px;
  phone.full_well_e *= count;
  phone.read_noise_e *= side;
  phone.dsnu_e *= side;
  phone.prnu /= side;
  // The mean of n codes has log2(n) / 2 more bits than one.
  phone.bits = std::min(16, phone.bits + static_cast<int>(std::ceil(0.5 * std::log2(count))));
  return phone;
}

std::vector<std::string> assignments(const SeedlingsSample& sample) {
  char day[32] = {};
  std::to_chars(day, day + sizeof day - 1, sample.day);  // as many digits as the number has
  return {"light=" + sample.light, std::string("day=") + day,
          "views=" + std::to_string(planned_views(sample.views)),
          "render.pixel_samples=" + std::to_string(sample.pixel_samples)};
}

RunConfig sample_config(const SeedlingsSample& sample) {
  RunConfig config = run_config(seedlings_row(), assignments(sample));
  config.rig = with_picture(std::get<PhoneConfig>(config.rig), sample.width_px, sample.height_px);
  validate(config);
  return config;
}

SampleCapture photograph_sample(const SeedlingsSample& sample, SamplePlan plan, int noise_views,
                                std::uint64_t seed) {
  const StageClock clock("photographs");
  RunConfig config = sample_config(sample);
  if (plan == SamplePlan::one_side) {
    auto& scene = *config.scene.get_if<SeedlingsSceneConfig>();
    scene.views = sample.views;
    scene.coverage = kOneSideShare;
  }
  const Photographer photographer(config, plan, seed, sample.number);
  SampleCapture capture;
  for (int i = 0; i < photographer.count(); ++i)
    capture.views.push_back(sample_view(photographer, photographer.view(i)));
  measure_noise(photographer, noise_views, capture);
  capture.wall_s = clock.finish().wall_s;
  return capture;
}

std::vector<StartPoint> sample_start(const SeedlingsSample& sample, int points, Rng rng) {
  std::vector<StartPoint> start = points_over_plants(sample, points - points / 3, rng);
  const std::vector<StartPoint> bench = points_over_bench(sample, points / 3, rng);
  start.insert(start.end(), bench.begin(), bench.end());
  return start;
}

std::vector<StartPoint> unswept_start(const SeedlingsSample& sample, int points, const Rng& rng) {
  std::vector<StartPoint> start = points_over_bench(sample, points / 3, rng);
  for (StartPoint& point : start) point.opacity = kBenchOpacity;
  for (StartPoint point : points_over_plants(sample, points * 3 / 5, rng)) {
    point.opacity = kAirOpacity;
    start.push_back(point);
  }
  return start;
}

SweepVolume sample_volume(const SeedlingsSample& sample) {
  const TraySize tray = tray_of(sample);
  return {{-tray.half_x_m - kRim_m, -tray.half_y_m - kRim_m, -tray.depth_m - kBench_m},
          {tray.half_x_m + kRim_m, tray.half_y_m + kRim_m, kPlants_m}};
}

}  // namespace cousin
