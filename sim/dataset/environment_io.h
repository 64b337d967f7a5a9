#pragma once

#include <filesystem>

#include "sim/truth/scene.h"

namespace cousin {

/// An equirectangular OpenEXR with channels R, G, B, laid out as Environment says (row 0 at the
/// zenith, column 0 at azimuth -pi about +z), its radiance times `scale`.
/// @throws std::runtime_error naming the file: missing, truncated, another format, more than 2^24
/// pixels, or a radiance that is negative, not finite or above 1e20 after scaling.
Environment read_environment(const std::filesystem::path& file, double scale = 1);

}  // namespace cousin
