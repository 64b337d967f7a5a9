#pragma once

#include <vector>

#include "sim/types/board.h"
#include "sim/types/capture.h"
#include "sim/types/rng.h"
#include "sim/types/seams.h"

namespace cousin {

/// An ellipsoid with axes along the world's, for ray casting.
struct CastEllipsoid {
  Eigen::Vector3d centre_m, semi_axes_m;
  Eigen::Vector3d albedo = {0.6, 0.36, 0.10};
};

/// A small pinhole camera that looks at the origin.
FramePose small_pose(int frame, double azimuth_rad, double elevation_rad, double distance_m);

/// Ellipsoids on the board, ray cast with 36 samples a pixel, lit from above with a soft shadow
/// about each, blurred with `blur_sigma_px`, with shot noise, in 8-bit sRGB.
Image<Rgb8> photograph(const std::vector<CastEllipsoid>& objects, const SeedBoard& board,
                       const FramePose& pose, double blur_sigma_px, Rng rng);

}  // namespace cousin
