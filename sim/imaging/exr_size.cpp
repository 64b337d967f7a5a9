#include "sim/imaging/exr_size.h"

#include <ImfHeader.h>
#include <ImfInputFile.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>

namespace cousin {

std::uint64_t exr_pixels(const std::filesystem::path& file) {
  try {
    const Imf::InputFile exr(file.c_str());
    const Imath::Box2i& window = exr.header().dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    return static_cast<std::uint64_t>(std::max<std::int64_t>(width, 0)) *
           static_cast<std::uint64_t>(std::max<std::int64_t>(height, 0));
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace cousin
