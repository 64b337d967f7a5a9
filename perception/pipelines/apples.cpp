#include "perception/pipelines/apples.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "perception/fruit/fruit_seam.h"
#include "perception/pipelines/pipeline_table.h"
#include "perception/pipelines/seen_boxes.h"
#include "sim/config/changed_keys.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<Named<ApplesMethod>, 6> kApplesMethods = {
    {{ApplesMethod::ours, "ours"},
     {ApplesMethod::paper, "paper"},
     {ApplesMethod::sphere, "sphere"},
     {ApplesMethod::ellipsoid, "ellipsoid"},
     {ApplesMethod::hull, "hull"},
     {ApplesMethod::allometry, "allometry"}}};

FruitFit fit_of(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                const FruitKind& kind, const ApplesPipelineConfig& config, std::uint64_t seed) {
  if (config.method == ApplesMethod::paper)
    return fit_clv(depth, camera, box, config.clv,
                   Rng(seed).fork("clv").fork(static_cast<std::uint64_t>(box.id)));
  FruitSurfaceConfig seen = config.surface;
  if (config.method == ApplesMethod::hull) seen.rim_px = std::min(seen.rim_px, 1.5);
  const FruitSurface surface = fruit_surface(depth, camera, box, seen);
  switch (config.method) {
    case ApplesMethod::sphere:
      return fit_sphere(surface, config.prior);
    case ApplesMethod::ellipsoid:
      return fit_ellipsoid(surface, config.prior);
    case ApplesMethod::hull:
      return fit_hull(surface, config.prior);
    case ApplesMethod::allometry:
      return fit_allometry(surface, config.prior);
    default:
      return fit_fruit(surface, kind, config.fit);
  }
}

Fits fits_of(const Capture& capture, const Estimate& so_far, const ApplesPipelineConfig& config,
             std::uint64_t seed) {
  const std::vector<SeenBox> boxes = seen_boxes(capture, so_far, "fits");
  const FruitKind kind = kind_of(config.prior);
  Fits fits(boxes.size());
  tbb::parallel_for(std::size_t{0}, boxes.size(), [&](std::size_t i) {
    const SeenBox& seen = boxes[i];
    fits[i] = seam_of(fit_of(*seen.depth, seen.image->reported, *seen.box, kind, config, seed),
                      seen.box->id, "fruit by " + std::string(to_string(config.method)));
  });
  return fits;
}

SpecimenTraits traits_of_fit(const ObjectFit& fit, int frame, const FruitPrior& prior) {
  SpecimenTraits traits;
  traits.instance = fit.instance;
  traits.frame = frame;
  traits.status = fit.status == FitStatus::ok ? TraitStatus::ok : TraitStatus::not_solved;
  traits.reason = fit.reason;
  constexpr std::pair<const char*, const char*> kSizesOfFit[] = {
      {"diameter", "m"}, {"length", "m"}, {"volume", "m3"}};
  for (const auto& [name, unit] : kSizesOfFit) {
    const FruitMeasure size = parameter_of(fit, name);
    if (std::isfinite(size.value)) traits.traits.push_back({name, unit, size.value, size.sigma});
  }
  const bool has_all = traits.traits.size() == std::size(kSizesOfFit);
  if (!has_all && traits.status == TraitStatus::ok) {
    traits.status = TraitStatus::not_solved;
    traits.reason = "its fit has not all of diameter, length and volume";
  }
  const FruitMeasure volume_m3 = parameter_of(fit, "volume");
  if (!std::isfinite(volume_m3.value)) return traits;
  const double mass_kg = prior.density_kg_m3 * volume_m3.value;
  traits.traits.push_back({"mass", "kg", mass_kg,
                           mass_kg * std::hypot(volume_m3.sigma / volume_m3.value,
                                                prior.sigma_density_kg_m3 / prior.density_kg_m3)});
  return traits;
}

Traits traits_of(const Capture& capture, const Estimate& so_far,
                 const ApplesPipelineConfig& config) {
  const std::map<int, const ObjectFit*> fit_of_box = fits_by_box(so_far.fits);
  FruitPrior prior = config.prior;
  if (config.method == ApplesMethod::paper) prior.density_kg_m3 = config.clv.density_kg_m3;
  Traits traits;
  for (const SeenBox& seen : seen_boxes(capture, so_far, "traits")) {
    const int id = seen.box->id, frame = seen.box->frame;
    const auto fit = fit_of_box.find(id);
    if (fit == fit_of_box.end()) {
      traits.push_back({.instance = id, .frame = frame, .reason = "no fit is of it"});
      continue;
    }
    traits.push_back(traits_of_fit(*fit->second, frame, prior));
  }
  return traits;
}

}  // namespace

std::string_view to_string(ApplesMethod method) {
  return name_in<ApplesMethod>(kApplesMethods, method);
}

Fields fields(ApplesPipelineConfig& c) {
  return Fields{{"method", choice_field<ApplesMethod>("method", kApplesMethods, c.method),
                 "how an apple's size follows from its box"}} +
         nested("sensor_depth", fields(c.sensor_depth)) + nested("surface", fields(c.surface)) +
         nested("prior", fields(c.prior)) + nested("fit", fields(c.fit)) +
         nested("clv", fields(c.clv));
}

void validate(const ApplesPipelineConfig& config) {
  validate(config.sensor_depth);
  validate(config.surface);
  validate(config.prior);
  validate(config.fit);
  validate(config.clv);
}

PipelineNeeds needs(const ApplesPipelineConfig&) {
  return {.images = {"depth"}, .stages = {"boxes", "depth", "fits", "traits"}, .left_out = {}};
}

std::vector<std::string> unused_settings(const ApplesPipelineConfig& config) {
  const std::string_view method = to_string(config.method);
  if (config.method == ApplesMethod::ours) return keys_without_effect(config, method, {"clv."});
  if (config.method == ApplesMethod::paper)
    return keys_without_effect(config, method, {"surface.", "fit."});
  return keys_without_effect(config, method, {"clv.", "fit."});
}

void check_capture(const Capture& capture, const ApplesPipelineConfig& config) {
  if (has_sensor_depth(capture)) return;
  throw std::invalid_argument("method " + std::string(to_string(config.method)) +
                              " of apples reads depth images, and the capture has none");
}

Stages stages_for(const ApplesPipelineConfig& config, const Capture& /*capture*/,
                  std::uint64_t seed, const SplatWatch& /*watch*/) {
  Stages stages;
  stages.depths = [config](const Capture& capture, const Estimate&) {
    return gathered_depths(capture, config.sensor_depth);
  };
  stages.fits = [config, seed](const Capture& capture, const Estimate& so_far) {
    return fits_of(capture, so_far, config, seed);
  };
  stages.traits = [config](const Capture& capture, const Estimate& so_far) {
    return traits_of(capture, so_far, config);
  };
  return stages;
}

const PipelineRow& apples_pipeline();
const PipelineRow& row_of(const ApplesPipelineConfig& /*config*/) { return apples_pipeline(); }

const PipelineRow& apples_pipeline() {
  static constexpr auto kOrder =
      std::to_array<std::string_view>({"boxes", "depth", "fits", "traits"});
  static const PipelineRow kRow = {
      .name = "apples",
      .help = "size, volume and mass of each apple, hidden in part, from boxes and a depth camera",
      .scenes = {"apples"},
      .order = kOrder,
      .from_outside = {"boxes"},
      .traits_of = TraitsOf::boxes,
      .traits = {"diameter", "length", "volume", "mass"},
      .methods = {{"ours",
                   "the most probable whole surface by a prior of shapes, depths and the outline, "
                   "with its uncertainty"},
                  {"paper",
                   "the paper's chain: box and depth give a deformed sphere; its convex hull, "
                   "corrected by sphericity"},
                  {"sphere", "the sphere through the visible surface"},
                  {"ellipsoid", "the ellipsoid through the visible surface"},
                  {"hull", "the convex hull of the visible surface and its mirror image"},
                  {"allometry", "the circle through the outline, and the kind's mean shape"}},
      .defaults = [] { return PipelineConfig(ApplesPipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
