#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// Two calibrated cameras of one rig. Points are in the left one's axes, in metres.
struct EyePair {
  EyePair(const Camera& left_camera, const Camera& right_camera, const Pose& right_from_left_eye);
  Lens left, right;
  Pose right_from_left;
  double baseline_m = 0;
  Eigen::Matrix3d essential;  ///< x_right^T E x_left = 0 of directions (x, y, 1)
};

/// A root or a node in one image.
struct EyeNode {
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Zero();
  double sigma_px = 1;  ///< standard deviation per axis
};

/// What a detector found in one image: points of any number of plants, in any order.
struct EyeNodes {
  std::vector<EyeNode> roots, nodes;
};

/// How far each point is from the other's epipolar line, in pixels of its own image [Maize,
/// equation 4 and its converse]. Positive where the right point lies below the line, or the left
/// point above its own.
struct EpipolarDistance {
  double in_right_px = 0, in_left_px = 0;
};
/// Nothing where a lens has no ray for its pixel, or a line has no direction: the point is the
/// image of the other eye.
std::optional<EpipolarDistance> epipolar_distance(const EyePair& eyes,
                                                  const Eigen::Vector2d& left_px,
                                                  const Eigen::Vector2d& right_px);

/// The middle between the rays where they pass each other [Maize, equation 5]; nothing where they
/// are parallel to 0.1 mrad or meet behind an eye.
std::optional<Eigen::Vector3d> middle_of_rays(const EyePair& eyes, const Eigen::Vector2d& left_px,
                                              const Eigen::Vector2d& right_px);

}  // namespace cousin
