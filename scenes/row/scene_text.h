#pragma once

#include <string_view>

namespace cousin {

/// What `cousin scenes` says of a scene, whether it is built in or not.
struct SceneText {
  std::string_view name;
  std::string_view help;
  bool needs_physics = false;
  bool has_points = false;  ///< keypoints are what its views are for: part of the default truth
};

}  // namespace cousin
