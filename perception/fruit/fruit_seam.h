#pragma once

#include <string>
#include <string_view>

#include "perception/fruit/fruit_fit.h"
#include "sim/types/seams.h"

namespace cousin {

/// A fruit's fit as fits.json has it: the numbers of its shape by name, then the turn from the
/// fruit's axes to the camera's as a rotation vector, then volume, diameter and length. The
/// covariance is that of the numbers; those of the sizes stand beside, with what their sigmas have
/// beyond it. Empty where a size has no sigma.
ObjectFit seam_of(const FruitFit& fit, int instance, const std::string& model);

/// The shape of such a fit; NaN where numbers are missing.
FruitShape shape_of(const ObjectFit& fit);
/// The covariance of its numbers; NaN where the fit has none.
FruitCovariance covariance_of(const ObjectFit& fit);

/// A number of a fit with its sigma; NaN where the fit has none of this name.
FruitMeasure parameter_of(const ObjectFit& fit, std::string_view name);

}  // namespace cousin
