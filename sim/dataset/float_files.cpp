#include "sim/dataset/float_files.h"

#include <stdexcept>

#include "sim/imaging/exr_size.h"
#include "sim/imaging/exr_vectors.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"

namespace cousin {
namespace fs = std::filesystem;

std::string float_file(const fs::path& dir, const std::string& stem,
                       const std::vector<std::string>& endings) {
  std::string found;
  for (const std::string& ending : endings) {
    const std::string name = stem + ending;
    if (!fs::exists(dir / name)) continue;
    if (!found.empty()) {
      throw std::runtime_error((dir / found).string() + " and " + (dir / name).string() +
                               " are the same image; expected one of them");
    }
    found = name;
  }
  return found;
}

Image<float> read_floats(const fs::path& file) {
  return file.extension() == ".npy" ? read_npy(file) : read_exr(file);
}

Image<Eigen::Vector3f> read_float_vectors(const fs::path& file) {
  return file.extension() == ".npy" ? read_npy_vectors(file) : read_exr_vectors(file);
}

std::uint64_t float_pixels(const fs::path& file) {
  return file.extension() == ".npy" ? npy_pixels(file) : exr_pixels(file);
}

}  // namespace cousin
