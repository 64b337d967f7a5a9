#pragma once

#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// A view with the rays it is seen by.
struct RayView {
  const RayScene& rays;  ///< of the scene, over the view's times if it moves
  const TrueView& view;
};

/// Where another view sees what each pixel's centre shows: optical flow between two times, and with
/// the other camera of a rig at the same time the disparity, -flow_px.x(). The point follows from
/// depth, lens and pose, moves with its instance from one view's time to the other's, and is
/// projected; with a rolling shutter the row that sees it gives pose and time. `visible` is by a
/// ray from the other camera; the surface it lies on does not hide it, so a thin sheet's point is
/// seen from both sides. Exact to the float depth: f * 6e-8 px. Points that no lens images have
/// flow NaN and are `outside`.
/// @param depth_m, instance  of `here`, by render_truth.
/// @throws std::invalid_argument if the images are not of the view's size or the rays of another
/// scene.
ViewMatch match_views(const Scene& scene, const RayView& here, const Image<float>& depth_m,
                      const Image<std::int32_t>& instance, const RayView& there);

}  // namespace cousin
