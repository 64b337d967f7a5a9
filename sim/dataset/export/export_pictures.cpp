#include "sim/dataset/export/export_pictures.h"

#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/imaging/depth_registration.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/undistort.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

template <class Pixel>
void check_size(const Image<Pixel>& image, const Camera& camera, const fs::path& file) {
  if (image.width() == camera.width_px && image.height() == camera.height_px) return;
  throw std::runtime_error(file.string() + ": the image is " + std::to_string(image.width()) +
                           " x " + std::to_string(image.height()) + " pixels; its camera has " +
                           std::to_string(camera.width_px) + " x " +
                           std::to_string(camera.height_px));
}

template <class Pixel>
void write_undistorted(const Image<Pixel>& image, const Camera& lens, const Camera& handed,
                       const fs::path& from, const fs::path& to) {
  check_size(image, lens, from);
  fs::create_directories(to.parent_path());
  write_png(to, undistort(image, lens, {.pinhole = handed}).image);
}

}  // namespace

void write_once(const fs::path& file, const std::string& bytes) {
  std::error_code error;
  const bool same_size = fs::is_regular_file(file, error) && fs::file_size(file) == bytes.size();
  if (same_size && read_file(file, bytes.size()) == bytes) return;
  write_file(file, bytes);
}

void copy_once(const fs::path& from, const fs::path& to) { write_once(to, read_file(from)); }

std::string picture_ending(const ExportPicture& picture, const ExportOptions& options) {
  return options.undistort ? ".png" : picture.file.extension().string();
}

fs::path write_picture(const ExportPicture& picture, const Camera& lens, const Camera& handed,
                       const fs::path& stem, const ExportOptions& options) {
  const fs::path file = stem.string() + picture_ending(picture, options);
  if (!options.undistort) {
    copy_once(picture.file, file);
  } else if (picture.is_grey) {
    write_undistorted(read_png8(picture.file), lens, handed, picture.file, file);
  } else {
    write_undistorted(read_color(picture.file), lens, handed, picture.file, file);
  }
  return file;
}

ExportDepth depth_of(const ExportScene& scene, const ExportPicture& picture, const Camera& handed,
                     const ExportOptions& options) {
  const fs::path& file = scene.depth_images[picture.frame];
  if (file.empty()) return {};
  const ExportPicture source{picture.frame, *scene.depth_sensor, file, false};
  const ExportCamera from = camera_of(scene, source, options.true_cameras);
  const ExportCamera to = camera_of(scene, picture, options.true_cameras);
  ExportDepth result;
  result.unit_m = scene.capture.frames[picture.frame].sensors[*scene.depth_sensor].depth_unit_m;
  result.depth = read_png16(file);
  check_size(result.depth, from.camera, file);
  if (*scene.depth_sensor == picture.sensor) {
    if (options.undistort) {
      const UndistortConfig config{.interpolation = UndistortConfig::Interpolation::nearest,
                                   .pinhole = handed};
      result.depth = undistort(result.depth, to.camera, config).image;
    }
    return result;
  }
  const std::vector<SensorReport>& rig = scene.capture.rig;
  Pose to_from =
      rig[picture.sensor].sensor_from_rig * inverse(rig[*scene.depth_sensor].sensor_from_rig);
  if (options.true_cameras) to_from = *to.camera_from_world * inverse(*from.camera_from_world);
  result.depth = register_depth(result.depth, result.unit_m, from.camera, handed, to_from);
  return result;
}

}  // namespace cousin
