#pragma once

#include "perception/mvs/mvs_view.h"

namespace cousin {

/// What is known about the surface at the pixels of one view's rectangle. In ray coordinates (x, y)
/// = (X/Z, Y/Z) a plane is linear in inverse depth: 1/Z = inverse_depth + slope_x (x - x_p) +
/// slope_y (y - y_p). Curved surfaces add half of bend_xx dx^2 + 2 bend_xy dx dy + bend_yy dy^2; a
/// bend of -1/m is a bulge of radius 1 m seen from the front.
struct ReferenceDepth {
  Image<float> inverse_depth;  ///< 1/m; NaN = none
  Image<float> slope_x;        ///< 1/m per unit of x/z
  Image<float> slope_y;
  Image<float> score;    ///< -1..1
  Image<float> sigma_m;  ///< of the depth
};

/// Variance of the smoothed images' noise in squared 8-bit codes: added to both variances of the
/// correlation, so that a window whose texture drowns in noise does not score well.
inline constexpr float kNoiseVariance = 1.0F;
/// Neighbours whose scores count: the better half, since the others may be occluded.
int counted_neighbours(int neighbours);

/// First pass: sweeps planes parallel to the board and, for oblique views, planes that face the
/// camera; zero-mean normalised cross-correlation over square windows, mean of the better half of
/// the neighbours, parabola between planes.
/// @param neighbours  indices into `views`, at least one
ReferenceDepth sweep_reference(const std::vector<MvsView>& views, int reference,
                               const std::vector<int>& neighbours, const SweepVolume& volume,
                               const MvsConfig& config);

/// Second pass: PatchMatch over slanted planes [Bleyer, Rhemann & Rother, BMVC 2011] with windows
/// weighted by colour, where the first pass did not already find a plane wider than its window.
/// Then Gauss-Newton on the photometric residuals with windows curved like the depth around them: a
/// flat window on a seed would lie behind its middle by the mean sag. Scores below the threshold
/// and depths less certain than `config.consistency_depth` become NaN. Sequential, since it
/// propagates; one call a reference.
void refine_slanted(const std::vector<MvsView>& views, int reference,
                    const std::vector<int>& neighbours, const SweepVolume& volume,
                    const MvsConfig& config, ReferenceDepth& depth);

/// Depths in metres; keeps those that `config.consistent_views` other references agree with.
std::vector<Image<float>> consistent_depths_m(const std::vector<MvsView>& views,
                                              const std::vector<int>& references,
                                              const std::vector<ReferenceDepth>& depths,
                                              const MvsConfig& config);

}  // namespace cousin
