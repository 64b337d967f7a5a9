#pragma once

#include "sim/types/image.h"

namespace cousin {

/// How disparities follow from the brightness itself, once about which is known.
struct DisparityRefinementConfig {
  int radius_px = 4;             ///< of the windows that are laid over each other
  double same_surface_px = 1;    ///< farther from a window's plane: another surface
  double least_likeness = 0.7;   ///< correlation of both windows
  double most_moved_px = 1;      ///< from the disparity given; farther: not found
  double noise_share = 0.8;      ///< of the deviation that the residuals give
  double rough_share = 2;        ///< of the disparities' roughness, which windows do not follow
  double sigma_floor_px = 0.02;  ///< deviation of the best pixels
  double most_sigma_px = 1;      ///< disparities known worse are left out
};

struct RefinedDisparities {
  Image<float> disparity_px;  ///< NaN = none
  Image<float> sigma_px;      ///< standard deviation; NaN where there is no disparity
  float noise = 0;  ///< of the left image's brightness, as the residuals say: their median
};

/// Moves disparities of a rectified pair to where the windows of both images fit best by least
/// squares [Foerstner, ISPRS 1982; Lucas & Kanade, IJCAI 1981]. A window is a piece of a plane: its
/// slopes are those of the disparities given, and pixels of another surface have no part in it.
/// Unknown besides are gain and offset of the right image's brightness.
///
/// The deviation is that of the least squares, the residuals' over the gradients' along the row,
/// as far as both images share these; larger where the noise of neighbours is alike, which the
/// residuals of many windows say; and what the surface departs from its windows' planes, which the
/// refined disparities say. A wrong match has none of it: |error| has a longer tail than a normal
/// distribution's.
/// @param found_px  NaN = none
/// @throws std::invalid_argument if sizes differ
RefinedDisparities refine_disparities(const Image<float>& left, const Image<float>& right,
                                      const Image<float>& found_px,
                                      const DisparityRefinementConfig& config = {});

}  // namespace cousin
