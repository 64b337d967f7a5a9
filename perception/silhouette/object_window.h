#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "calibration/boards/board_template.h"
#include "perception/silhouette/outlines.h"

namespace cousin {

/// The part of a view about one object: what is seen, and what the bare board would look like.
struct ObjectWindow {
  PixelBox box;
  Image<Eigen::Vector3f> color;  ///< linear
  Image<float> white;  ///< share of paper in the pixel, were the board bare; blurred as by the lens
  Image<std::uint8_t> on_plate;
  Image<float>
      to_object_px;  ///< distance from the convex hull of the cluster's projection; 0 inside
  Image<float> to_others_px;   ///< the same for the nearest other cluster
  Eigen::Vector3f paper, ink;  ///< linear colours around the object, out of its shadow
  Eigen::Vector3f object;      ///< median colour inside the cluster's projection

  /// Colour of the bare, unshaded board at a pixel of the box.
  Eigen::Vector3f board_at(int x, int y) const { return ink + white(x, y) * (paper - ink); }
};

/// A view with the projections of all clusters.
struct ViewClusters {
  const Image<Rgb8>* image = nullptr;
  FramePose pose;
  std::vector<std::vector<Eigen::Vector2f>>
      pixels_px;  ///< one list for each cluster; only points before the camera
};

/// Nothing where the object is outside the image or too little of the plate is seen around it.
std::optional<ObjectWindow> open_window(const ViewClusters& view, std::size_t instance,
                                        const BoardPattern& pattern, const OutlineConfig& config);

/// First guess: 255 where more of the pixel's light comes from the object than from the board, one
/// piece, without holes.
Image<std::uint8_t> rough_mask(const ObjectWindow& window, const OutlineConfig& config);

}  // namespace cousin
