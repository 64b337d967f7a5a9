#pragma once

#include <cstdint>
#include <string_view>

#include "perception/fruit/fruit_clv.h"
#include "perception/fruit/fruit_comparators.h"
#include "perception/fruit/fruit_fit.h"
#include "perception/pipelines/estimate.h"
#include "perception/pipelines/pipeline_needs.h"
#include "perception/pipelines/seeds_splats.h"
#include "perception/stereo/gathered_depth.h"

namespace cousin {

/// How an apple's size follows from its box; help texts are in its row.
enum class ApplesMethod { ours, paper, sphere, ellipsoid, hull, allometry };

/// Each fruit of each image by itself: no pose is needed, and none is found. Boxes with instance
/// masks come from outside: there is no detector yet.
struct ApplesPipelineConfig {
  ApplesMethod method = ApplesMethod::ours;
  SensorDepthConfig sensor_depth{.max_sigma_m = 0.05, .level_on_plate = false};
  FruitSurfaceConfig surface;
  FruitPrior prior;
  FruitFitConfig fit;
  ClvConfig clv;
};
Fields fields(ApplesPipelineConfig& config);
void validate(const ApplesPipelineConfig& config);
std::string_view to_string(ApplesMethod method);

PipelineNeeds needs(const ApplesPipelineConfig& config);
/// A sentence for each setting that the method does not use.
std::vector<std::string> unused_settings(const ApplesPipelineConfig& config);
/// @throws std::invalid_argument if the capture has no depth
void check_capture(const Capture& capture, const ApplesPipelineConfig& config);

/// Stages depth, fits and traits. A fit and its traits are of one box each: their instance is the
/// box's id, and a fit's centre is in the axes of that image's camera. Traits: diameter, length,
/// volume, mass. A box that is not measured has a reason, and by `ours` what is known of the kind.
Stages stages_for(const ApplesPipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch);
struct PipelineRow;
const PipelineRow& row_of(const ApplesPipelineConfig& config);

}  // namespace cousin
