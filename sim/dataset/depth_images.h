#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "sim/imaging/image_size.h"
#include "sim/types/image.h"

namespace cousin {

/// Private to sim/dataset: depth images of other programs, 16-bit PNG or floats (.npy, .exr).

struct DepthImage {
  Image<std::uint16_t> units;  ///< 0 = none
  double unit_m = 0;           ///< of floats; 0: a PNG, which does not say
  std::size_t cut = 0;         ///< pixels beyond what the format or the program can say
};

/// What a file's numbers mean.
struct DepthMeaning {
  double float_unit_m = 1;     ///< metres that a float of 1 is
  std::uint16_t no_depth = 0;  ///< whole number that means none, beside 0 and 65535
  std::uint16_t most = 65534;  ///< whole numbers above it are none
};

bool is_float_depth(const std::filesystem::path& file);

/// Of floats NaN, infinity, 0 and what is above 1000 m is none; the others become steps of 0.1 mm,
/// or of 1 mm, 1 cm, ... where the farthest is beyond 6.5 m, 65 m, ...
/// @throws std::runtime_error naming the file, a PNG that is not 16-bit grey, or a depth below 0.
DepthImage read_depth_image(const std::filesystem::path& file, const DepthMeaning& meaning);

/// Size of a depth image; of floats the pixels are read too.
ImageSize depth_image_size(const std::filesystem::path& file);

}  // namespace cousin
