#include "sim/imaging/exr_size.h"

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

std::uint64_t pixels_of(const Imath::Box2i& window) {
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  return static_cast<std::uint64_t>(std::max<std::int64_t>(width, 0)) *
         static_cast<std::uint64_t>(std::max<std::int64_t>(height, 0));
}

}  // namespace

std::uint64_t exr_pixels(const std::filesystem::path& file) {
  try {
    const Imf::MultiPartInputFile exr(file.c_str());
    std::uint64_t most = 0;
    for (int part = 0; part < exr.parts(); ++part) {
      const Imf::Header& header = exr.header(part);
      most = std::max({most, pixels_of(header.dataWindow()), pixels_of(header.displayWindow())});
    }
    return most;
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace cousin
