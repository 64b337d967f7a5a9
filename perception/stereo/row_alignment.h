#pragma once

#include <Eigen/Core>
#include <array>

#include "sim/types/image.h"

namespace cousin {

/// By how many pixels the right image of a rectified pair shows things lower than the left one:
/// what the calibration that the pair was rectified by is off, or what moved between exposures. A
/// polynomial over the image: a shift and turns of the camera, its focal length, and radial
/// distortion, whose part along columns is y r^2. Zero where it is not known.
struct RowOffset {
  static constexpr int kTerms = 7;
  /// Of 1, x, y, x^2, x y, y^2 and y (x^2 + y^2); x and y in half widths of the image from its
  /// middle, to the right and down.
  std::array<double, kTerms> terms_px{};
  int windows = 0;       ///< that say so; 0: not known
  double spread_px = 0;  ///< of single windows about it, a standard deviation by their median
};
/// At a pixel of an image of this size.
double row_offset_px(const RowOffset& offset, int width, int height, double x, double y);
/// Root mean square and largest one anywhere in the image.
struct RowOffsetSize {
  double rms_px = 0, largest_px = 0;
};
RowOffsetSize size_of(const RowOffset& offset, int width, int height);
/// The same of images `factor` times as large.
RowOffset scaled(RowOffset offset, double factor);

/// From windows all over the image that are laid over each other along both axes by least squares;
/// most of them are to agree; else none is known. Offsets up to about two pixels are found.
/// @param disparity_px  of the left image's pixels, NaN = none
/// @param known         that was taken out of the right image already; the result has it too
/// @throws std::invalid_argument if sizes differ
RowOffset find_row_offset(const Image<float>& left, const Image<float>& right,
                          const Image<float>& disparity_px, const RowOffset& known = {});

/// The map of the right image with its rows moved, so that rows agree (rectification.h).
Image<Eigen::Vector2f> with_rows_moved(const Image<Eigen::Vector2f>& right_px,
                                       const RowOffset& offset);

}  // namespace cousin
