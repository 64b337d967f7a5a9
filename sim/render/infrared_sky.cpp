#include "sim/render/infrared_sky.h"

#include <algorithm>
#include <cmath>

#include "sim/render/sample_points.h"

namespace cousin {

Eigen::Vector3f cosine_direction(const Eigen::Vector3f& normal, const Eigen::Vector2f& u) {
  const Eigen::Vector2f disk = concentric_disk(u);
  const float up = std::sqrt(std::max(0.0F, 1 - disk.squaredNorm()));
  return frame_about(normal) * Eigen::Vector3f(disk.x(), disk.y(), up);
}

float open_sky(const Image<SkyPixel>& pixels, int x, int y) {
  constexpr float kCosine = 0.9F, kDistance = 0.05F;
  const SkyPixel& own = pixels(x, y);
  float open = 0, asked = 0;
  constexpr int kBefore = (kSkyTile_px - 1) / 2;
  for (int j = y - kBefore; j < y - kBefore + kSkyTile_px; ++j) {
    for (int i = x - kBefore; i < x - kBefore + kSkyTile_px; ++i) {
      if (!pixels.contains(i, j)) continue;
      const SkyPixel& other = pixels(i, j);
      if (other.surface != own.surface || other.normal.dot(own.normal) < kCosine ||
          std::abs(other.distance_m - own.distance_m) > kDistance * own.distance_m) {
        continue;
      }
      open += other.open;
      asked += other.asked;
    }
  }
  return asked > 0 ? open / asked : 1;
}

}  // namespace cousin
