#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "perception/stem/eye_pair.h"
#include "sim/config/fields.h"
#include "sim/types/image.h"
#include "sim/types/seams.h"

namespace cousin {

/// How high a plant is, from both images and its root.
struct PlantHeightConfig {
  double least_green = 0.06;    ///< 2 g - r - b of a green pixel over r + g + b
  int range_px = 190;           ///< ours: disparities that are matched
  double reach_m = 0.6;         ///< ours: leaves are within this of the root's depth and place
  double step_m = 0.03;         ///< ours: depth changes by less between pixels of one plant
  double ground_m = 1.0;        ///< ours: soil about the root that its plane is laid through
  double soil_m = 0.02;         ///< ours: soil farther from the plane is a clod or none
  int least_ground = 200;       ///< fewer points of soil are no ground
  int top_pixels = 40;          ///< ours: green pixels about the top that are as deep, at least
  double leaf_sigma_m = 0.006;  ///< deviation of the top, beside calibration
};
Fields fields(PlantHeightConfig& config);
void validate(const PlantHeightConfig& config);

struct PlantHeight {
  std::string why_none;  ///< empty: it is measured
  double height_m = kNaN, sigma_m = kNaN;
};

/// 255 at green pixels that are connected to the stem. The stem is what is green near the line from
/// the root through the node, up to three times their distance.
Image<std::uint8_t> green_along(const Image<Rgb8>& color, const Eigen::Vector2d& root_px,
                                const Eigen::Vector2d& node_px, double least_green);

/// The paper's rule [Maize 3.1]: of the green pixels that hang together with the stem, the farthest
/// from the root along the direction to its nearest node; the same in the right image, on the
/// epipolar line of the first; height is the distance of their mid-point from the root.
PlantHeight height_by_green(const EyePair& eyes, const Image<Rgb8>& left, const Image<Rgb8>& right,
                            const EyeNode (&root)[2], const EyeNode (&node)[2],
                            const PlantHeightConfig& config = {});

/// Depth of the whole left image, rectified: what every plant of a frame is measured in.
struct PairDepth {
  Image<float> depth_m;       ///< along the rectified axis; NaN = none
  Image<std::uint8_t> green;  ///< 255 where the rectified image is
  Camera camera;              ///< of the rectified image
  Eigen::Matrix3d rectified_from_left;
};
PairDepth pair_depth(const EyePair& eyes, const Image<Rgb8>& left, const Image<Rgb8>& right,
                     const PlantHeightConfig& config = {});

/// Unit normal of the soil about a root, upwards, in the left eye's axes; nothing where too little
/// of it is matched.
std::optional<Eigen::Vector3d> ground_up(const PairDepth& depth, const Eigen::Vector3d& root_m,
                                         const PlantHeightConfig& config = {});

/// Ours: a plane through the soil about the root (RANSAC, then least squares) says which way is up;
/// the highest green point within reach of the root, above it. Green pixels without a depth that
/// continue the top upwards take its depth: tips are thinner than what is matched.
/// @param root_m  in the left eye's axes
/// @param scale_sigma  deviation of the scale of lengths at the root's depth
PlantHeight height_above_ground(const PairDepth& depth, const Eigen::Vector3d& root_m,
                                double root_sigma_m, double scale_sigma,
                                const PlantHeightConfig& config = {});

}  // namespace cousin
