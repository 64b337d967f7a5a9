#pragma once

#include "perception/stereo/sensor_depth.h"

namespace cousin {

/// A depth camera's depth in the pixels of the first sensor, where no pose is known: as
/// depths_of_sensor, in each camera's own axes, but read between the depth camera's pixels where
/// each pixel's ray meets the surface. What is drawn pixel by pixel instead, nearest first, brings
/// slopes nearer by up to a pixel's part of them: a fruit would be flatter. At steps of depth there
/// is none.
/// Of `config` sigma_px and max_sigma_m count; sigma is NaN where the rig reports no infrared pair.
/// @throws std::invalid_argument if the configuration is invalid
Depths gathered_depths(const Capture& capture, const SensorDepthConfig& config = {});

}  // namespace cousin
