#pragma once

#include <numbers>

namespace cousin {

inline constexpr double kPi = std::numbers::pi;
inline constexpr float kPiF = std::numbers::pi_v<float>;
inline constexpr float kInversePiF = std::numbers::inv_pi_v<float>;

}  // namespace cousin
