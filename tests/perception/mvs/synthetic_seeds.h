#pragma once

#include <vector>

#include "sim/types/board.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// An ellipsoid that lies on the board: radii along its own x, y and z, turned about z. Grey if not
/// coloured.
struct SyntheticSeed {
  double x_m = 0, y_m = 0;
  Eigen::Vector3d radii_m{0.004, 0.003, 0.002};
  double yaw_rad = 0;
  bool colored = true;
  Eigen::Vector3d centre_in_world_m() const { return {x_m, y_m, radii_m.z()}; }
};

/// Unit, of the ellipsoid that is as large as the point needs it to be.
Eigen::Vector3d outward_normal(const SyntheticSeed& seed, const Eigen::Vector3d& in_world_m);

struct SyntheticScene {
  std::vector<SyntheticSeed> seeds;
  SeedBoard board;
  double texture = 0.3;      ///< relative amplitude of the seeds' pattern
  double noise_codes = 1.0;  ///< standard deviation of each 8-bit value
  int supersampling = 3;     ///< samples a pixel along each axis
  double footprint_px =
      2;  ///< side of the square that a pixel averages: its own and the lens's blur
};

/// What a pixel's ray meets first: 0.. = seed, -1 = board's plane inside the plate, -2 = nothing.
struct SyntheticHit {
  int object = -2;
  double distance_m = 0;  ///< along the unit ray
};
SyntheticHit trace(const SyntheticScene& scene, const Eigen::Vector3d& origin_m,
                   const Eigen::Vector3d& direction);

struct SyntheticViews {
  Capture capture;
  Poses poses;                             ///< the true ones
  std::vector<Image<float>> depth_m;       ///< true, at pixel centres; NaN where nothing is
  std::vector<Image<std::int8_t>> object;  ///< as in SyntheticHit
};

/// Pictures by analytic intersection with ellipsoids and plane, from cameras that look at the
/// board's centre.
SyntheticViews make_views(const SyntheticScene& scene, const Camera& camera,
                          const std::vector<Eigen::Vector3d>& eyes_in_world_m, std::uint64_t seed);

/// Three rings of eyes at the elevations 35, 55 and 75 degrees, a third of the views each.
std::vector<Eigen::Vector3d> three_rings(int views, double nearest_m, double farthest_m);

/// Ten seeds of maize, wheat and rice size, apart from each other.
SyntheticScene ten_seeds();

/// A phone-like lens of each model for an image of this size.
Camera synthetic_camera(LensModel model, int width_px, int height_px, double focal_px);

}  // namespace cousin
