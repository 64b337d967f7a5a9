#include "sim/sensors/row_occlusion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace cousin {

Image<std::uint8_t> hidden_along_rows(const Image<float>& depth_m, double focal_px, double x_m) {
  constexpr float kTolerance_px = 0.25F;  // neighbours on a steep slope meet one pixel
  const int width = depth_m.width(), step = x_m >= 0 ? -1 : 1;
  const auto scale = static_cast<float>(focal_px * x_m);
  Image<std::uint8_t> hidden(width, depth_m.height(), std::uint8_t{0});
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    float nearest = std::numeric_limits<float>::infinity();
    for (int k = 0, x = step < 0 ? width - 1 : 0; k < width; ++k, x += step) {
      const float z = depth_m(x, y);
      if (!(z > 0)) continue;
      const float seen = -static_cast<float>(step) * (static_cast<float>(x) - scale / z);
      if (seen > nearest + kTolerance_px) hidden(x, y) = 1;
      nearest = std::min(nearest, seen);
    }
  });
  return hidden;
}

}  // namespace cousin
