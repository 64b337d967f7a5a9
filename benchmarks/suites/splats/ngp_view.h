#pragma once

#include "perception/ngp/ngp.h"
#include "perception/splats/splat_views.h"

namespace cousin {

/// The same photograph at its full size for a radiance field, rounded to codes again; pixels that
/// do not count whole are masked.
NgpView ngp_view(const SplatView& view);

}  // namespace cousin
