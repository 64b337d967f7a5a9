#include "sim/dataset/import_images.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/float_files.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/imaging/exif.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/image_size.h"
#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// The file, if it is one; a folder or a device of that name is an error.
std::optional<fs::path> regular_file(const fs::path& folder, const fs::path& relative) {
  const fs::path file = resolve_inside(folder, relative);
  if (!fs::exists(file)) return std::nullopt;
  if (!fs::is_regular_file(file)) throw std::runtime_error(file.string() + ": not a regular file");
  return file;
}

/// Pixels by the file's head; 0 of a file that whoever reads it says what is wrong with.
std::uint64_t depth_pixels(const fs::path& image) {
  try {
    const std::string ending = image.extension().string();
    if (ending == ".npy" || ending == ".exr") return float_pixels(image);
    const ImageSize size = read_image_size(image);
    return bytes_times(static_cast<std::uint64_t>(size.width_px),
                       static_cast<std::uint64_t>(size.height_px));
  } catch (const std::runtime_error&) {
    return 0;
  }
}

}  // namespace

void require_utf8(const std::string& name, const std::string& where) {
  if (is_utf8(name)) return;
  throw std::runtime_error(where + ": the name \"" + readable_utf8(cut_utf8(name, 200)) +
                           "\" is not UTF-8; rename the file in UTF-8");
}

std::optional<fs::path> find_listed_image(const fs::path& folder, const std::string& listed) {
  fs::path relative = listed;
  std::error_code error;
  if (listed.find('\\') != std::string::npos && !fs::exists(folder / relative, error)) {
    std::string forward = listed;
    std::replace(forward.begin(), forward.end(), '\\', '/');
    relative = forward;
  }
  const bool may_lack_ending = !relative.has_extension() || !fs::exists(folder / relative, error);
  if (!may_lack_ending || fs::is_regular_file(folder / relative, error))
    return regular_file(folder, relative);
  std::optional<fs::path> found;
  for (const char* ending : {".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG"}) {
    fs::path whole = relative;
    whole += ending;
    const std::optional<fs::path> file = regular_file(folder, whole);
    if (!file) continue;
    if (found) {
      throw std::runtime_error(folder.string() + ": the path \"" + listed + "\" is that of " +
                               found->filename().string() + " and of " + file->filename().string() +
                               "; keep one of them");
    }
    found = file;
  }
  return found;
}

void check_image_size(const fs::path& file, int frame, int width_px, int height_px,
                      const Camera& camera) {
  if (width_px == camera.width_px && height_px == camera.height_px) return;
  throw std::runtime_error(file.string() + " (frame " + std::to_string(frame) + "): the image is " +
                           std::to_string(width_px) + " x " + std::to_string(height_px) +
                           " pixels; its camera has " + std::to_string(camera.width_px) + " x " +
                           std::to_string(camera.height_px));
}

void warn_of_orientation(const std::vector<fs::path>& images, Capture& capture) {
  std::vector<int> orientation(images.size());
  for_each_frame(images.size(),
                 [&](std::size_t i) { orientation[i] = read_exif(images[i]).orientation; });
  const auto is_turned = [](int value) { return value != 1; };
  const auto first = std::find_if(orientation.begin(), orientation.end(), is_turned);
  if (first == orientation.end()) return;
  const auto count = std::count_if(orientation.begin(), orientation.end(), is_turned);
  capture.warnings.push_back(
      images[static_cast<std::size_t>(first - orientation.begin())].string() +
      ": EXIF orientation " + std::to_string(*first) + " (a viewer " +
      std::string(orientation_text(*first)) +
      ") is not applied: pixels are used as they are stored; so in " + std::to_string(count) +
      " of " + std::to_string(images.size()) + " images");
}

void check_images_memory(const fs::path& folder, const std::vector<fs::path>& images) {
  std::uint64_t bytes = 0;
  for (const fs::path& image : images) {
    ImageSize size;
    try {
      size = read_image_size(image);
    } catch (const std::runtime_error&) {
      continue;  // whoever reads it says what is wrong
    }
    bytes =
        bytes_plus(bytes, sizeof(Rgb8) * bytes_times(static_cast<std::uint64_t>(size.width_px),
                                                     static_cast<std::uint64_t>(size.height_px)));
  }
  check_memory(folder, bytes, std::to_string(images.size()) + " images");
}

void check_depth_memory(const fs::path& folder, const Capture& capture,
                        const std::vector<fs::path>& depth_images) {
  std::uint64_t bytes = 0;
  for (const Frame& frame : capture.frames) {
    for (const SensorFrame& sensor : frame.sensors)
      bytes = bytes_plus(bytes, sizeof(Rgb8) * std::uint64_t{sensor.color.size()});
  }
  for (const fs::path& image : depth_images)
    bytes = bytes_plus(bytes, bytes_times(sizeof(std::uint16_t), depth_pixels(image)));
  check_memory(folder, bytes,
               "the colour images and " + std::to_string(depth_images.size()) + " depth images");
}

void read_frame_colors(Capture& capture, const std::vector<fs::path>& images,
                       std::size_t sensor_index) {
  if (!images.empty()) check_images_memory(images.front().parent_path(), images);
  std::vector<char> alpha(images.size());
  for_each_frame(images.size(), [&](std::size_t i) {
    Frame& frame = capture.frames[i];
    SensorFrame& sensor = frame.sensors[sensor_index];
    sensor.color = read_color(images[i]);
    check_image_size(images[i], frame.id, sensor.color.width(), sensor.color.height(),
                     sensor.reported);
    alpha[i] = has_alpha(images[i]);
  });
  if (const auto first = std::find(alpha.begin(), alpha.end(), 1); first != alpha.end()) {
    capture.warnings.push_back(images[static_cast<std::size_t>(first - alpha.begin())].string() +
                               ": its alpha channel is not used; so in " +
                               std::to_string(std::count(alpha.begin(), alpha.end(), 1)) + " of " +
                               std::to_string(images.size()) + " images");
  }
  warn_of_orientation(images, capture);
}

}  // namespace cousin
