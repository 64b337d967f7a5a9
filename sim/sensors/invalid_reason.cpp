#include "sim/sensors/invalid_reason.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cousin {
namespace {

/// Largest change of true disparity between a pixel and its neighbours. A pixel without a surface
/// has disparity 0.
double disparity_jump(const Image<float>& depth_m, int x, int y, double focal_baseline_px_m) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, depth_m.height() - 1); ++j) {
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, depth_m.width() - 1); ++i) {
      const auto z = static_cast<double>(depth_m(i, j));
      const double d = z > 0 ? focal_baseline_px_m / z : 0;
      low = std::min(low, d);
      high = std::max(high, d);
    }
  }
  return high - low;
}

/// Share of over-exposed pixels in a window.
double saturated_share(const Image<std::uint16_t>& codes, double x, int y, int window_px,
                       int saturated_code) {
  const int r = window_px / 2, cx = static_cast<int>(std::lround(x));
  int count = 0, all = 0;
  for (int j = std::max(y - r, 0); j <= std::min(y + r, codes.height() - 1); ++j) {
    for (int i = std::max(cx - r, 0); i <= std::min(cx + r, codes.width() - 1); ++i, ++all)
      count += codes(i, j) >= saturated_code ? 1 : 0;
  }
  return all > 0 ? static_cast<double>(count) / all : 0;
}

InvalidReason reason_at(const InvalidReasonInputs& in, int x, int y) {
  constexpr double kSaturatedShare = 0.25, kJump_px = 1, kLitShare = 0.5;
  const MatchReason match = in.matches->reason(x, y);
  const auto z = static_cast<double>((*in.true_depth_m)(x, y));
  if (!(z > 0)) return InvalidReason::out_of_range;
  const double disparity_px = in.focal_baseline_px_m / z;
  if (disparity_px > in.largest_disparity_px || disparity_px < in.least_disparity_px)
    return InvalidReason::out_of_range;
  if (x - disparity_px < in.window_px / 2) return InvalidReason::band;
  if (saturated_share(*in.left_codes, x, y, in.window_px, in.saturated_code) > kSaturatedShare ||
      saturated_share(*in.right_codes, x - disparity_px, y, in.window_px, in.saturated_code) >
          kSaturatedShare) {
    return InvalidReason::saturated;
  }
  if (disparity_jump(*in.true_depth_m, x, y, in.focal_baseline_px_m) > kJump_px)
    return InvalidReason::mixed_pixel;
  if (match == MatchReason::left_right ||
      hidden_from_right(*in.true_right_depth_m, x - disparity_px, y, disparity_px,
                        in.focal_baseline_px_m)) {
    return InvalidReason::left_right;
  }
  if (in.projected && (*in.projected)(x, y) < kLitShare) return InvalidReason::no_projector;
  return match == MatchReason::out_of_range ? InvalidReason::out_of_range
                                            : InvalidReason::no_texture;
}

}  // namespace

std::string_view to_string(InvalidReason reason) {
  static constexpr std::array<std::string_view, 9> kNames = {
      "none",       "out_of_range", "band",       "saturated", "mixed_pixel",
      "left_right", "no_projector", "no_texture", "low_signal"};
  return kNames[static_cast<std::size_t>(reason)];
}

bool hidden_from_right(const Image<float>& right_depth_m, double x, int y, double disparity_px,
                       double focal_baseline_px_m, double tolerance_px) {
  const int i = static_cast<int>(std::lround(x));
  if (!right_depth_m.contains(i, y)) return true;
  const auto z = static_cast<double>(right_depth_m(i, y));
  return z > 0 && focal_baseline_px_m / z > disparity_px + tolerance_px;
}

Image<InvalidReason> invalid_reasons(const InvalidReasonInputs& inputs) {
  const Image<float>& disparity_px = inputs.matches->disparity_px;
  Image<InvalidReason> reasons(disparity_px.width(), disparity_px.height(), InvalidReason::none);
  tbb::parallel_for(0, disparity_px.height(), [&](int y) {
    for (int x = 0; x < disparity_px.width(); ++x) {
      if (std::isnan(disparity_px(x, y))) reasons(x, y) = reason_at(inputs, x, y);
    }
  });
  return reasons;
}

}  // namespace cousin
