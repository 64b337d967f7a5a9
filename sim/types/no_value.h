#pragma once

#include <limits>

namespace cousin {

/// What images of measured values hold where nothing was measured.
inline constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

}  // namespace cousin
