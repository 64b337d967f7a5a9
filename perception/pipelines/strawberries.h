#pragma once

#include <cstdint>
#include <string_view>

#include "perception/fruit/fruit_fit.h"
#include "perception/fruit/fruit_place.h"
#include "perception/fruit/fruit_point.h"
#include "perception/fruit/red_share.h"
#include "perception/pipelines/estimate.h"
#include "perception/pipelines/pipeline_needs.h"
#include "perception/pipelines/seeds_splats.h"
#include "perception/stereo/sensor_depth.h"

namespace cousin {

/// How places and sizes follow from a box; help texts are in its row. `paper` knows the surface's
/// point alone.
enum class StrawberriesMethod { ours, paper, ellipsoid, cone };

FruitSurfaceConfig strawberry_surface();
FruitFitConfig strawberry_fit();

/// Each fruit of each image by itself: no pose is needed, and none is found. Boxes come from
/// outside, with instance masks for all but the paper's rule: there is no detector yet.
struct StrawberriesPipelineConfig {
  StrawberriesMethod method = StrawberriesMethod::ours;
  SensorDepthConfig sensor_depth{.max_sigma_m = 0.05, .level_on_plate = false};
  FruitPointConfig point;
  FruitSurfaceConfig surface = strawberry_surface();
  FruitPrior prior = strawberry_prior();
  FruitFitConfig fit = strawberry_fit();
  StalkPrior stalk;
  RedShareConfig red;
};
Fields fields(StrawberriesPipelineConfig& config);
void validate(const StrawberriesPipelineConfig& config);
std::string_view to_string(StrawberriesMethod method);

PipelineNeeds needs(const StrawberriesPipelineConfig& config);
/// A sentence for each setting that the method does not use.
std::vector<std::string> unused_settings(const StrawberriesPipelineConfig& config);
/// @throws std::invalid_argument if the capture has no depth
void check_capture(const Capture& capture, const StrawberriesPipelineConfig& config);

/// Stages depth, fits (not by `paper`) and traits, which are of one box each
/// (SpecimenTraits::frame). Places are in the axes of that image's camera: point (the surface under
/// the middle of the box) and distance from it, centre, calyx, cut (on the stalk). Unit vectors are
/// the axis, from tip to calyx, and the approach, a gripper's way to the cut. Then length,
/// diameter, volume, red_share. What is not known of a box is left out, and the reason says why.
Stages stages_for(const StrawberriesPipelineConfig& config, const Capture& capture,
                  std::uint64_t seed, const SplatWatch& watch);
struct PipelineRow;
const PipelineRow& row_of(const StrawberriesPipelineConfig& config);

}  // namespace cousin
