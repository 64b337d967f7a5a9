#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace cousin {

/// Correction surface of mrcal's LENSMODEL_SPLINED_STEREOGRAPHIC: a point's stereographic image u =
/// 2 tan(theta / 2) (x, y) / |(x, y)| is moved by delta(u), a uniform B-spline surface, before
/// focal length and principal point apply [mrcal 2.2, lensmodels documentation].
struct SplineLens {
  int order = 3;                ///< 2: quadratic, C1; 3: cubic, C2
  int columns = 0;              ///< control points along u_x, evenly spaced about 0
  int rows = 0;                 ///< along u_y, as far apart as the columns
  double fov_x_rad = 0;         ///< angle between the left and the right end of the surface
  std::vector<double> delta_u;  ///< (x, y) of each control point, row by row; no unit, as u

  bool operator==(const SplineLens&) const = default;
};

/// Order 2 or 3; at least order + 1 and at most 1024 control points along each side, at most 16384
/// in all; field of view in (0, 6.2]; delta_u finite, in [-100, 100], of the right length.
/// @throws std::invalid_argument naming field, value and limit.
void validate(const SplineLens& lens);

/// Largest |u_x| and |u_y| that the surface covers; beyond, its polynomials would be extrapolated.
Eigen::Vector2d half_extent(const SplineLens& lens);

/// u + delta(u) with its derivative; nothing where the surface does not reach.
struct SplinePoint {
  Eigen::Vector2d value;
  Eigen::Matrix2d d_u;
};
std::optional<SplinePoint> bent(const SplineLens& lens, const Eigen::Vector2d& u);

/// The u that `bent` takes to within 1e-9 of `target`, by Newton's method with step halving inside
/// the surface, from `target` itself and then from the control point that lands nearest to it;
/// nothing if neither gets there.
std::optional<Eigen::Vector2d> unbent(const SplineLens& lens, const Eigen::Vector2d& target);

/// A place in the rectangle from `low` to `high` where the map folds: some u there has a Jacobian
/// determinant <= 0. Looked for at three points along each side of every interval of the surface.
std::optional<Eigen::Vector2d> fold_within(const SplineLens& lens, const Eigen::Vector2d& low,
                                           const Eigen::Vector2d& high);

/// Stereographic image of a direction of any length, with its derivative; nothing straight behind.
struct StereographicPoint {
  Eigen::Vector2d u;
  Eigen::Matrix<double, 2, 3> d_point;
};
std::optional<StereographicPoint> stereographic(const Eigen::Vector3d& point);
/// Unit direction whose stereographic image is `u`.
Eigen::Vector3d direction_of_stereographic(const Eigen::Vector2d& u);

}  // namespace cousin
