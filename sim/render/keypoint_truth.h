#pragma once

#include <vector>

#include "sim/render/ray_scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// The keypoints of all specimens, by id and in the models' order, as a view shows them. A keypoint
/// outside the image is `outside`; one with a surface between it and the camera is `occluded`, by a
/// ray to it; else it is `visible`. A keypoint inside its own object, as a node on a stem's axis
/// is, lies behind its own surface from everywhere: that surface hides it only from farther before
/// it than twice the keypoint's distance to the surface. With a rolling shutter the row that sees
/// the keypoint gives pose and time.
/// @param rays  of `scene`, over the view's times if it moves.
/// @throws std::invalid_argument if the rays are of another scene.
std::vector<KeypointView> view_keypoints(const RayScene& rays, const Scene& scene,
                                         const TrueView& view);

}  // namespace cousin
