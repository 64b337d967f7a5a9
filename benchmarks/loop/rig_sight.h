#pragma once

#include "scenes/row/scene_row.h"
#include "sim/sensors/device.h"

namespace cousin {

/// What scenes may know of a rig: the camera that its first images come from, as its preset has it,
/// and of its cameras the longest readout.
RigSight sight_of(const DeviceConfig& rig);

}  // namespace cousin
