#pragma once

#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"

namespace cousin {

/// One photograph to learn from: undistorted, with its pose. Eight bits a channel, so that many
/// views fit into memory.
struct SplatView {
  Camera camera;  ///< pinhole, of the photograph's size
  Pose camera_from_world;
  Image<Rgb8> photograph;  ///< sRGB-encoded
  Image<std::uint8_t>
      weight;  ///< of the same size, 255 = counts wholly, 0 = not at all; empty = all
};

}  // namespace cousin
