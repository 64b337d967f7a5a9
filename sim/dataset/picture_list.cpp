#include "sim/dataset/picture_list.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import_images.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 1'000'000;

/// Endings of pictures; those that a reader takes are not among the ones that it does not.
constexpr std::array<std::string_view, 23> kPictureEndings = {
    ".png",  ".jpg", ".jpeg", ".npy", ".exr", ".heic", ".heif", ".avif",
    ".webp", ".tif", ".tiff", ".bmp", ".gif", ".jxl",  ".dng",  ".cr2",
    ".cr3",  ".nef", ".arw",  ".raf", ".pgm", ".ppm",  ".pfm"};

template <class Endings>
bool holds(const Endings& endings, std::string_view ending) {
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

}  // namespace

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

PictureList list_pictures(const fs::path& folder, const std::vector<std::string_view>& endings) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  PictureList list;
  std::vector<std::string> others;
  std::size_t count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (++count > kMostFiles)
      throw std::runtime_error(folder.string() + ": more than 1000000 files in one folder");
    const std::string name = entry.path().filename().string();
    if (name.starts_with('.')) continue;  // what systems put beside pictures
    const std::string ending = lower_case(entry.path().extension().string());
    if (holds(endings, ending)) {
      require_utf8(name, folder.string());
      list.files.push_back(resolve_inside(folder, entry.path().filename()));
    } else if (holds(kPictureEndings, ending)) {
      others.push_back(name);
    }
  }
  std::sort(list.files.begin(), list.files.end());
  if (!others.empty()) {
    std::sort(others.begin(), others.end());
    list.not_read = std::to_string(others.size()) + " pictures are not read, as " +
                    readable_utf8(others.front()) + ": only";
    for (const std::string_view ending : endings)
      list.not_read += (ending == endings.front() ? " " : ", ") + std::string(ending);
    list.not_read += " are";
  }
  return list;
}

}  // namespace cousin
