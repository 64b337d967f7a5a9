#pragma once

#include <cstdint>
#include <string_view>

#include "perception/fruit/fruit_point.h"
#include "perception/pipelines/estimate.h"
#include "perception/pipelines/pipeline_needs.h"
#include "perception/pipelines/seeds_splats.h"
#include "perception/stereo/sensor_depth.h"

namespace cousin {

/// `ours` fits a curved patch to a window of depths; `paper` reads the depth under the middle of a
/// box, or a 5 x 5 window's [Strawberries 2.6]. Both take boxes from outside: there is no detector
/// yet.
enum class StrawberriesMethod { ours, paper };

/// Each fruit of each image by itself: no pose is needed, and none is found.
struct StrawberriesPipelineConfig {
  StrawberriesMethod method = StrawberriesMethod::ours;
  SensorDepthConfig sensor_depth{.max_sigma_m = 0.05, .level_on_plate = false};
  FruitPointConfig point;
};
Fields fields(StrawberriesPipelineConfig& config);
void validate(const StrawberriesPipelineConfig& config);
std::string_view to_string(StrawberriesMethod method);

PipelineNeeds needs(const StrawberriesPipelineConfig& config);
/// @throws std::invalid_argument if the capture has no depth
void check_capture(const Capture& capture, const StrawberriesPipelineConfig& config);

/// Stages depth and traits. Traits are of one box each (SpecimenTraits::frame): point_x, point_y,
/// point_z in the axes of that image's camera, and distance from it.
Stages stages_for(const StrawberriesPipelineConfig& config, const Capture& capture,
                  std::uint64_t seed, const SplatWatch& watch);
struct PipelineRow;
const PipelineRow& row_of(const StrawberriesPipelineConfig& config);

}  // namespace cousin
