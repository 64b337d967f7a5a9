#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace cousin {

/// The axis of a stem, petiole or midrib: at least two points, neighbours apart, with the radius of
/// the round section at each. Physics bends it; surfaces are made around it.
struct CentreLine {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<double> radii_m;
};

/// A growing axis turns towards a direction (light, up, down): by `turn_rad` over its whole length
/// if it stayed at right angles to it, less the nearer it is.
struct Tropism {
  Eigen::Vector3d towards = Eigen::Vector3d::UnitZ();  ///< unit
  double turn_rad = 0;                                 ///< negative: away
  double begin = 0;  ///< share of the length where the turning begins; it is linear from there
};

/// A growing axis curls about a fixed axis, evenly from `begin` to the tip: a seedling's hook.
struct Curl {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< unit
  double angle_rad = 0;                             ///< in all, right-handed
  double begin = 0;                                 ///< share of the length
};

struct AxisGrowth {
  Eigen::Vector3d start_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d heading = Eigen::Vector3d::UnitZ();  ///< unit
  double length_m = 0.01;
  double radius_base_m = 0.001;
  double radius_tip_m = 0.001;
  int segments = 16;
  std::vector<Tropism> tropisms;
  std::vector<Curl> curls;
};
/// Straight steps of equal length whose heading turns step by step: the line's length is exact.
/// @throws std::invalid_argument for a length or radius that is not positive and finite, or fewer
/// than one segment.
CentreLine grow_axis(const AxisGrowth& growth);

double length_m(const CentreLine& line);
double length_m(std::span<const Eigen::Vector3d> points_m);

/// Orthonormal axes along a line: columns are tangent, side and normal (tangent x side), turned as
/// little as possible from point to point by double reflection [Wang, Jüttler, Zheng & Liu 2008].
/// @param normal  wished for at the first point; any, if along the tangent.
std::vector<Eigen::Matrix3d> frames_along(std::span<const Eigen::Vector3d> points_m,
                                          const Eigen::Vector3d& normal);

/// Point, axes and radius at a share of the length in [0, 1]; beyond the ends along the end's
/// tangent.
struct LinePoint {
  Eigen::Vector3d point_m;
  Eigen::Matrix3d axes;
  double radius_m = 0;
};

/// A line that is asked at many places.
class LineWalk {
 public:
  LineWalk(CentreLine line, const Eigen::Vector3d& normal);
  LinePoint at_share(double share) const { return at_m(share * length_m_); }
  LinePoint at_m(double along_m) const;
  double length_m() const { return length_m_; }

 private:
  CentreLine line_;
  std::vector<Eigen::Matrix3d> axes_;
  std::vector<double> along_m_;  ///< of each point
  double length_m_ = 0;
};

}  // namespace cousin
