#include "sim/sensors/rig_capture.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "sim/config/limits.h"
#include "sim/render/view_match.h"
#include "sim/sensors/hand_motion.h"
#include "sim/sensors/rig_kinds.h"

namespace cousin {
namespace {

/// A small turn, as a pose.
Pose small_motion(const Eigen::Vector3d& shift_m, const Eigen::Vector3d& turn_rad) {
  Pose pose;
  pose.translation_m = shift_m;
  if (const double angle = turn_rad.norm(); angle > 0)
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn_rad / angle));
  return pose;
}

void require_streams(const Streams& asked, const Streams& there_are) {
  if ((asked.color && !there_are.color) || (asked.raw && !there_are.raw) ||
      (asked.infrared && !there_are.infrared) || (asked.depth && !there_are.depth)) {
    throw std::invalid_argument("rig: " + to_string(asked) + " was asked for; it has " +
                                to_string(there_are));
  }
}

}  // namespace

Fields fields(RigCaptureConfig& config) {
  const TextField depth_by{
      [&config] { return std::string(config.depth_by == DepthBy::model ? "model" : "matched"); },
      [&config](const std::string& text) {
        if (text != "matched" && text != "model")
          throw std::invalid_argument("\"" + text + "\" is not one of matched, model");
        config.depth_by = text == "model" ? DepthBy::model : DepthBy::matched;
      }};
  return {
      {"depth_by", depth_by,
       "a depth camera's images: matched (infrared pair rendered and matched) or model (fast)"},
      {"knows_pose", &config.knows_pose, "the rig is on an arm that reports its poses"},
      {"pose_error_m", &config.pose_error_m, "sigma of a reported place, each axis", 0, 1},
      {"pose_error_rad", &config.pose_error_rad, "sigma of a reported turn, each axis", 0, 1},
      {"metered_m", &config.metered_m,
       "automatic exposure is for what lies so near to the view's focus; 0: for the highlights", 0,
       10},
  };
}

void validate(const RigCaptureConfig& config) {
  RigCaptureConfig copy = config;
  check_limits(fields(copy));
}

struct RigCapture::Impl {
  RigCaptureConfig config;
  Streams streams;
  const RayScene& rays;
  const Scene& scene;
  Rng rng;
  RigKind kind;
  std::vector<SensorReport> reports;
  std::vector<SensorViews> views;

  Impl(const DeviceConfig& device, const RigCaptureConfig& capture, const RayScene& ray_scene,
       const Scene& the_scene, const Rng& stream)
      : config(capture),
        streams(streams_of(device)),
        rays(ray_scene),
        scene(the_scene),
        rng(stream),
        kind(make_rig_kind(device, capture.depth_by, stream)) {
    validate(capture);
    reports = std::visit([](const auto& rig) { return reports_of(rig); }, kind);
    for (const SensorReport& report : reports) views.push_back({report.name, {}});
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
      const std::vector<TrueView> of_frame = std::visit(
          [&](const auto& rig) {
            return views_of(rig, scene, static_cast<int>(i), rng.fork("view").fork(i));
          },
          kind);
      for (std::size_t s = 0; s < views.size(); ++s) views[s].views.push_back(of_frame.at(s));
    }
  }

  /// Place of the sensor that has depth.
  std::optional<std::size_t> depth() const {
    return std::visit([](const auto& rig) { return depth_place(rig); }, kind);
  }

  Rng of_frame(const char* purpose, int frame) const {
    return rng.fork(purpose).fork(static_cast<std::uint64_t>(frame));
  }

  /// Where the arm says that the rig is at the frame's time.
  Pose reported_pose(int frame) const {
    Rng error = of_frame("arm", frame);
    const Eigen::Vector3d shift_m = config.pose_error_m * normal3(error);
    const Eigen::Vector3d turn_rad = config.pose_error_rad * normal3(error);
    return small_motion(shift_m, turn_rad) *
           scene.views[static_cast<std::size_t>(frame)].rig_from_world;
  }

  /// Colour and raw of the cameras, in their places among the sensors.
  void take_color(int frame, const Streams& asked, const RadianceRenderer& radiance,
                  std::uint64_t repeat, Frame& into) const {
    const std::size_t cameras = std::visit([](const auto& rig) { return camera_count(rig); }, kind);
    const Rng light = rng.fork("radiance").fork(repeat);
    const Rng noise = of_frame("sensor", frame);
    for (std::size_t s = 0; s < cameras; ++s) {
      const TrueView& view = views[s].views[static_cast<std::size_t>(frame)];
      const Rng of_view = light.fork(static_cast<std::uint64_t>(frame));
      const MeteredSpot spot =
          metered_spot(scene.views[static_cast<std::size_t>(frame)], view, config.metered_m);
      const Image<Rgbf> seen = radiance(view, s == 0 ? of_view : of_view.fork(views[s].sensor));
      SensorFrame sensed = std::visit(
          [&](const auto& rig) {
            return sense_color(rig, s, seen, view, spot,
                               repeat == 0 ? noise : noise.fork("repeat").fork(repeat));
          },
          kind);
      if (asked.color) into.sensors[s].color = std::move(sensed.color);
      if (asked.raw) into.sensors[s].raw = std::move(sensed.raw);
    }
  }
};

RigCapture::RigCapture(const DeviceConfig& device, const RigCaptureConfig& config,
                       const RayScene& rays, const Scene& scene, const Rng& rng)
    : impl_(std::make_unique<Impl>(device, config, rays, scene, rng)) {}
RigCapture::~RigCapture() = default;
RigCapture::RigCapture(RigCapture&&) noexcept = default;

std::vector<SensorReport> RigCapture::reports() const { return impl_->reports; }
const std::vector<SensorViews>& RigCapture::views() const { return impl_->views; }

Frame RigCapture::reported(int frame) const {
  const View& seen = impl_->scene.views.at(static_cast<std::size_t>(frame));
  Frame result;
  result.id = frame;
  result.time_s = seen.time_s;
  if (impl_->config.knows_pose) result.rig_from_world = impl_->reported_pose(frame);
  for (std::size_t s = 0; s < impl_->reports.size(); ++s) {
    const TrueView& view = impl_->views[s].views[static_cast<std::size_t>(frame)];
    result.sensors.push_back(std::visit(
        [&](const auto& rig) {
          return reported_frame(rig, s, view, seen, impl_->of_frame("sensor", frame));
        },
        impl_->kind));
  }
  return result;
}

Frame RigCapture::outline(int frame, const Streams& streams) const {
  require_streams(streams, impl_->streams);
  Frame result = reported(frame);
  const std::optional<std::size_t> depth = impl_->depth();
  const std::size_t cameras =
      std::visit([](const auto& rig) { return camera_count(rig); }, impl_->kind);
  for (std::size_t s = 0; s < cameras; ++s) {
    if (streams.color) result.sensors[s].color = Image<Rgb8>(1, 1);
    if (streams.raw && impl_->reports[s].linear_raw)
      result.sensors[s].raw = Image<std::uint16_t>(1, 1);
  }
  if (streams.infrared) {
    result.sensors[kLeftSensor].grey = Image<std::uint8_t>(1, 1);
    result.sensors[kRightSensor].grey = Image<std::uint8_t>(1, 1);
  }
  if (depth && streams.depth) result.sensors[*depth].depth = Image<std::uint16_t>(1, 1);
  return result;
}

RigFrame RigCapture::take(int frame, const Streams& streams, const RadianceRenderer& radiance,
                          std::uint64_t repeat) const {
  require_streams(streams, impl_->streams);
  RigFrame result;
  result.frame = reported(frame);
  if (streams.color || streams.raw)
    impl_->take_color(frame, streams, radiance, repeat, result.frame);
  const DepthTake from{impl_->rays,
                       impl_->scene,
                       impl_->scene.views[static_cast<std::size_t>(frame)].rig_from_world,
                       impl_->config.depth_by,
                       impl_->rng,
                       impl_->of_frame("sensor", frame)};
  std::visit([&](const auto& rig) { take_depth(rig, from, streams, result); }, impl_->kind);
  return result;
}

ViewMatch RigCapture::disparity(int frame) const {
  if (impl_->depth() || impl_->views.size() < 2) return {};
  const auto i = static_cast<std::size_t>(frame);
  const TrueView &here = impl_->views[0].views.at(i), &there = impl_->views[1].views.at(i);
  const TruthImages truth =
      render_truth(impl_->rays, impl_->scene, here, {.depth = true, .instance = true});
  return match_views(impl_->scene, {impl_->rays, here}, truth.depth_m, truth.instance,
                     {impl_->rays, there});
}

RigRun take_all(const RigCapture& rig, const Streams& streams, const TruthNeeds& needs,
                const RadianceRenderer& radiance,
                const std::function<void(int done, int total)>& progress) {
  RigRun run;
  run.rig = rig.reports();
  const int frames = static_cast<int>(rig.views().front().views.size());
  for (int i = 0; i < frames; ++i) {
    if (progress) progress(i, frames);
    RigFrame taken = rig.take(i, streams, radiance);
    run.frames.push_back(std::move(taken.frame));
    TruthImages& truth = run.truth.emplace_back();
    if (needs.noise_free_depth) truth.noise_free_depth_m = std::move(taken.noise_free_depth_m);
    if (needs.invalid_reason) truth.invalid_reason = std::move(taken.invalid_reason);
  }
  return run;
}

}  // namespace cousin
