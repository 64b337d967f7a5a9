#pragma once

#include <embree3/rtcore.h>

#include <limits>

namespace cousin {

inline constexpr unsigned int kNoGeometry = RTC_INVALID_GEOMETRY_ID;  ///< of a ray that met nothing
inline constexpr float kFar =
    std::numeric_limits<float>::infinity();  ///< length of a ray without end

}  // namespace cousin
