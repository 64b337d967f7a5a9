#include "benchmarks/app/dataset_check.h"

#include <iterator>
#include <stdexcept>
#include <string>

#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace fs = std::filesystem;

void check_unchanged(const fs::path& dataset, const Manifest& manifest, const fs::path& scene) {
  for (const auto& [path, hash] : manifest.files) {
    const fs::path name = path;
    const std::string ending = name.extension().string();
    const bool is_image = ending == ".png" || ending == ".exr" || ending == ".jpg";
    const bool is_truth =
        std::next(name.begin()) != name.end() && *std::next(name.begin()) == "truth";
    const bool is_read = !is_image || is_truth;
    if (*name.begin() != scene || !is_read || !fs::is_regular_file(dataset / name)) continue;
    if (sha256_hex_of_file(resolve_inside(dataset, name)) == hash) continue;
    throw std::runtime_error((dataset / name).string() +
                             ": its SHA-256 is not the one in manifest.json; the dataset was "
                             "changed since it was rendered, and its truth may be of other "
                             "pictures. Render it again (`cousin verify` lists every change)");
  }
}

}  // namespace cousin
