#include "benchmarks/suites/light/reference_store.h"

#include <stdexcept>
#include <string_view>

#include "sim/dataset/manifest.h"
#include "sim/imaging/exr_color.h"
#include "sim/imaging/image_io.h"

namespace cousin {

std::vector<Image<Rgbf>> reference_passes(const std::filesystem::path& folder,
                                          const std::string& name, const std::string& key,
                                          int passes,
                                          const std::function<Image<Rgbf>(int pass)>& render) {
  const std::string stem = name + "_" + sha256_hex(key).substr(0, 16) + "_";
  std::vector<Image<Rgbf>> images;
  for (int i = 0; i < passes; ++i) {
    const std::filesystem::path file = folder / (stem + std::to_string(i) + ".exr");
    if (std::filesystem::exists(file)) {
      images.push_back(read_exr_color(file));
    } else {
      images.push_back(render(i));
      write_exr_color(file, images.back());
    }
    if (images.back().width() != images[0].width() || images.back().height() != images[0].height())
      throw std::runtime_error(file.string() + ": not as large as the reference's first pass");
  }
  return images;
}

std::string image_hash(const Image<Rgbf>& image) {
  const auto* bytes = reinterpret_cast<const char*>(image.data());
  return sha256_hex(std::to_string(image.width()) + " " + std::to_string(image.height()) + "\n" +
                    std::string(bytes, image.size() * sizeof(Rgbf)));
}

}  // namespace cousin
