#pragma once

#include "perception/stereo/sensor_depth.h"

namespace cousin {

/// Depth of a depth camera in the pixels of the first sensor, in its axes; no pose is needed. Each
/// pixel's ray is followed to where it meets the surface between depth pixels. Drawing depth pixels
/// nearest first would bring slopes nearer by up to a pixel's part of them, and flatten a fruit. A
/// pixel at a step of depth has no depth. Only sigma_px and max_sigma_m of `config` are used; sigma
/// is NaN where the rig reports no infrared pair.
/// @throws std::invalid_argument if the configuration is invalid
Depths gathered_depths(const Capture& capture, const SensorDepthConfig& config = {});

}  // namespace cousin
