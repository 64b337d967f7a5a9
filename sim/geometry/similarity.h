#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <vector>

#include "sim/types/pose.h"

namespace cousin {

/// x_a = scale * (rotation * x_b) + shift_m. Name it `a_from_b`.
struct WorldSimilarity {
  double scale = 1;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
};
Eigen::Vector3d operator*(const WorldSimilarity& a_from_b, const Eigen::Vector3d& point_in_b);
/// The camera's pose from world a, of its pose from world b; pictures stay the same.
Pose moved(const Pose& camera_from_b, const WorldSimilarity& a_from_b);

enum class ScaleFreedom { fixed, free };

struct SimilarityFit {
  bool ok = false;  ///< false: fewer than three points, or points on a line
  WorldSimilarity a_from_b;
  double rms_m = std::numeric_limits<double>::quiet_NaN();  ///< of the distances left over, in a
  /// Standard deviation of the scale over the scale, if errors of coordinates are independent and
  /// as large as what is left over; 0 where the scale is fixed.
  double scale_sigma_share = std::numeric_limits<double>::quiet_NaN();
};

/// Least squares of the distances between `in_a` and `in_b` brought to a [Umeyama, IEEE TPAMI
/// 1991]. @throws std::invalid_argument if counts differ
SimilarityFit fit_similarity(const std::vector<Eigen::Vector3d>& in_a,
                             const std::vector<Eigen::Vector3d>& in_b,
                             ScaleFreedom freedom = ScaleFreedom::free);

}  // namespace cousin
