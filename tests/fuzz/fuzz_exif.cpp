#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "sim/imaging/exif.h"
#include "sim/imaging/image_size.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as a JPEG file with tags, and as an image whose head tells its size: within their
/// limits, or std::runtime_error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const ExifTags tags = exif_tags({data, size});
  if (tags.orientation < 1 || tags.orientation > 8) __builtin_trap();
  orientation_text(tags.orientation);
  const auto file = fuzz_file("image", data, size);
  try {
    const ImageSize image = read_image_size(file);
    if (image.width_px < 1 || image.height_px < 1) __builtin_trap();
    has_alpha(file);
  } catch (const std::runtime_error&) {
  }
  return 0;
}
