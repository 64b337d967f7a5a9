#include "perception/pipelines/strawberries.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "perception/fruit/fruit_comparators.h"
#include "perception/fruit/fruit_seam.h"
#include "perception/pipelines/pipeline_table.h"
#include "perception/pipelines/seen_boxes.h"
#include "sim/config/changed_keys.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<Named<StrawberriesMethod>, 4> kStrawberryMethods = {
    {{StrawberriesMethod::ours, "ours"},
     {StrawberriesMethod::paper, "paper"},
     {StrawberriesMethod::ellipsoid, "ellipsoid"},
     {StrawberriesMethod::cone, "cone"}}};

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

std::map<int, Boxes> boxes_of_images(const Boxes& boxes) {
  std::map<int, Boxes> of_image;
  for (const DetectedBox& box : boxes) {
    if (box.sensor == 0) of_image[box.frame].push_back(box);
  }
  return of_image;
}

FruitPoint point_of(const SeenBox& seen, const Boxes& others,
                    const StrawberriesPipelineConfig& config) {
  const Camera& camera = seen.image->reported;
  return config.method == StrawberriesMethod::paper
             ? point_by_paper(*seen.depth, camera, *seen.box, config.point)
             : point_by_patch(*seen.depth, camera, *seen.box, others, config.point);
}

FruitFit fit_of(const SeenBox& seen, const Boxes& others, const FruitKind& kind,
                const StrawberriesPipelineConfig& config) {
  const Camera& camera = seen.image->reported;
  if (config.method == StrawberriesMethod::ours)
    return fit_fruit(fruit_surface(*seen.depth, camera, *seen.box, config.surface), kind,
                     config.fit);
  const FruitPoint point = point_of(seen, others, config);
  const BoxBody body =
      config.method == StrawberriesMethod::cone ? BoxBody::cone : BoxBody::ellipsoid;
  return fit_box(*seen.box, camera, point.point_m, point.why_none, body, config.prior);
}

Fits fits_of(const Capture& capture, const Estimate& so_far,
             const StrawberriesPipelineConfig& config) {
  const std::vector<SeenBox> boxes = seen_boxes(capture, so_far, "fits");
  const std::map<int, Boxes> others = boxes_of_images(so_far.boxes);
  const FruitKind kind = kind_of(config.prior);
  Fits fits(boxes.size());
  tbb::parallel_for(std::size_t{0}, boxes.size(), [&](std::size_t i) {
    const DetectedBox& box = *boxes[i].box;
    fits[i] = seam_of(fit_of(boxes[i], others.at(box.frame), kind, config), box.id,
                      "strawberry by " + std::string(to_string(config.method)));
  });
  return fits;
}

/// Sigma of a direction of a covariance; NaN where it is not given.
double sigma_along(const Eigen::Matrix3d& covariance_m2, const Eigen::Vector3d& way) {
  return std::sqrt(way.dot(covariance_m2 * way));
}

void add_place(const std::string& name, const Eigen::Vector3d& point_m,
               const Eigen::Matrix3d& covariance_m2, std::vector<Trait>& traits) {
  for (int k = 0; k < 3; ++k)
    traits.push_back({name + "_" + "xyz"[k], "m", point_m[k], std::sqrt(covariance_m2(k, k))});
}

/// @param sigma_rad  of its turn, each way across
void add_direction(const std::string& name, const Eigen::Vector3d& way, double sigma_rad,
                   std::vector<Trait>& traits) {
  for (int k = 0; k < 3; ++k) {
    const double aside = std::sqrt(std::max(0.0, 1 - way[k] * way[k]));
    traits.push_back({name + "_" + "xyz"[k], "1", way[k], sigma_rad * aside});
  }
}

void add_point(const FruitPoint& point, SpecimenTraits& traits) {
  if (!point.why_none.empty()) {
    traits.reason = point.why_none;
    return;
  }
  traits.status = TraitStatus::ok;
  add_place("point", point.point_m, point.covariance_m2, traits.traits);
  const double distance_m = point.point_m.norm();
  traits.traits.push_back(
      {"distance", "m", distance_m, sigma_along(point.covariance_m2, point.point_m / distance_m)});
}

void add_fit(const SeenBox& seen, const ObjectFit& fit, const StrawberriesPipelineConfig& config,
             SpecimenTraits& traits) {
  const FruitShape shape = shape_of(fit);
  if (fit.status != FitStatus::ok || !shape.numbers.allFinite()) {
    traits.reason += (traits.reason.empty() ? "" : "; ") +
                     (fit.reason.empty() ? "its fit lacks numbers" : fit.reason);
    return;
  }
  traits.status = TraitStatus::ok;
  if (!fit.reason.empty()) traits.reason += (traits.reason.empty() ? "" : "; ") + fit.reason;
  const FruitPlaces places =
      places_of(shape, covariance_of(fit), config.stalk,
                {.widen = config.fit.widen, .unit_sigma = config.fit.unit_sigma});
  add_place("centre", places.centre.point_m, places.centre.covariance_m2, traits.traits);
  add_place("calyx", places.calyx.point_m, places.calyx.covariance_m2, traits.traits);
  add_place("cut", places.cut.point_m, places.cut.covariance_m2, traits.traits);
  add_direction("axis", places.axis, places.sigma_axis_rad, traits.traits);
  add_direction("approach", places.approach, places.sigma_axis_rad, traits.traits);
  constexpr std::pair<const char*, const char*> kSizes[] = {
      {"length", "m"}, {"diameter", "m"}, {"volume", "m3"}};
  for (const auto& [name, unit] : kSizes) {
    const FruitMeasure size = parameter_of(fit, name);
    if (std::isfinite(size.value)) traits.traits.push_back({name, unit, size.value, size.sigma});
  }
  const FruitMeasure red =
      red_share_seen(seen.image->color, seen.image->reported, *seen.box, shape, config.red);
  if (std::isfinite(red.value)) traits.traits.push_back({"red_share", "1", red.value, red.sigma});
}

Traits traits_of_boxes(const Capture& capture, const Estimate& so_far,
                       const StrawberriesPipelineConfig& config) {
  const std::map<int, const ObjectFit*> fit_of_box = fits_by_box(so_far.fits);
  const std::map<int, Boxes> others = boxes_of_images(so_far.boxes);
  Traits traits;
  for (const SeenBox& seen : seen_boxes(capture, so_far, "traits")) {
    SpecimenTraits own;
    own.instance = seen.box->id;
    own.frame = seen.box->frame;
    add_point(point_of(seen, others.at(seen.box->frame), config), own);
    const auto fit = fit_of_box.find(seen.box->id);
    if (fit != fit_of_box.end()) add_fit(seen, *fit->second, config, own);
    traits.push_back(std::move(own));
  }
  return traits;
}

}  // namespace

std::string_view to_string(StrawberriesMethod method) {
  return name_in<StrawberriesMethod>(kStrawberryMethods, method);
}

FruitSurfaceConfig strawberry_surface() {
  FruitSurfaceConfig config;
  config.rim_px = 4;
  config.smallest_fruit_m = 0.008;
  config.largest_fruit_m = 0.06;
  config.before_m = 0.006;
  config.least_share = 0.4;  // a sensor that misses most of a fruit matches what is beside it
  return config;
}

FruitFitConfig strawberry_fit() {
  FruitFitConfig config;
  config.floor_m = 0.0006;  // achenes and their dimples
  config.odd_scale = 4;     // its waves are wider than an apple's already
  config.widen = 0.8;       // fitted to coverage on seeds 101 to 103
  return config;
}

Fields fields(StrawberriesPipelineConfig& c) {
  return Fields{{"method", choice_field<StrawberriesMethod>("method", kStrawberryMethods, c.method),
                 "how a fruit's places and sizes follow from its box"}} +
         nested("sensor_depth", fields(c.sensor_depth)) + nested("point", fields(c.point)) +
         nested("surface", fields(c.surface)) + nested("prior", fields(c.prior)) +
         nested("fit", fields(c.fit)) + nested("stalk", fields(c.stalk)) +
         nested("red", fields(c.red));
}

void validate(const StrawberriesPipelineConfig& config) {
  validate(config.sensor_depth);
  validate(config.point);
  validate(config.surface);
  validate(config.prior);
  validate(config.fit);
  validate(config.stalk);
  validate(config.red);
}

PipelineNeeds needs(const StrawberriesPipelineConfig& config) {
  PipelineNeeds own{
      .images = {"color", "depth"}, .stages = {"boxes", "depth", "fits", "traits"}, .left_out = {}};
  if (config.method == StrawberriesMethod::paper) {
    std::erase(own.stages, "fits");
    own.left_out.emplace_back("fits", "the paper's rule knows the surface's point alone");
  }
  return own;
}

std::vector<std::string> unused_settings(const StrawberriesPipelineConfig& config) {
  const std::string_view method = to_string(config.method);
  if (config.method == StrawberriesMethod::ours) return {};
  if (config.method == StrawberriesMethod::paper)
    return keys_without_effect(config, method, {"surface.", "prior.", "fit.", "stalk.", "red."});
  return keys_without_effect(config, method,
                             {"surface.", "fit.iterations", "fit.followed", "fit.wave", "fit.odd",
                              "fit.strange", "fit.usual", "fit.outline", "fit.along", "fit.unknown",
                              "fit.floor", "fit.lean", "fit.pitch", "fit.most"});
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
  if (config.method != StrawberriesMethod::paper)
    stages.fits = [config](const Capture& capture, const Estimate& so_far) {
      return fits_of(capture, so_far, config);
    };
  stages.traits = [config](const Capture& capture, const Estimate& so_far) {
    return traits_of_boxes(capture, so_far, config);
  };
  return stages;
}

const PipelineRow& strawberries_pipeline();
const PipelineRow& row_of(const StrawberriesPipelineConfig& /*config*/) {
  return strawberries_pipeline();
}

const PipelineRow& strawberries_pipeline() {
  static constexpr auto kOrder =
      std::to_array<std::string_view>({"boxes", "depth", "fits", "traits"});
  static const PipelineRow kRow = {
      .name = "strawberries",
      .help = "where each fruit is, its size and where to cut it, from boxes and a depth camera",
      .scenes = {"strawberries"},
      .order = kOrder,
      .from_outside = {"boxes"},
      .traits_of = TraitsOf::boxes,
      .traits = {"point_x",    "point_y", "point_z",  "distance", "centre_x",   "centre_y",
                 "centre_z",   "calyx_x", "calyx_y",  "calyx_z",  "cut_x",      "cut_y",
                 "cut_z",      "axis_x",  "axis_y",   "axis_z",   "approach_x", "approach_y",
                 "approach_z", "length",  "diameter", "volume",   "red_share"},
      .methods = {{"ours",
                   "a curved patch through the depths about the middle of a box, and the most "
                   "probable whole fruit by a prior of shapes, with their uncertainty"},
                  {"paper",
                   "the paper's rule: depth under the middle of a box, or the mean of 5 x 5 where "
                   "there is none; no size"},
                  {"ellipsoid", "the upright ellipsoid that fills the box, at the depth there"},
                  {"cone", "the same box as a truncated cone"}},
      .defaults = [] { return PipelineConfig(StrawberriesPipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
