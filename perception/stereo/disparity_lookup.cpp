#include "perception/stereo/disparity_lookup.h"

#include <algorithm>
#include <cmath>

namespace cousin {

KnownDisparity disparity_at(const Image<float>& disparity_px, const Image<float>& sigma_px,
                            const Eigen::Vector2d& pixel) {
  constexpr float kSameSurface_px = 1;
  const int near_x = static_cast<int>(std::lround(pixel.x()));
  const int near_y = static_cast<int>(std::lround(pixel.y()));
  if (!disparity_px.contains(near_x, near_y)) return {};
  const KnownDisparity nearest{disparity_px(near_x, near_y),
                               sigma_px.empty() ? kNone : sigma_px(near_x, near_y)};
  const int x = static_cast<int>(std::floor(pixel.x()));
  const int y = static_cast<int>(std::floor(pixel.y()));
  if (!disparity_px.contains(x, y) || !disparity_px.contains(x + 1, y + 1)) return nearest;
  const float d[4] = {disparity_px(x, y), disparity_px(x + 1, y), disparity_px(x, y + 1),
                      disparity_px(x + 1, y + 1)};
  const auto [low, high] = std::minmax_element(std::begin(d), std::end(d));
  const bool all_there = !std::isnan(d[0] + d[1] + d[2] + d[3]);
  if (!all_there || *high - *low > kSameSurface_px) return nearest;
  const auto a = static_cast<float>(pixel.x() - x), b = static_cast<float>(pixel.y() - y);
  return {(1 - b) * ((1 - a) * d[0] + a * d[1]) + b * ((1 - a) * d[2] + a * d[3]),
          nearest.sigma_px};
}

}  // namespace cousin
