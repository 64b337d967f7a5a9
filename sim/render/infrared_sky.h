#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// Light of skies and environments in one pixel, before and after what hides them. Private to
/// sim/render.
struct SkyPixel {
  float ambient = 0;  ///< radiance by an open sky, summed over the pixel's samples
  float asked = 0;    ///< weights of the pixel's shadow rays: the sky's radiance along them
  float open = 0;     ///< of those that met nothing
  // The first sample's surface.
  int surface = -1;
  float distance_m = 0;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
};

/// Shadow rays are laid over squares of this many pixels a side: each pixel takes its own part of
/// one pattern, and any such square holds the whole [interleaved sampling: Keller & Heidrich, EGWR
/// 2001].
inline constexpr int kSkyTile_px = 4;

/// Direction about a unit normal whose density goes as its cosine, of a point in [0, 1)^2.
Eigen::Vector3f cosine_direction(const Eigen::Vector3f& normal, const Eigen::Vector2f& u);

/// Share of a pixel's sky that is open: over the square of pixels about it that show the same
/// surface at about the same distance, turned by less than 25 degrees. 1 where nothing was asked.
float open_sky(const Image<SkyPixel>& pixels, int x, int y);

}  // namespace cousin
