// Colour and depth images in folders or beside each other (rgbd_files.h), with their intrinsics
// (rgbd_intrinsics.h). Depth is in the colour image's pixels, or in those of a camera of its own,
// which becomes the sensor "depth".

#include <algorithm>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/depth_images.h"
#include "sim/dataset/depth_units.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/matrix_pose.h"
#include "sim/dataset/rgbd_files.h"
#include "sim/dataset/rgbd_intrinsics.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPoseBytes = std::size_t{1} << 16;

const fs::path& first_depth(const fs::path& folder, const std::vector<RgbdFile>& frames) {
  const auto found = std::find_if(frames.begin(), frames.end(),
                                  [](const RgbdFile& frame) { return frame.depth.has_value(); });
  if (found == frames.end())
    throw std::runtime_error(folder.string() +
                             ": no colour image has a depth image within 0.02 s of it");
  return *found->depth;
}

/// Rig, frames and poses, without images.
Capture rgbd_capture(const RgbdFiles& files, const RgbdCameras& cameras) {
  Capture capture;
  capture.warnings = files.warnings;
  capture.rig.push_back({.camera = cameras.color});
  if (cameras.depth)
    capture.rig.push_back({.name = std::string(kDepthSensor),
                           .camera = *cameras.depth,
                           .sensor_from_rig = cameras.depth_from_color});
  for (const RgbdFile& file : files.frames) {
    Frame& frame = capture.frames.emplace_back();
    frame.id = static_cast<int>(capture.frames.size()) - 1;
    frame.time_s = file.time_s;
    for (const SensorReport& sensor : capture.rig)
      frame.sensors.push_back({.reported = sensor.camera});
    if (!file.pose) continue;
    const std::optional<Pose> world_from_camera =
        pose_of_text(read_file(*file.pose, kMostPoseBytes), file.pose->string());
    if (world_from_camera)
      frame.rig_from_world = inverse(*world_from_camera);
    else
      capture.warnings.push_back(file.pose->string() + ": not finite: the frame has no pose");
  }
  return capture;
}

/// Colour and depth of one camera must be of one size; a camera of its own has its own.
void check_depth_size(const fs::path& file, int frame, const Image<std::uint16_t>& depth,
                      const Camera& camera, bool is_aligned) {
  if (is_aligned && (depth.width() != camera.width_px || depth.height() != camera.height_px))
    throw std::runtime_error(
        file.string() + " (frame " + std::to_string(frame) + "): the depth image is " +
        std::to_string(depth.width()) + " x " + std::to_string(depth.height()) +
        " pixels, but the colour camera has " + std::to_string(camera.width_px) + " x " +
        std::to_string(camera.height_px) +
        ": it has a camera of its own; give color, depth and depth_to_color (docs/formats.md)");
  check_image_size(file, frame, depth.width(), depth.height(), camera);
}

/// Reads the depth images into the rig's last sensor. @return those that are whole numbers.
std::size_t read_depths(const fs::path& folder, const RgbdFiles& files, const DepthMeaning& meaning,
                        Capture& capture) {
  std::vector<fs::path> there;
  for (const RgbdFile& file : files.frames) {
    if (file.depth) there.push_back(*file.depth);
  }
  check_depth_memory(folder, capture, there);
  std::vector<std::size_t> cut(files.frames.size());
  for_each_frame(files.frames.size(), [&](std::size_t i) {
    if (!files.frames[i].depth) return;
    const fs::path& file = *files.frames[i].depth;
    SensorFrame& sensor = capture.frames[i].sensors.back();
    DepthImage depth = read_depth_image(file, meaning);
    check_depth_size(file, capture.frames[i].id, depth.units, sensor.reported,
                     capture.rig.size() == 1);
    sensor.depth = std::move(depth.units);
    sensor.depth_unit_m = depth.unit_m;
    cut[i] = depth.cut;
  });
  const auto first = std::find_if(cut.begin(), cut.end(), [](std::size_t n) { return n > 0; });
  if (first != cut.end()) {
    const auto at = static_cast<std::size_t>(first - cut.begin());
    capture.warnings.push_back(
        files.frames[at].depth->string() + ": " + std::to_string(*first) +
        " pixels are beyond the largest depth and count as none; so in " +
        std::to_string(std::count_if(cut.begin(), cut.end(), [](std::size_t n) { return n > 0; })) +
        " of " + std::to_string(there.size()) + " depth images");
  }
  return static_cast<std::size_t>(std::count_if(
      there.begin(), there.end(), [](const fs::path& file) { return !is_float_depth(file); }));
}

/// The unit of whole numbers, by the option or by the file; where neither says it, what the median
/// would be in usual units.
void set_depth_units(const std::string& place, const DepthKeys& keys,
                     std::optional<double> depth_unit_m, Capture& capture) {
  const std::optional<double> unit_m = depth_unit_m ? depth_unit_m : keys.unit_m;
  const std::size_t sensor = capture.rig.size() - 1;
  if (!unit_m) {
    const double units = median_depth(capture, sensor, DepthMeasure::units).value_or(0);
    throw std::runtime_error(place +
                             ": nothing says the unit of the depth images; their median is " +
                             exact_text(units) + " units. " + usual_depth_units(units) +
                             "; or write depth_unit_m into the intrinsics");
  }
  if (depth_unit_m && keys.unit_m && *depth_unit_m != *keys.unit_m)
    capture.warnings.push_back(keys.unit_key + " says " + short_text(*keys.unit_m) +
                               " m a unit, --depth-unit " + short_text(*depth_unit_m) +
                               ", which counts");
  for (Frame& frame : capture.frames) frame.sensors[sensor].depth_unit_m = *unit_m;
}

/// Reads depth, and makes sure of its unit.
void add_depth(const fs::path& folder, const RgbdFiles& files, const DepthKeys& keys,
               std::optional<double> depth_unit_m, Capture& capture) {
  const bool has_folder = fs::is_directory(folder / files.depth_name);
  const std::string place = (has_folder ? folder / files.depth_name : folder).string();
  const bool may_be_float = std::any_of(
      files.frames.begin(), files.frames.end(),
      [](const RgbdFile& frame) { return frame.depth && is_float_depth(*frame.depth); });
  if (may_be_float && keys.unit_m && !depth_unit_m)
    throw std::runtime_error(keys.unit_key + " is a unit of whole numbers, but " + place +
                             " holds floats: give --depth-unit 1 if these are metres");
  const std::size_t whole =
      read_depths(folder, files, {depth_unit_m.value_or(1), keys.none, keys.most}, capture);
  if (whole > 0 && may_be_float)
    throw std::runtime_error(place +
                             ": depth images are whole numbers (PNG) and floats; keep one "
                             "kind of them");
  const std::size_t sensor = capture.rig.size() - 1;
  if (whole > 0) set_depth_units(place, keys, depth_unit_m, capture);
  check_median_depth(capture, sensor, place,
                     whole > 0 ? "" : "Give --depth-unit, metres that a float of 1 is");
}

}  // namespace

Capture import_rgbd(const fs::path& folder, const std::string& intrinsics,
                    const ImportUnits& units) {
  const RgbdFiles files = find_rgbd_files(folder);
  const fs::path& depth = first_depth(folder, files.frames);
  const RgbdCameras cameras = rgbd_cameras(
      folder, intrinsics, {read_image_size(files.frames.front().color), depth_image_size(depth)},
      units.length_m);
  Capture capture = rgbd_capture(files, cameras);
  std::vector<fs::path> images;
  for (const RgbdFile& file : files.frames) images.push_back(file.color);
  read_frame_colors(capture, images);
  add_depth(folder, files, cameras.depth_keys, units.depth_m, capture);
  if (!cameras.says_aligned)
    capture.warnings.push_back(
        folder.string() +
        ": one camera is given for colour and depth: depth is taken to be in "
        "the colour image's pixels");
  return capture;
}

}  // namespace cousin
