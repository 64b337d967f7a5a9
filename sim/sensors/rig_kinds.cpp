#include "sim/sensors/rig_kinds.h"

#include <stdexcept>
#include <utility>

#include "sim/sensors/camera_sensor.h"

namespace cousin {
namespace {

/// The depth camera's colour camera as a rig of one.
CameraRig color_rig(const ActiveStereoConfig& config, const ActiveStereoUnit& unit,
                    const Rng& rng) {
  CameraRig rig;
  rig.config.title = "colour camera";
  rig.config.sync_error_s = config.sync_error_s;
  rig.config.hand_speed_m_per_s = config.hand_speed_m_per_s;
  rig.config.hand_rate_rad_per_s = config.hand_rate_rad_per_s;
  rig.config.sensors = {
      {.name = "rgb", .camera = color_sensor(config), .centre_in_rig_m = {config.color_x_m, 0, 0}}};
  rig.unit = make_rig(rig.config, rng);
  rig.unit.sensors.front().lens = {unit.color, unit.color_reported};
  return rig;
}

/// 8 bits of an imager's codes.
Image<std::uint8_t> eight_bits(const Image<std::uint16_t>& codes, int bits) {
  Image<std::uint8_t> image(codes.width(), codes.height());
  for (std::size_t i = 0; i < codes.size(); ++i)
    image.data()[i] = static_cast<std::uint8_t>(codes.data()[i] >> (bits - 8));
  return image;
}

Image<std::uint8_t> numbers_of(const Image<InvalidReason>& reasons) {
  Image<std::uint8_t> image(reasons.width(), reasons.height());
  for (std::size_t i = 0; i < reasons.size(); ++i)
    image.data()[i] = static_cast<std::uint8_t>(reasons.data()[i]);
  return image;
}

/// The colour camera's true view from that of a device as reported.
std::vector<TrueView> turned(std::vector<TrueView> views, const Pose& color_from_rig,
                             const Pose& reported) {
  const Pose true_from_reported = color_from_rig * inverse(reported);
  for (TrueView& color : views) {
    color.camera_from_world = true_from_reported * color.camera_from_world;
    color.camera_from_world_end = true_from_reported * color.camera_from_world_end;
  }
  return views;
}

/// A view of what takes depth: at the frame's time, at rest.
TrueView depth_view(const Camera& camera, const Pose& camera_from_world, const View& seen,
                    int frame) {
  TrueView view;
  view.camera = camera;
  view.camera_from_world = view.camera_from_world_end = camera_from_world;
  view.frame = frame;
  view.time_s = seen.time_s;
  return view;
}

void require_depth_by(DepthBy depth_by, bool can_be_modelled, const char* why) {
  if (depth_by == DepthBy::matched || can_be_modelled) return;
  throw std::invalid_argument(std::string("depth_by = model: ") + why);
}

}  // namespace

RigKind make_rig_kind(const DeviceConfig& device, DepthBy depth_by, const Rng& rng) {
  if (const auto* phone = std::get_if<PhoneConfig>(&device))
    return PhoneRig{*phone, make_phone(*phone, rng.fork("phone"))};
  if (const auto* cameras = std::get_if<RigConfig>(&device))
    return CameraRig{*cameras, make_rig(*cameras, rng.fork("device"))};
  if (const auto* range = std::get_if<RangeRigConfig>(&device)) {
    require_depth_by(depth_by, false,
                     "the fast model is of stereo depth cameras; this rig's depth comes from its "
                     "own light, leave depth_by as it is");
    RangeRigUnit unit = make_range_rig(*range, rng.fork("device"));
    return RangeRig{*range, unit, {range->body, unit.color}};
  }
  const auto& config = std::get<ActiveStereoConfig>(device);
  require_depth_by(depth_by, config.has_projector,
                   "the fast model needs a projector, which this rig does not have; depth_by = "
                   "matched renders and matches what the imagers see");
  DepthRig rig{config, make_active_stereo(config, rng.fork("device")), {}};
  rig.color = color_rig(config, rig.unit, rng.fork("color"));
  return rig;
}

std::size_t camera_count(const PhoneRig&) { return 1; }
std::size_t camera_count(const CameraRig& rig) { return rig.config.sensors.size(); }
std::size_t camera_count(const DepthRig&) { return 1; }
std::size_t camera_count(const RangeRig&) { return 1; }

std::optional<std::size_t> depth_place(const PhoneRig&) { return std::nullopt; }
std::optional<std::size_t> depth_place(const CameraRig&) { return std::nullopt; }
std::optional<std::size_t> depth_place(const DepthRig&) { return kRightSensor + 1; }
std::optional<std::size_t> depth_place(const RangeRig&) { return 1; }

std::vector<SensorReport> reports_of(const PhoneRig& rig) {
  return {report_of(rig.config, rig.unit)};
}

std::vector<SensorReport> reports_of(const CameraRig& rig) {
  return report_of(rig.config, rig.unit);
}

std::vector<SensorReport> reports_of(const DepthRig& rig) {
  std::vector<SensorReport> reports = reports_of(rig.color);
  reports.front().sensor_from_rig = rig.unit.color_from_rig_reported;
  Pose right_from_rig;
  right_from_rig.translation_m.x() = -rig.config.baseline_m;
  const Camera& imager = rig.unit.reported;
  reports.push_back({.name = "ir_left", .camera = imager, .sensor_from_rig = {}, .raw_format = {}});
  reports.push_back(
      {.name = "ir_right", .camera = imager, .sensor_from_rig = right_from_rig, .raw_format = {}});
  reports.push_back({.name = std::string(kDepthSensor),
                     .camera = imager,
                     .sensor_from_rig = {},
                     .raw_format = {}});
  return reports;
}

std::vector<SensorReport> reports_of(const RangeRig& rig) {
  std::vector<SensorReport> reports = reports_of(rig.color);
  reports.push_back({.name = std::string(kDepthSensor),
                     .camera = rig.unit.depth_reported,
                     .sensor_from_rig = {},
                     .raw_format = {}});
  return reports;
}

std::vector<TrueView> views_of(const PhoneRig& rig, const Scene& scene, int frame, const Rng& rng) {
  return {true_view(rig.config, rig.unit, scene, frame, rng)};
}

std::vector<TrueView> views_of(const CameraRig& rig, const Scene& scene, int frame,
                               const Rng& rng) {
  return true_views(rig.config, rig.unit, scene, frame, rng);
}

std::vector<TrueView> views_of(const DepthRig& rig, const Scene& scene, int frame, const Rng& rng) {
  std::vector<TrueView> views = turned(views_of(rig.color, scene, frame, rng),
                                       rig.unit.color_from_rig, rig.unit.color_from_rig_reported);
  const View& seen = scene.views[static_cast<std::size_t>(frame)];
  const Pose right = rig.unit.right_from_rig * seen.rig_from_world;
  for (const Pose& pose : {seen.rig_from_world, right, seen.rig_from_world})
    views.push_back(depth_view(rig.unit.imager, pose, seen, frame));
  return views;
}

std::vector<TrueView> views_of(const RangeRig& rig, const Scene& scene, int frame, const Rng& rng) {
  std::vector<TrueView> views = turned(views_of(rig.color, scene, frame, rng),
                                       rig.unit.color_from_rig, rig.unit.color_from_rig_reported);
  const View& seen = scene.views[static_cast<std::size_t>(frame)];
  views.push_back(depth_view(depth_camera(rig.unit.truth), seen.rig_from_world, seen, frame));
  return views;
}

SensorFrame reported_frame(const PhoneRig& rig, std::size_t, const TrueView& view, const View&,
                           const Rng& rng) {
  SensorFrame frame;
  frame.reported = reported_camera(rig.config, rig.unit, view, rng);
  return frame;
}

SensorFrame reported_frame(const CameraRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng) {
  const RigSensor& own = rig.config.sensors.at(sensor);
  SensorFrame frame;
  frame.reported = reported_camera(own.camera, rig.unit.sensors.at(sensor), view.camera,
                                   rng.fork(own.name).fork("sense"));
  frame.time_s = seen.time_s + own.trigger_delay_s;
  return frame;
}

SensorFrame reported_frame(const DepthRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng) {
  if (sensor == 0) return reported_frame(rig.color, 0, view, seen, rng);
  SensorFrame frame;
  frame.reported = rig.unit.reported;
  frame.time_s = seen.time_s;
  if (sensor == depth_place(rig)) frame.depth_unit_m = rig.config.depth_unit_m;
  return frame;
}

SensorFrame reported_frame(const RangeRig& rig, std::size_t sensor, const TrueView& view,
                           const View& seen, const Rng& rng) {
  if (sensor == 0) return reported_frame(rig.color, 0, view, seen, rng);
  SensorFrame frame;
  frame.reported = rig.unit.depth_reported;
  frame.time_s = seen.time_s;
  frame.depth_unit_m = depth_unit_m(rig.config);
  return frame;
}

SensorFrame sense_color(const PhoneRig& rig, std::size_t, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng) {
  return sense(radiance, metered(rig.config, radiance, spot), rig.unit, view, rng);
}

SensorFrame sense_color(const CameraRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng) {
  const RigSensor& own = rig.config.sensors.at(sensor);
  return sense(radiance, metered(own.camera, radiance, spot), rig.unit.sensors.at(sensor), view,
               rng.fork(own.name).fork("sense"));
}

SensorFrame sense_color(const DepthRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng) {
  return sense_color(rig.color, sensor, radiance, view, spot, rng);
}

SensorFrame sense_color(const RangeRig& rig, std::size_t sensor, const Image<Rgbf>& radiance,
                        const TrueView& view, const MeteredSpot& spot, const Rng& rng) {
  return sense_color(rig.color, sensor, radiance, view, spot, rng);
}

namespace {

/// Infrared images handed over.
void give_infrared(const DepthRig& rig, const InfraredCodes& codes, RigFrame& into) {
  into.frame.sensors[kLeftSensor].grey = eight_bits(codes.left, rig.config.imager.bits);
  into.frame.sensors[kRightSensor].grey = eight_bits(codes.right, rig.config.imager.bits);
}

/// What both imagers see without the projector, exposed for that.
void take_without_dots(const DepthRig& rig, const DepthTake& from, RigFrame& into) {
  ActiveStereoUnit dark = rig.unit;
  dark.projector.reset();
  const InfraredPair pair =
      render_infrared_pair(from.rays, from.scene, from.rig_from_world, rig.config, dark,
                           from.rig.fork("infrared").fork("without dots"));
  give_infrared(rig,
                expose_pair(pair, rig.config, dark, from.frame.fork("depth").fork("without dots")),
                into);
}

/// Renders the infrared pair; gives the images and, if depth is matched and asked for, matches
/// them.
void take_matched(const DepthRig& rig, const DepthTake& from, const Streams& streams,
                  RigFrame& into) {
  const bool matches = streams.depth && from.depth_by == DepthBy::matched;
  const bool apart = rig.unit.projector && rig.config.infrared_without_dots;
  if (streams.infrared && apart) take_without_dots(rig, from, into);
  if (!matches && (apart || !streams.infrared)) return;
  const InfraredPair pair = render_infrared_pair(from.rays, from.scene, from.rig_from_world,
                                                 rig.config, rig.unit, from.rig.fork("infrared"));
  const Rng exposure = from.frame.fork("depth");
  InfraredCodes codes = expose_pair(pair, rig.config, rig.unit, exposure);
  if (streams.infrared && !apart) give_infrared(rig, codes, into);
  if (!matches) return;
  StereoDepth sensed = match_pair(pair, std::move(codes), rig.config, rig.unit);
  into.frame.sensors[*depth_place(rig)].depth = std::move(sensed.depth);
  into.noise_free_depth_m = std::move(sensed.noise_free_depth_m);
  into.invalid_reason = numbers_of(sensed.reason);
}

void take_modelled(const DepthRig& rig, const DepthTake& from, RigFrame& into) {
  DepthModelInputs inputs = depth_model_inputs(from.rays, from.scene, from.rig_from_world,
                                               rig.config, rig.unit, from.rig.fork("infrared"));
  ModelDepth sensed =
      model_depth(inputs, rig.config, from.rig.fork("model"), from.frame.fork("depth"));
  into.frame.sensors[*depth_place(rig)].depth = std::move(sensed.depth);
  into.noise_free_depth_m = std::move(inputs.depth_m);
  into.invalid_reason = numbers_of(sensed.reason);
}

}  // namespace

void take_depth(const PhoneRig&, const DepthTake&, const Streams&, RigFrame&) {}
void take_depth(const CameraRig&, const DepthTake&, const Streams&, RigFrame&) {}

void take_depth(const DepthRig& rig, const DepthTake& from, const Streams& streams,
                RigFrame& into) {
  const bool matched = from.depth_by == DepthBy::matched;
  if (streams.infrared || (streams.depth && matched)) take_matched(rig, from, streams, into);
  if (streams.depth && !matched) take_modelled(rig, from, into);
}

void take_depth(const RangeRig& rig, const DepthTake& from, const Streams& streams,
                RigFrame& into) {
  if (!streams.depth) return;
  RangeDepth sensed = sense_range(from.rays, from.scene, from.rig_from_world, rig.unit.truth,
                                  from.rig.fork("infrared"), from.frame.fork("depth"));
  into.frame.sensors[*depth_place(rig)].depth = std::move(sensed.depth);
  into.noise_free_depth_m = std::move(sensed.noise_free_depth_m);
  into.invalid_reason = numbers_of(sensed.reason);
}

}  // namespace cousin
