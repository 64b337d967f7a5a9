#pragma once

#include <array>
#include <cstddef>

#include "perception/splats/splat_model.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"

namespace cousin {

struct SplatRenderConfig {
  std::array<float, 3> background{};  ///< shows where transmittance is left
  double near = 0.01;  ///< centres nearer than this share of the median depth are left out
  /// In place of the model's own; 0 = that one. The reference's 0.3 reaches over the edge of what
  /// is some pixels wide: for depths take a tenth.
  double low_pass_px2 = 0;
  /// Of Gaussians with the tiles they cover, 16 bytes each: an image of more is drawn some rows of
  /// tiles at a time.
  std::size_t most_pairs = std::size_t{1} << 26;
};

/// Three channels of one image, each 0..1 and planar: red, green, blue.
struct ColorPlanes {
  std::array<Image<float>, 3> channel;
};

/// One view of a model. All images are of the camera's size.
struct SplatImage {
  ColorPlanes color;   ///< front to back, over the background
  Image<float> alpha;  ///< 1 - transmittance
  /// Along the axis, of the Gaussian at which transmittance falls through 1/2, where the pixel's
  /// ray is deepest in it (as in the plane of a flat one, at most four times its centre's depth);
  /// NaN = never.
  Image<float> depth_m;
  Image<float>
      mean_depth_m;  ///< mean of the Gaussians' depths weighted as their colours are; NaN = alpha 0
};

/// Renders with the fast kernels. @param camera  pinhole
/// @throws std::invalid_argument of another lens, sh_degree outside 0..3, a low pass
/// that is not above 0; TooManyPairs if one row of tiles has more than `most_pairs`.
SplatImage render_splats(const SplatModel& model, const Camera& camera,
                         const Pose& camera_from_world, const SplatRenderConfig& config = {});

}  // namespace cousin
