#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/config/fields.h"
#include "sim/types/capture.h"
#include "sim/types/pose.h"

namespace cousin {

/// One calibrated silhouette: non-zero = object.
struct CarveView {
  Camera camera;
  Pose camera_from_world;
  Image<std::uint8_t> mask;
};

struct CarveConfig {
  double voxel_m = 0.008;             ///< side of the finest voxels
  Eigen::Vector3d low_m{-1, -1, -1};  ///< volume that is carved
  Eigen::Vector3d high_m{1, 1, 1};
  int tolerated_misses = 0;  ///< views that may not see a voxel of the object
};
void validate(const CarveConfig& config);

enum class CarveStatus { ok, no_views, empty };
struct Carving {
  CarveStatus status = CarveStatus::no_views;
  double voxel_m = 0;
  std::vector<Eigen::Vector3d>
      centres_m;  ///< of filled voxels on the grid low_m + (i + 1/2) voxel_m, in x, y, z order
};

/// Visual hull [Laurentini, PAMI 1994] on a grid, coarse to fine: a cube stays while, in all views
/// but the tolerated ones, the square that bounds its projection holds object pixels (counted by
/// summed-area tables). At the finest level the square has the voxel's own projected side. A voxel
/// outside a view's image, and a coarser cube that reaches out of it, is not carved by that view.
Carving carve_visual_hull(const std::vector<CarveView>& views, const CarveConfig& config);

/// Views of an imported capture whose images are silhouettes (any channel above 127 = object);
/// frames without a pose are left out.
std::vector<CarveView> silhouette_views(const Capture& capture);

}  // namespace cousin
