#pragma once

#include <cstdint>
#include <string_view>

#include "sim/imaging/stereo_matching.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"

namespace cousin {

/// Why a depth image has no value at a pixel. Asked in this order, the first that holds counts.
enum class InvalidReason : std::uint8_t {
  none = 0,          ///< it has one
  out_of_range = 1,  ///< no surface, nearer than the least depth, or farther than the largest
  band = 2,          ///< the match lies beyond the right image's border
  saturated = 3,     ///< a quarter of the window is over-exposed
  mixed_pixel = 4,   ///< depth jumps within a pixel of it
  left_right = 5,    ///< hidden from the right imager, or its match disagrees
  no_projector = 6,  ///< hidden from the projector
  no_texture = 7,    ///< nothing to match: too even, unlike, or alike elsewhere
  low_signal = 8,    ///< too little of the device's own light comes back
};
std::string_view to_string(InvalidReason reason);

/// What is known of a left image, apart from the matches.
struct InvalidReasonInputs {
  const StereoMatches* matches = nullptr;
  const Image<float>* true_depth_m = nullptr;        ///< of the left image; NaN = no surface
  const Image<float>* true_right_depth_m = nullptr;  ///< of the right image
  const Image<float>* projected = nullptr;           ///< share that is lit; null = no projector
  const Image<std::uint16_t>* left_codes = nullptr;
  const Image<std::uint16_t>* right_codes = nullptr;
  int saturated_code = 255;
  double focal_baseline_px_m = 0;  ///< disparity = this over depth
  double least_disparity_px = 0, largest_disparity_px = 126;
  int window_px = 11;  ///< of the matcher, full width
};
Image<InvalidReason> invalid_reasons(const InvalidReasonInputs& inputs);

/// Whether the surface of a left pixel is hidden from the right imager: another lies before it
/// there by more than `tolerance_px` of disparity.
bool hidden_from_right(const Image<float>& right_depth_m, double x, int y, double disparity_px,
                       double focal_baseline_px_m, double tolerance_px = 1);

}  // namespace cousin
