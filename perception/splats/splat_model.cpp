#include "perception/splats/splat_model.h"

#include <algorithm>
#include <cmath>

namespace cousin {

bool is_finite(const Splat& splat) {
  const auto finite = [](float value) { return std::isfinite(value); };
  return splat.centre_m.allFinite() && splat.log_scale.allFinite() &&
         splat.rotation_wxyz.allFinite() && finite(splat.opacity_logit) &&
         std::all_of(splat.sh_dc.begin(), splat.sh_dc.end(), finite) &&
         std::all_of(splat.sh_rest.begin(), splat.sh_rest.end(), finite);
}

}  // namespace cousin
