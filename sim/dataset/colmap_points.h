#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// A point of COLMAP's sparse model, in the model's world and unit.
struct ColmapStartPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Rgb8 color;
  double error_px = 0;  ///< mean reprojection error; -1 = COLMAP did not compute it
  int views = 0;        ///< length of its track
};

/// Points of a points3D.txt or points3D.bin, in the file's order. Points that are not finite are an
/// error. @param name  of the file, for errors. @throws std::runtime_error naming it, line or byte,
/// value and limit.
std::vector<ColmapStartPoint> colmap_points_from_text(std::string_view text,
                                                      const std::string& name);
std::vector<ColmapStartPoint> colmap_points_from_binary(std::string_view bytes,
                                                        const std::string& name);

}  // namespace cousin
