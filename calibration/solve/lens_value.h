#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/types/camera.h"

namespace cousin {

/// What of a lens does not change while it is solved for.
struct LensShape {
  LensModel model = LensModel::pinhole;
  SplineLens grid;  ///< of a splined lens: its delta_u is not used
};
LensShape shape_of(const Camera& camera);

/// fx, fy, cx, cy, then distortion, or the spline's delta_u.
int lens_parameter_count(const LensShape& shape);
/// In that order: "fx_px", ..., "k1", ..., "u0_x", ...
std::vector<std::string> lens_parameter_names(const LensShape& shape);
Eigen::VectorXd lens_parameters(const Camera& camera);
/// The camera `like` with other parameters.
Camera with_parameters(const Camera& like, const Eigen::VectorXd& parameters);

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct LensValue {
  Eigen::Vector2d pixel_px;
  Eigen::Matrix<double, 2, 3> d_point;
};
/// As `project`, but lets the lens fold and the spline's outermost pieces go on: a search for the
/// parameters must be able to pass through lenses that are not valid. False where a point has no
/// pixel at all (behind a perspective lens, at the centre, a denominator that is not positive).
/// @param d_parameters  2 x lens_parameter_count, row by row, or null; overwritten
bool lens_value(const LensShape& shape, const double* parameters,
                const Eigen::Vector3d& point_in_camera, LensValue& value, double* d_parameters);

}  // namespace cousin
