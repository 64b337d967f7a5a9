#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/capture_json.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> images_in(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + ": not a folder");
  std::vector<fs::path> images;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension != ".png" && extension != ".jpg" && extension != ".jpeg") continue;
    images.push_back(resolve_inside(folder, entry.path().filename()));
  }
  if (images.empty())
    throw std::runtime_error(folder.string() + ": no .png, .jpg or .jpeg in this folder");
  std::sort(images.begin(), images.end());
  return images;
}

/// "fx,fy,cx,cy[,k1,k2,p1,p2,k3]" without a size.
Camera camera_from_text(const std::string& text) {
  const auto fail = [&](const std::string& what) {
    throw std::runtime_error("intrinsics \"" + text.substr(0, 200) + "\": " + what +
                             "; give a YAML file, a rig.json or fx,fy,cx,cy[,k1,k2,p1,p2,k3]");
  };
  std::vector<double> values;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || !std::isfinite(value))
      fail("number " + std::to_string(values.size() + 1) +
           " is not a finite number, and no such file exists");
    values.push_back(value);
    if (next == end) break;
    if (*next != ',' || values.size() > 9)
      fail("not numbers separated by commas, and no such file exists");
    at = next + 1;
  }
  if (values.size() < 4 || values.size() > 9)
    fail(std::to_string(values.size()) + " numbers; 4 to 9 are read");
  Camera camera{.fx_px = values[0], .fy_px = values[1], .cx_px = values[2], .cy_px = values[3]};
  if (values.size() > 4) {
    camera.model = LensModel::opencv5;
    std::copy(values.begin() + 4, values.end(), camera.distortion.begin());
  }
  return camera;
}

/// The camera of a file, or nothing where `intrinsics` is not the name of one.
std::optional<Camera> camera_from_file(const std::string& intrinsics) {
  std::error_code error;
  if (!fs::is_regular_file(intrinsics, error)) return std::nullopt;
  const std::string text = read_file(intrinsics, std::size_t{1} << 24);
  if (fs::path(intrinsics).extension() == ".json")
    return rig_from_json(text, intrinsics).rig.front().camera;
  if (fs::path(intrinsics).extension() == ".cameramodel")
    return camera_from_mrcal(text, intrinsics).camera;
  return camera_from_yaml(text, intrinsics);
}

}  // namespace

Camera camera_from_intrinsics(const std::string& intrinsics, int width_px, int height_px) {
  if (const std::optional<Camera> from_file = camera_from_file(intrinsics)) return *from_file;
  Camera camera = camera_from_text(intrinsics);
  camera.width_px = width_px;
  camera.height_px = height_px;
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("intrinsics \"" + intrinsics + "\": " + error.what());
  }
  return camera;
}

Capture import_folder(const fs::path& folder, const std::string& intrinsics) {
  const std::vector<fs::path> images = images_in(folder);
  Capture capture;
  capture.frames.resize(images.size());
  for_each_frame(images.size(), [&](std::size_t i) {
    Frame& frame = capture.frames[i];
    frame.id = static_cast<int>(i);
    frame.time_s = static_cast<double>(i);
    frame.sensors.resize(1);
    frame.sensors.front().color = read_color(images[i]);
  });

  const Image<Rgb8>& first = capture.frames.front().sensors.front().color;
  const Camera camera = camera_from_intrinsics(intrinsics, first.width(), first.height());
  for (Frame& frame : capture.frames) {
    SensorFrame& sensor = frame.sensors.front();
    sensor.reported = camera;
    check_image_size(images[static_cast<std::size_t>(frame.id)], frame.id, sensor.color.width(),
                     sensor.color.height(), camera);
  }
  capture.rig.push_back({.camera = camera});
  return capture;
}

}  // namespace cousin
