#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/types/mesh.h"
#include "sim/types/seams.h"

namespace cousin {

/// A star-shaped surface sampled at unit directions: mesh vertex i lies at parameter directions[i].
struct SampledSurface {
  Mesh mesh;                             ///< in the world
  std::vector<Eigen::Vector3d> normals;  ///< unit, outward, one for each vertex
};
/// Normals of vertices: the area-weighted mean of their triangles'.
std::vector<Eigen::Vector3d> vertex_normals(const Mesh& mesh);

/// One piece of the line that separates the side of a surface seen by a camera from its far side.
struct ContourSegment {
  Eigen::Vector2d begin_px, end_px;
  Eigen::Vector2d outward;         ///< in the image, unit: the projected surface normal
  Eigen::Vector3d begin_u, end_u;  ///< parameter directions of the ends, not normalised
};

/// The contour generator of a smooth surface is where its normal is perpendicular to the ray. Here
/// the zero line of that product, linear on each triangle [Hertzmann & Zorin, SIGGRAPH 2000],
/// projected through the lens. Folds and pieces hidden behind others are not removed. `directions`
/// holds a parameter for each vertex.
std::vector<ContourSegment> apparent_contour(const SampledSurface& surface,
                                             const std::vector<Eigen::Vector3d>& directions,
                                             const FramePose& view);

/// Where the line pixel + t * normal meets a contour: the outermost crossing with |t| <= limit_px
/// whose outward direction agrees with the normal to within 60 degrees.
struct ContourCrossing {
  double t_px = 0;
  Eigen::Vector3d direction;  ///< parameter, unit
};
std::optional<ContourCrossing> cross_contour(const std::vector<ContourSegment>& contour,
                                             const Eigen::Vector2d& pixel_px,
                                             const Eigen::Vector2d& normal, double limit_px);

}  // namespace cousin
