#pragma once

#include "perception/fruit/fruit_shape.h"
#include "perception/fruit/fruit_surface.h"

namespace cousin {

struct FruitMeasure {
  double value = kNaN, sigma = kNaN;
};

/// What the mask alone says of a fruit of any shape: a lump that is about as deep as wide.
struct FruitLump {
  double radius_m = kNaN;  ///< of the circle that has the mask's area
  double hidden = 0;       ///< share of the outline beyond which something is nearer
  bool is_whole = false;   ///< at most a tenth is hidden and the image's edge cuts nothing off
  double longer = 1;       ///< the mask's length over its width
  FruitMeasure volume_m3, diameter_m, length_m;
};
/// Sigmas are 25 % of the volume, 12 % of the diameter and 20 % of the length; more where something
/// nearer may hide a part. The volume is 0.85 of the ball's of that radius: an outline is that of
/// the highest places all round. These numbers are free; tests and scenes/fruit's other family say
/// whether they hold.
/// @param solid_share  FruitPrior::solid_share
FruitLump lump_of(const FruitSurface& surface, double solid_share);

/// What the numbers of a shape at the lump's place may be off. The axis is not known.
FruitCovariance spread_of(const FruitLump& lump);

/// The shape of `start` as large as the lump, its front where it is.
FruitShape shape_of(const FruitLump& lump, FruitShape start);

}  // namespace cousin
