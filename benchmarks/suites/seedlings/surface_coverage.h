#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"

namespace cousin {

/// What a view could see of surfaces.
struct DepthSight {
  Camera camera;
  Pose camera_from_world;
  const Image<float>* depth_m = nullptr;       ///< true, along the axis; NaN = no surface
  const Image<std::uint8_t>* shown = nullptr;  ///< 0: it shows nothing there; null = all is shown
};

/// In how many of `views` each pixel's surface point is seen: it lies in what is shown, and at one
/// pixel at least of the nine about it no surface is more than 2 mm before it. Depth is known at
/// pixel centres, so that points beside an edge are seen; so are those behind a stem of two pixels.
/// A pixel without a point has zero. TBB over rows; the same on any number of threads. @param
/// position_m  in the world; NaN = none
/// @throws std::invalid_argument if a depth image or `shown` has another size than its camera.
Image<std::uint16_t> views_that_see(const Image<Eigen::Vector3f>& position_m,
                                    std::span<const DepthSight> views);

/// Surface points of several views by the number of views that see them.
class CoverageShare {
 public:
  /// @param mask  empty, or of the image's size: non-zero pixels count
  void add(const Image<std::uint16_t>& seen, const Image<std::uint8_t>& mask = {});
  std::int64_t points() const { return points_; }
  /// Share of the points that at least `views` see; NaN of none.
  double seen_by(int views) const;

 private:
  std::int64_t points_ = 0;
  std::vector<std::int64_t> by_count_;
};

}  // namespace cousin
