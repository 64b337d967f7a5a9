#pragma once

#include <cstdint>

#include "sim/types/image.h"

namespace cousin {

struct Scene;

/// Albedo at 850 nm of the instances that an image of ids shows; 0 where there is none. Textures
/// and prints are left out: the material's own number counts.
Image<float> infrared_albedo(const Scene& scene, const Image<std::int32_t>& instance,
                             const Image<std::uint16_t>& part);

}  // namespace cousin
