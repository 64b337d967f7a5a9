#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/camera_values.h"
#include "sim/dataset/capture_json.h"
#include "sim/dataset/exif_focal.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/picture_list.h"
#include "sim/dataset/text_fields.h"
#include "sim/imaging/image_io.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// Sorted by name. What looks like a picture of a format that is not read is added to `warnings`.
std::vector<fs::path> images_in(const fs::path& folder, std::vector<std::string>& warnings) {
  PictureList list = list_pictures(folder, {".png", ".jpg", ".jpeg"});
  if (list.files.empty())
    throw std::runtime_error(folder.string() + ": no .png, .jpg or .jpeg in this folder" +
                             (list.not_read.empty() ? "" : "; " + list.not_read));
  if (!list.not_read.empty()) warnings.push_back(folder.string() + ": " + list.not_read);
  return std::move(list.files);
}

/// "fx,fy,cx,cy[,k1,k2,p1,p2,k3]" without a size.
Camera camera_from_text(const std::string& text) {
  const auto fail = [&](const std::string& what) {
    throw std::invalid_argument("intrinsics \"" + cut_utf8(text, 200) + "\": " + what +
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
  if (!fs::is_regular_file(intrinsics, error)) {
    const std::string ending = fs::path(intrinsics).extension().string();
    if (ending == ".yaml" || ending == ".yml" || ending == ".json" || ending == ".cameramodel" ||
        intrinsics.find('/') != std::string::npos)
      throw std::runtime_error("intrinsics \"" + intrinsics + "\": no such file");
    return std::nullopt;
  }
  const std::string text = read_file(intrinsics, std::size_t{1} << 24);
  if (fs::path(intrinsics).extension() == ".json") {
    const YamlValues values = YamlValues::of_json(text, intrinsics);
    return is_rig_json(values) ? rig_from_json(text, intrinsics).rig.front().camera
                               : camera_from_values(values);
  }
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
    throw std::invalid_argument("intrinsics \"" + intrinsics + "\": " + error.what());
  }
  return camera;
}

Camera camera_of_focal(double focal_px, int width_px, int height_px) {
  return {.width_px = width_px,
          .height_px = height_px,
          .fx_px = focal_px,
          .fy_px = focal_px,
          .cx_px = 0.5 * (width_px - 1),
          .cy_px = 0.5 * (height_px - 1)};
}

namespace {

/// The lens of photographs without a calibration, said in a warning.
Camera lens_without_calibration(const fs::path& folder, const std::vector<fs::path>& images,
                                const LensOfPhotographs& solve, Capture& capture) {
  const Image<Rgb8>& first = capture.frames.front().sensors.front().color;
  AssumedLens lens;
  if (const auto focal = exif_focal(images, first.width(), first.height())) {
    lens.camera = camera_of_focal(focal->focal_px, first.width(), first.height());
    lens.focal_sigma_px = focal->sigma_px;
    lens.from = "from " + focal->from + "; no distortion, centre of the image assumed";
  } else if (solve) {
    lens = solve(capture);
  } else {
    throw std::runtime_error(folder.string() +
                             ": the lens is not known: no photograph has a focal length in EXIF; "
                             "give --intrinsics");
  }
  validate(lens.camera);
  capture.warnings.push_back(
      folder.string() + ": without --intrinsics the focal length is " +
      short_text(lens.camera.fx_px) + " px, standard deviation " + short_text(lens.focal_sigma_px) +
      " px (" + short_text(100 * lens.focal_sigma_px / lens.camera.fx_px) + " %), " + lens.from);
  return lens.camera;
}

}  // namespace

Capture import_folder(const fs::path& folder, const std::string& intrinsics,
                      const LensOfPhotographs& solve) {
  Capture capture;
  const std::vector<fs::path> images = images_in(folder, capture.warnings);
  check_images_memory(folder, images);
  capture.frames.resize(images.size());
  for_each_frame(images.size(), [&](std::size_t i) {
    Frame& frame = capture.frames[i];
    frame.id = static_cast<int>(i);
    frame.time_s = static_cast<double>(i);
    frame.sensors.resize(1);
    frame.sensors.front().color = read_color(images[i]);
  });

  const Image<Rgb8>& first = capture.frames.front().sensors.front().color;
  const auto check_sizes = [&](const Camera& camera) {
    for (const Frame& frame : capture.frames) {
      const Image<Rgb8>& color = frame.sensors.front().color;
      check_image_size(images[static_cast<std::size_t>(frame.id)], frame.id, color.width(),
                       color.height(), camera);
    }
  };
  Camera camera{.width_px = first.width(), .height_px = first.height()};
  if (intrinsics.empty()) {
    check_sizes(camera);
    camera = lens_without_calibration(folder, images, solve, capture);
  } else {
    camera = camera_from_intrinsics(intrinsics, first.width(), first.height());
    check_sizes(camera);
  }
  for (Frame& frame : capture.frames) frame.sensors.front().reported = camera;
  warn_of_orientation(images, capture);
  capture.rig.push_back({.camera = camera});
  return capture;
}

}  // namespace cousin
