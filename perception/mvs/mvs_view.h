#pragma once

#include <array>
#include <optional>
#include <vector>

#include "perception/mvs/lens_grid.h"
#include "perception/mvs/plane_sweep.h"

namespace cousin {

/// A posed image made ready for matching: only the part that shows the swept volume.
struct MvsView {
  int index = 0;  ///< into the capture's frames and the poses
  Pose camera_from_world;
  Eigen::Vector3d centre_in_world_m = Eigen::Vector3d::Zero();
  double distance_m = 0;  ///< camera centre to the volume's centre

  /// On the original, distorted grid: the part of the image that is reconstructed.
  PixelRect rect;
  Image<float> luma;      ///< 8-bit codes less 128, lightly smoothed
  Image<float> detail;    ///< Laplacian of luma: what a little more or less blur changes
  Image<float> chroma_b;  ///< (blue - luma) and (red - luma) over luma: the same in light and
                          ///< shade, zero for grey
  Image<float> chroma_r;
  Image<float> ray_x;  ///< x/z of each pixel's ray; NaN where the lens has none
  Image<float> ray_y;

  /// Undistorted copy that other views look up, of the pinhole camera (f, c).
  Eigen::Vector2f focal_px = Eigen::Vector2f::Zero();
  Eigen::Vector2f principal_px = Eigen::Vector2f::Zero();
  PixelRect pinhole_rect;
  Image<float> pinhole_luma;
  LensGrid distorted_from_pinhole;
};

/// Nothing if the volume is behind the camera or outside the image.
std::optional<MvsView> prepare_view(const Capture& capture, const Poses& poses, int index,
                                    const SweepVolume& volume);

std::array<Eigen::Vector3d, 8> corners_in_world_m(const SweepVolume& volume);

/// Indices into `views` of the views to match view `reference` with, best first: parallax near a
/// quarter radian, similar scale, seen from different sides.
std::vector<int> choose_neighbours(const std::vector<MvsView>& views, int reference,
                                   const SweepVolume& volume, const MvsConfig& config);

/// What one view's rays become in another view's pinhole image: pixel ~ from_ray * (x, y, 1) +
/// from_inverse_depth / depth.
struct Warp {
  Eigen::Matrix3f from_ray = Eigen::Matrix3f::Identity();
  Eigen::Vector3f from_inverse_depth = Eigen::Vector3f::Zero();
};
Warp warp_between(const MvsView& reference, const MvsView& neighbour);

}  // namespace cousin
