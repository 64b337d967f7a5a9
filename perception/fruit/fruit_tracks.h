#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "perception/fruit/fruit_place.h"
#include "perception/fruit/fruit_shape.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"
#include "sim/types/seams.h"
#include "sim/types/tracks.h"

namespace cousin {

/// How boxes of several images are brought together as fruits.
struct FruitTracksConfig {
  int least_px = 40;   ///< of a mask, or of a box without; smaller ones are left out
  double per_m3 = 20;  ///< fruits where they hang; more of them make two boxes less likely one
  double pose_sigma_m = 0.004;  ///< of a camera's place, each axis
  double most_off = 4.5;        ///< sigmas between two boxes of one fruit
  double crown_sigma_m = 0.35;  ///< of fruits before and behind the row's middle, the plane y = 0
};
Fields fields(FruitTracksConfig& config);
/// @throws std::invalid_argument naming key, value and limit
void validate(const FruitTracksConfig& config);

/// Pixels of a box's mask, or of the box without one.
int pixels_of(const DetectedBox& box);

/// The middle of a box's fruit, by the kind's size, in its camera: the less of the fruit's section
/// the mask covers, the less is known of where the middle is beside it. Nothing without depth, or
/// where the depth is of something farther: the fruit would be far larger than its kind.
/// @param depth  of the box's image
std::optional<LocatedPoint> rough_place(const DetectedBox& box, const Camera& camera,
                                        const FrameDepth& depth, const FruitPrior& prior);
/// The same of a box without depth, by the mask's extent: a fruit of which the far ends are hidden
/// seems farther than it is, and the less of a disc is seen, the less sure that is.
LocatedPoint place_by_size(const DetectedBox& box, const Camera& camera, const FruitPrior& prior);

/// What one box says of where its fruit is, in the world.
struct PlacedBox {
  int id = 0;
  int frame = 0;
  LocatedPoint in_world;
};
/// @param pose_sigma_m  FruitTracksConfig's
PlacedBox placed(const DetectedBox& box, const LocatedPoint& in_camera,
                 const Pose& camera_from_world, double pose_sigma_m);

/// The same where nothing but its size says how far it is: it hangs in the row, if that can be.
PlacedBox in_row(PlacedBox box, double crown_sigma_m);

/// Boxes that are of one fruit, numbered by their first box. Two groups are joined, the likeliest
/// first, as long as one fruit explains them better than two of `per_m3` [the likelihood ratio of
/// data association, Bar-Shalom & Fortmann, Tracking and Data Association, 1988], no image shows
/// both, and they are within `most_off`. The result does not depend on the boxes' order.
/// @throws std::invalid_argument for more than 20,000 boxes, or 10,000,000 pairs that may be one
Tracks join_boxes(std::span<const PlacedBox> boxes, const FruitTracksConfig& config = {});

}  // namespace cousin
