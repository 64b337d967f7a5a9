#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/render/ray_scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Which images a run needs; everything else is left out.
struct TruthNeeds {
  bool depth = false;
  bool normal = false;
  bool position = false;
  bool instance = false;
  bool part = false;
  bool coverage =
      false;  ///< several samples a pixel, where neighbouring pixels differ in being specimen
  bool visibility =
      false;  ///< visible fraction and full (amodal) masks, by rays that ignore other instances
  /// Area of each specimen in each pixel, by `share_samples` rays to every pixel, whatever its
  /// neighbours show: Sobol's points, shifted on the torus by a hash of the pixel. The mean of a
  /// share is the true area, however small; a strip of 1 / share_samples of a pixel or wider that
  /// crosses a pixel along its rows or columns is always met. So a stem or a leaf's tip between
  /// pixel centres, which no image of centres shows, has its area here.
  bool shares = false;
  bool keypoints = false;  ///< of the specimens: see keypoint_truth.h
  bool leaf_area = false;  ///< of the specimens, whole and seen: see leaf_area_truth.h
  /// To the scene's next view: see view_match.h. By whoever has both views, not by render_truth.
  bool flow = false;
  // By whoever has the rig: see match_views and the depth sensor.
  bool disparity = false;         ///< to the rig's second camera
  bool noise_free_depth = false;  ///< of the rig's depth sensor, in its pixels
  bool invalid_reason = false;    ///< why its pixels have no depth

  bool operator==(const TruthNeeds&) const = default;
};

struct TruthConfig {
  int coverage_samples = 16;  ///< a pixel, a square number: stratified
  int share_samples = 4;      ///< a pixel, 1..4096; powers of two are spread evenly
};

/// The rays of one view's pixel centres, ready to be cast at one RayScene. Row y holds `stride`
/// rays, of which the first `width` are pixels; a direction of zero means that the lens model gives
/// no ray there.
struct PreparedRays {
  int width = 0;
  int height = 0;
  int stride = 0;  ///< `width` rounded up to whole packets
  /// Unit directions in the world, as float and the double's remainder: their sum has 48 bits.
  std::vector<float> x, y, z;
  std::vector<float> x_rest, y_rest, z_rest;
  struct Row {
    Eigen::Vector3d origin_m;  ///< camera centre, less the scene's centre
    Eigen::Matrix3d camera_from_world;
    float time = 0;  ///< when the row is read, as a share of the RayScene's span
  };
  std::vector<Row> rows;  ///< one pose a row: a rolling shutter exposes a row at once
};

PreparedRays prepare_rays(const RayScene& rays, const TrueView& view);

/// Truth seen through the true lens: one ray a pixel centre, distorted per ray, rolling shutter per
/// row. Pixels whose lens model gives no ray are "none". Depth, normal and position come from the
/// hit triangle's plane in double precision; a hit whose point is then outside the triangle's
/// bounds is Embree's mistake (embree#387) and the ray goes on. TBB over rows; the same bytes on
/// any number of threads.
/// @throws std::invalid_argument for an invalid camera, or coverage_samples that is not a square
/// number.
TruthImages render_truth(const RayScene& rays, const Scene& scene, const TrueView& view,
                         const TruthNeeds& needs, const TruthConfig& config = {});
TruthImages render_truth(const RayScene& rays, const Scene& scene, const TrueView& view,
                         const PreparedRays& prepared, const TruthNeeds& needs,
                         const TruthConfig& config = {});

}  // namespace cousin
