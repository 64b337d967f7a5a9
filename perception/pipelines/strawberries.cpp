#include "perception/pipelines/strawberries.h"

#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "perception/pipelines/pipeline_table.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<Named<StrawberriesMethod>, 2> kStrawberryMethods = {
    {{StrawberriesMethod::ours, "ours"}, {StrawberriesMethod::paper, "paper"}}};

/// The whole of space, in each camera's own axes.
Depths aligned_depths(const Capture& capture, const SensorDepthConfig& config) {
  Poses cameras;
  for (const Frame& frame : capture.frames) {
    FramePose pose;
    pose.frame = frame.id;
    pose.status = PoseStatus::ok;
    pose.camera = frame.sensors.front().reported;
    cameras.push_back(pose);
  }
  constexpr double kFar_m = 1e6;
  const DepthVolume all{Eigen::Vector3d::Constant(-kFar_m), Eigen::Vector3d::Constant(kFar_m), 0};
  return depths_of_sensor(capture, cameras, all, config);
}

SpecimenTraits traits_of(const DetectedBox& box, const FruitPoint& point) {
  SpecimenTraits traits;
  traits.instance = box.id;
  traits.frame = box.frame;
  if (!point.why_none.empty()) {
    traits.reason = point.why_none;
    return traits;
  }
  traits.status = TraitStatus::ok;
  const char* const names[] = {"point_x", "point_y", "point_z"};
  for (int k = 0; k < 3; ++k)
    traits.traits.push_back(
        {names[k], "m", point.point_m[k], std::sqrt(point.covariance_m2(k, k))});
  const double distance_m = point.point_m.norm();
  const Eigen::Vector3d way = point.point_m / distance_m;
  traits.traits.push_back(
      {"distance", "m", distance_m, std::sqrt(way.dot(point.covariance_m2 * way))});
  return traits;
}

Traits points_of(const Capture& capture, const Estimate& so_far,
                 const StrawberriesPipelineConfig& config) {
  std::map<int, std::size_t> places;
  for (std::size_t i = 0; i < capture.frames.size(); ++i) places[capture.frames[i].id] = i;
  std::map<int, Boxes> of_image;
  for (const DetectedBox& box : so_far.boxes) {
    if (box.sensor == 0) of_image[box.frame].push_back(box);
  }
  Traits traits;
  for (const DetectedBox& box : so_far.boxes) {
    if (box.sensor != 0) continue;  // depth is aligned to the first sensor's image
    const auto place = places.find(box.frame);
    if (place == places.end())
      throw StageError("traits", "box " + std::to_string(box.id) + " is of frame " +
                                     std::to_string(box.frame) + ", which the capture has not");
    const FrameDepth none;
    const FrameDepth& depth = so_far.depths.empty() ? none : so_far.depths[place->second];
    const Camera& camera = capture.frames[place->second].sensors.front().reported;
    traits.push_back(traits_of(
        box, config.method == StrawberriesMethod::paper
                 ? point_by_paper(depth, camera, box, config.point)
                 : point_by_patch(depth, camera, box, of_image[box.frame], config.point)));
  }
  return traits;
}

}  // namespace

std::string_view to_string(StrawberriesMethod method) {
  return name_in<StrawberriesMethod>(kStrawberryMethods, method);
}

Fields fields(StrawberriesPipelineConfig& c) {
  return Fields{{"method", choice_field<StrawberriesMethod>("method", kStrawberryMethods, c.method),
                 "ours: a curved patch through a window of depths; paper: the depth under the "
                 "middle of a box, or a small window's"}} +
         nested("sensor_depth", fields(c.sensor_depth)) + nested("point", fields(c.point));
}

void validate(const StrawberriesPipelineConfig& config) {
  validate(config.sensor_depth);
  validate(config.point);
}

PipelineNeeds needs(const StrawberriesPipelineConfig&) {
  return {.images = {"color", "depth"}, .stages = {"boxes", "depth", "traits"}, .left_out = {}};
}

void check_capture(const Capture& capture, const StrawberriesPipelineConfig& config) {
  if (has_sensor_depth(capture)) return;
  throw std::invalid_argument("method " + std::string(to_string(config.method)) +
                              " of strawberries reads depth images, and the capture has none");
}

Stages stages_for(const StrawberriesPipelineConfig& config, const Capture& /*capture*/,
                  std::uint64_t /*seed*/, const SplatWatch& /*watch*/) {
  Stages stages;
  stages.depths = [config](const Capture& capture, const Estimate&) {
    return aligned_depths(capture, config.sensor_depth);
  };
  stages.traits = [config](const Capture& capture, const Estimate& so_far) {
    return points_of(capture, so_far, config);
  };
  return stages;
}

const PipelineRow& strawberries_pipeline();
const PipelineRow& row_of(const StrawberriesPipelineConfig& /*config*/) {
  return strawberries_pipeline();
}

const PipelineRow& strawberries_pipeline() {
  static constexpr auto kOrder = std::to_array<std::string_view>({"boxes", "depth", "traits"});
  static const PipelineRow kRow = {
      .name = "strawberries",
      .help = "where each fruit's surface is, from boxes and a depth camera",
      .scenes = {"strawberries"},
      .order = kOrder,
      .from_outside = {"boxes"},
      .traits_of = TraitsOf::boxes,
      .traits = {"point_x", "point_y", "point_z", "distance"},
      .methods = {{"ours",
                   "a curved patch through the depths about the middle of a box, with its "
                   "uncertainty"},
                  {"paper",
                   "the paper's rule: depth under the middle of a box, or the mean of 5 x 5 where "
                   "there is none"}},
      .defaults = [] { return PipelineConfig(StrawberriesPipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
