#include "sim/dataset/depth_images.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/dataset/depth_codes.h"
#include "sim/dataset/float_files.h"
#include "sim/dataset/picture_list.h"
#include "sim/dataset/text_fields.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr double kMostFloatDepth_m = 1000;

DepthImage of_floats(const fs::path& file, double unit_m) {
  Image<float> depth_m = read_floats(file);
  DepthImage result;
  double most_m = 0;
  for (float& value : depth_m) {
    const double metres = unit_m * static_cast<double>(value);
    if (metres < 0)
      throw std::runtime_error(file.string() + ": the depth " + exact_text(metres) +
                               " m is below 0; where there is none, 0 or NaN must stand");
    result.cut += metres > kMostFloatDepth_m ? 1 : 0;
    const bool is_depth = metres > 0 && metres <= kMostFloatDepth_m;
    value = is_depth ? static_cast<float>(metres) : std::numeric_limits<float>::quiet_NaN();
    if (is_depth) most_m = std::max(most_m, static_cast<double>(value));
  }
  const double step_mm = depth_step_mm(most_m);
  result.units = depth_codes(depth_m, step_mm);
  result.unit_m = 1e-3 * step_mm;
  return result;
}

}  // namespace

bool is_float_depth(const fs::path& file) {
  const std::string ending = lower_case(file.extension().string());
  return ending == ".npy" || ending == ".exr";
}

DepthImage read_depth_image(const fs::path& file, const DepthMeaning& meaning) {
  if (is_float_depth(file)) return of_floats(file, meaning.float_unit_m);
  DepthImage result;
  result.units = read_png16(file);
  for (std::uint16_t& value : result.units) {
    // A reader that gives no depth writes its type's largest number, as in 7-Scenes.
    if (value > meaning.most) ++result.cut;
    if (value > meaning.most || value == meaning.no_depth) value = 0;
  }
  return result;
}

ImageSize depth_image_size(const fs::path& file) {
  if (!is_float_depth(file)) return read_image_size(file);
  const Image<float> image = read_floats(file);
  return {image.width(), image.height()};
}

}  // namespace cousin
