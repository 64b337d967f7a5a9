#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/types/capture.h"
#include "sim/types/image.h"

namespace cousin {

/// A flat, textured piece of surface before a rectified pair: its disparity is affine in the left
/// image's pixels. Of two pieces the one of larger disparity hides the other.
struct DrawnPiece {
  double at_px = 0;     ///< disparity at pixel (0, 0)
  double per_x = 0;     ///< disparity a pixel to the right, below 1
  double per_y = 0;     ///< and a pixel down
  double middle_x = 0;  ///< of its ellipse, in the left image
  double middle_y = 0;
  double radius_x = 1e9;  ///< in pixels; large: everywhere
  double radius_y = 1e9;
  double turn_rad = 0;
  std::uint64_t texture = 1;  ///< of its own
  double contrast = 60;       ///< standard deviation of the brightness, about
  double grain_px = 2;        ///< size of the finest bumps
  double brightness = 120;    ///< mean, of 255
  double period_px = 0;       ///< the texture repeats along rows; 0: it does not
};

struct DrawnPairConfig {
  int width_px = 320, height_px = 240;
  double noise = 1.5;        ///< standard deviation of both images' noise, codes of 255
  double right_gain = 1;     ///< brightness of the right image
  double right_down_px = 0;  ///< rows by which the right image shows things lower than it should
  std::uint64_t seed = 1;
};

/// Two images and what is true of the left one's pixels.
struct DrawnPair {
  Image<std::uint8_t> left, right;
  Image<float> disparity_px;
  Image<std::uint8_t> visible;  ///< 255 where the right image shows it too
};
/// Each pixel is the mean of nine samples.
DrawnPair draw_pair(const std::vector<DrawnPiece>& pieces, const DrawnPairConfig& config = {});

/// A slanted ground with 40 ellipses of all kinds before it, disparities to about 60 px.
std::vector<DrawnPiece> drawn_clutter(std::uint64_t seed, const DrawnPairConfig& config = {});

/// The pair as a rig of two pinhole cameras of focal length width, `baseline_m` apart, hands it
/// over: depth = width * baseline / disparity.
Capture capture_of(const DrawnPair& pair, double baseline_m = 0.1);

}  // namespace cousin
