#pragma once

namespace cousin {

/// Standard deviation of normal noise over its median absolute deviation.
inline constexpr double kNormalMad = 1.4826;

}  // namespace cousin
