#pragma once

#include "benchmarks/suites/seedlings/field_scores.h"

namespace cousin {

/// What the exact surface gives without any model of how light leaves it: each pixel of a held-out
/// view shows the mean of the colours that the views trained on show of its surface point. Of the
/// views, those count whose true depth at the four pixels about the point is its own to 1 %.
struct ExactSurface {
  /// Over all pixels of the held-out views that enough views show by this rule, which leaves out
  /// edges and steep faces that `views_that_see` counts.
  double psnr_db = kNaN;
  std::int64_t pixels = 0;  ///< those
  std::int64_t views = 0;   ///< held-out ones that were looked at
};
ExactSurface exact_surface(const FieldViews& views);
/// The same where exposures and vignetting, measured on the true surfaces of all views, held-out
/// ones too, are taken out of what is averaged and put into what is shown. NaN where they are not
/// found.
ExactSurface exact_surface_at_one_exposure(const FieldViews& views);

}  // namespace cousin
