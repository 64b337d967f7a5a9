#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/render/ray_scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Private to sim/render: where a view sees a point of an instance, and whether something hides it.

struct PointInView {
  Eigen::Vector2d pixel_px;           ///< may lie outside the image
  Eigen::Vector3d in_world_m;         ///< the point, when the row that sees it is read
  Eigen::Vector3d centre_in_world_m;  ///< the camera's, then
  double depth_m = 0;
  double time_s = 0;
};

/// The image of a point: with a rolling shutter the row that sees it gives pose and time, found by
/// fixed-point steps. Nothing where the lens makes no image, or none within 1e-6 px after 50 steps.
std::optional<PointInView> image_of(const TrueView& view, const Instance& instance,
                                    const Eigen::Vector3d& in_object_m);

/// Whether a pixel lies in the image: within half a pixel of some pixel's centre.
bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel_px);

/// Whether nothing lies between a camera's centre and a point of an instance. Rounding is forgiven:
/// 2e-6 of the distance, and hits whose triangle's plane passes through the point. So is the
/// instance's own surface within `skin_m` before the point.
/// @param own  place in Scene::instances.
bool is_in_sight(const RayScene& rays, const PointInView& point, std::size_t own, double skin_m);

/// Distance from a point of an instance to its own surface; 0 for an instance that is neither a
/// specimen nor one that shares its model.
double distance_to_surface_m(const RayScene& rays, std::size_t own,
                             const Eigen::Vector3d& in_object_m);

}  // namespace cousin
