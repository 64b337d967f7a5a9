#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// A point where the image is a saddle, as it is where four squares of a checkerboard meet.
struct Saddle {
  Eigen::Vector2d pixel_px;
  double strength = 0;      ///< sqrt(-det) of the Hessian
  Eigen::Matrix2d hessian;  ///< of the smoothed image, per px^2
};

/// Saddles of an image smoothed by a Gaussian of `smoothing_px`, with strength above `minimum`,
/// strongest first.
std::vector<Saddle> find_saddles(const Image<float>& image, double smoothing_px, double minimum);

/// A saddle with its place in a checkerboard lattice whose origin is arbitrary. Seen from the
/// printed side, the second axis is 90 degrees counter-clockwise of the first.
struct LatticeCorner {
  int column = 0;
  int row = 0;
  Eigen::Vector2d pixel_px;
  bool dark_ahead = false;  ///< the square between the two positive axes is the darker kind
};

/// The largest lattice that grows from any of the saddles: from a cell of four corners outward,
/// each new corner predicted from the known ones within two steps and accepted where a saddle of
/// the expected kind lies. Cells start where the image is level along two of its sides, as it is
/// along the edges of squares and nowhere else.
/// @param image        that the saddles are of
/// @param reach_share  of the image's width: the longest side of a cell that growth starts from
/// At most `max_extent` corners along an axis. Empty if no cell is found.
std::vector<LatticeCorner> grow_lattice(const Image<float>& image,
                                        const std::vector<Saddle>& saddles, int max_extent,
                                        double reach_share = 0.06);

}  // namespace cousin
