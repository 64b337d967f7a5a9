#pragma once

#include <vector>

#include "sim/render/ray_scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Leaf area of all specimens, by id, whole and as a view shows it: of their surfaces whose
/// material is a leaf (blades and cotyledons), one side, whichever side the camera sees. Points
/// spread evenly over the area, one in each of `points` strata of equal area and the same in every
/// view, are seen or not, by a ray to each; so the seen share of a leaf half hidden is known to
/// about 0.5 / sqrt(points), one standard deviation, and better where what hides it is large. A
/// point outside the image is not seen.
/// @param rays  of `scene`, over the view's times if it moves.
/// @throws std::invalid_argument if the rays are of another scene, or points < 1.
std::vector<LeafAreaView> view_leaf_areas(const RayScene& rays, const Scene& scene,
                                          const TrueView& view, int points = 1024);

}  // namespace cousin
