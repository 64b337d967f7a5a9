#pragma once

#include "sim/types/camera.h"
#include "sim/types/rng.h"

namespace cousin {

/// Growth of the focal length in pixels when focused at `distance_m` instead of infinity, by the
/// thin-lens law: image distance over focal length = 1 + f / (Z - f). @throws std::invalid_argument
/// for Z <= 2 f.
double focus_breathing(double focal_m, double distance_m);

/// Spread of one device's lens about its model's, and of what it reports about itself; sigmas of
/// normals cut at 2.5 sigmas.
struct LensSpread {
  double centre_px = 0;          ///< of the true principal point
  double report_focal = 0;       ///< relative
  double report_centre_px = 0;   ///< each coordinate
  double report_distortion = 0;  ///< relative, each coefficient; a spline as a whole
};

/// One particular lens, focused at infinity, and what its device says of it.
struct LensUnit {
  Camera at_infinity;
  Camera reported_at_infinity;
};
/// @throws std::invalid_argument if a drawn lens folds inside the image.
LensUnit draw_lens(const Camera& nominal, const LensSpread& spread, const Rng& rng);

/// The lens at a focal length `breathing` times that at infinity.
Camera with_focus(Camera camera, double breathing);

/// What a device reports when its true lens is `now`: it knows its focus through the lens position,
/// with a relative error of the distance of sigma `focus_error`.
Camera report_at_focus(const LensUnit& unit, const Camera& now, double focal_m, double focus_error,
                       const Rng& rng);

}  // namespace cousin
