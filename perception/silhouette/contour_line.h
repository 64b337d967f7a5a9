#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// A vertex of a closed line around an object.
struct ContourVertex {
  Eigen::Vector2d pixel_px;
  Eigen::Vector2d normal;       ///< unit, outward
  double curvature_per_px = 0;  ///< positive where the object is convex
};

/// The longest closed half-level line of a mask (255 inside) smoothed by a Gaussian of 0.7 px, by
/// marching squares; a vertex for each crossing of the pixel grid. Empty if there is none.
std::vector<Eigen::Vector2d> trace_mask(const Image<std::uint8_t>& mask);

/// A closed line at equal steps of about one pixel, smoothed along its length by a Gaussian, with
/// normals and curvatures. Empty for fewer than 6 points or a length below 8 px.
std::vector<ContourVertex> smooth_contour(const std::vector<Eigen::Vector2d>& line_px,
                                          double sigma_px);

}  // namespace cousin
