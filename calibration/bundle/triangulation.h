#pragma once

#include <Eigen/Core>
#include <limits>
#include <string_view>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// Where one image shows a point.
struct PointSighting {
  Camera lens;
  Pose camera_from_world;
  Eigen::Vector2d pixel_px;
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
};

struct TriangulationConfig {
  double min_parallax_rad = 0;     ///< rays that part by less are `parallel` at once
  double min_depth_sigmas = 4;     ///< least 1 / distance over its deviation
  double max_residual_sigmas = 5;  ///< RMS of the residuals over their deviations
};

/// `parallel`: the rays do not tell the distance from infinity. `behind`: they meet behind a
/// camera. `disagree`: no point explains all sightings. `no_direction`: a pixel has no ray through
/// its lens.
enum class TriangulationStatus { ok, too_few, no_direction, parallel, behind, disagree };
std::string_view to_string(TriangulationStatus status);

struct Triangulation {
  TriangulationStatus status = TriangulationStatus::too_few;
  /// Meaningful when status is ok; else NaN.
  Eigen::Vector3d in_world_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Matrix3d covariance_m2 =
      Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());  ///< first order
  double parallax_rad = 0;  ///< largest angle between two rays
  double depth_sigmas = 0;  ///< 1 / distance over its deviation, from the first camera
  double residual_sigmas = std::numeric_limits<double>::quiet_NaN();  ///< RMS a freedom
};

/// The point that two or more images show: least squares on pixels over (x/z, y/z, 1/z) of the
/// first camera, in which far points are as well conditioned as near ones [Civera, Davison &
/// Montiel, IEEE T-RO 2008], from the point nearest to all rays.
Triangulation triangulate(const std::vector<PointSighting>& sightings,
                          const TriangulationConfig& config = {});

/// The point nearest to lines by least squares of the distances; `directions` are unit. Lines that
/// are parallel give a point of no meaning.
Eigen::Vector3d nearest_to_lines(const std::vector<Eigen::Vector3d>& origins_m,
                                 const std::vector<Eigen::Vector3d>& directions);

}  // namespace cousin
