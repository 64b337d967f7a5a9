#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/config/fields.h"
#include "sim/types/seams.h"

namespace cousin {

/// What of a box's depth is a fruit's visible surface, and which part of its mask's outline is its
/// own.
struct FruitSurfaceConfig {
  double rim_px = 5;        ///< depths so near to the mask's edge are mixed with what is beside it
  double least_rim_px = 1;  ///< what is left of that where a mask is thin
  int most_points = 160;    ///< of the surface; spread evenly
  int most_outline = 72;    ///< places of the outline
  int least_depths = 12;    ///< fewer are no surface
  double least_share = 0.08;       ///< of the inner pixels that have depth; less is no surface
  double before_m = 0.008;         ///< what is so far before the fruit's edge may hide it
  double behind_m = 0.012;         ///< what is so far behind the fruit's edge does not
  double look_out_px = 7;          ///< from the outline to where what is beside it is looked at
  double largest_fruit_m = 0.2;    ///< depths farther from their median are not of it
  double smallest_fruit_m = 0.02;  ///< a visible part of less is too little
  double correlated_px = 9;        ///< depths within this err alike: the sensor's matching window
};
Fields fields(FruitSurfaceConfig& config);
void validate(const FruitSurfaceConfig& config);

/// A depth as a point in the camera.
struct SeenPoint {
  Eigen::Vector3d point_m;
  double sigma_m = 0.002;  ///< along the axis
};

/// What the depth camera sees just outside the outline at one place.
enum class Beyond {
  farther,  ///< what is behind: the outline is the fruit's own
  nearer,   ///< what may hide it: the fruit goes on, or not
  unknown   ///< no depth
};
/// A place on the mask's edge.
struct OutlinePlace {
  Eigen::Vector3d ray;      ///< unit
  Eigen::Vector3d outward;  ///< unit, across the ray: out of the mask
  Beyond beyond = Beyond::unknown;
};

struct FruitSurface {
  std::string why_none;  ///< empty: it is found
  std::vector<SeenPoint> points;
  /// Points that say something of their own: neighbours err alike.
  double independent_points = 0;
  std::vector<OutlinePlace> outline;
  double outline_length_px = 0;  ///< how long the sampled outline is
  double depth_m = kNaN;         ///< median along the axis
  double focal_px = kNaN;
  int mask_px = 0;              ///< pixels of the mask, or of the box
  double share_with_depth = 0;  ///< of its inner pixels
  bool is_cut = false;          ///< the image's edge cuts it
};

/// The visible surface of the fruit in a box: the pixels of its mask, or, without a mask, those of
/// the ellipse that fills the box.
/// @param depth  aligned to the camera's image, with sigmas or without
FruitSurface fruit_surface(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                           const FruitSurfaceConfig& config = {});

}  // namespace cousin
