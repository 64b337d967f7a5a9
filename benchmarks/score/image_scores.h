#pragma once

#include <cstdint>
#include <span>

#include "sim/geometry/similarity.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"
#include "sim/types/seams.h"

namespace cousin {

/// Intersection over union of two masks (non-zero = inside); NaN if both are empty.
/// @throws std::invalid_argument if sizes differ.
double mask_iou(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b);

/// An estimated depth image against the truth, over the pixels where the truth has a surface.
struct DepthScore {
  long long truth_pixels = 0;
  double filled = kNaN;  ///< share of them that have an estimate
  double bias_m = kNaN;  ///< mean of estimate - truth
  double rmse_m = kNaN;
  double median_abs_m = kNaN;
  double p95_abs_m = kNaN;
  double bad_share = kNaN;  ///< of the estimates: farther off than `bad_m`
};
/// @param mask  empty, or the size of the images: only non-zero pixels count.
/// @throws std::invalid_argument if sizes differ.
DepthScore score_depth(const Image<float>& estimate_m, const Image<float>& truth_m, double bad_m,
                       const Image<std::uint8_t>& mask = {});

/// Estimated camera poses against true ones.
struct PoseScore {
  int views = 0;
  int posed = 0;               ///< views whose status is ok
  double centre_rms_m = kNaN;  ///< of the camera centres' distances
  double centre_max_m = kNaN;
  /// centre_rms_m over the mean distance of the true cameras from the point nearest to their
  /// optical axes; NaN if these are parallel.
  double centre_rms_share = kNaN;
  double rotation_rms_rad = kNaN;  ///< of the angles between the orientations
  double rotation_max_rad = kNaN;
  double focal_rms = kNaN;  ///< of the relative errors of fx; NaN if no true cameras are given
  /// True lengths over estimated ones, as the alignment found; NaN if there is none, nor then are
  /// centres and rotations scored.
  double scale = 1;
};
/// `none`: both are in the same world. `similarity`: the estimate's world and unit are its own; it
/// is moved so that the centres of its posed views come nearest to the true ones. Of fewer than
/// three posed views, or centres on a line, there is no alignment, and no error.
enum class PoseAlignment { none, similarity };

/// The similarity that brings the posed views' centres nearest to the true ones.
/// @throws std::invalid_argument if counts differ.
SimilarityFit fit_to_truth(const Poses& estimate, std::span<const Pose> truth_camera_from_world);

/// @param truth_camera_from_world  one for each of `estimate`, same order: the pose while the
/// middle row is read
/// @param truth_cameras            empty, or one for each
/// @throws std::invalid_argument if counts differ.
PoseScore score_poses(const Poses& estimate, std::span<const Pose> truth_camera_from_world,
                      std::span<const Camera> truth_cameras = {},
                      PoseAlignment alignment = PoseAlignment::none);

}  // namespace cousin
