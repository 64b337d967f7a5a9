#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sim/dataset/yaml_values.h"

namespace cousin {

/// Private to sim/dataset: what a calibration says of the numbers of depth images.
struct DepthKeys {
  std::optional<double> unit_m;  ///< of whole numbers
  std::string unit_key;          ///< "intrinsics.json: depth_scale"
  std::uint16_t none = 0;        ///< whole number that means none
  std::uint16_t most = 65534;    ///< whole numbers above it are none
  std::optional<bool> aligned;   ///< whether depth is in the colour image's pixels
};

/// depth_unit_m; depth_unit ("mm"); depth_scale, DepthMapFactor and the like: below 0.1 metres a
/// unit, as librealsense's, from 100 on units a metre, as Open3D's; no_depth, max_depth, aligned;
/// BoofCV's model visual_depth, which is aligned.
/// @throws std::runtime_error naming file, key, value and limit: two units that differ, and keys
/// that speak of depth, units, scales or extrinsics and are not read.
DepthKeys read_depth_keys(const YamlValues& values);

}  // namespace cousin
