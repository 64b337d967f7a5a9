// A stereo pair: pictures of two cameras side by side, and their calibration.
//   left/ right/, image_0/ image_1/, image_2/ image_3/, cam0/ cam1/ (pictures in data/ too), or
//   files with these words in their names: im0.png im1.png, chair01_left.jpg chair01_right.jpg
// The calibration is one file (stereo.yaml, calib.txt, camchain.yaml, ...) or two (left.yaml and
// right.yaml; intrinsics.yml and extrinsics.yml; cam0/sensor.yaml and cam1/sensor.yaml).

#include <algorithm>
#include <stdexcept>

#include "sim/dataset/calibration_files.h"
#include "sim/dataset/camera_values.h"
#include "sim/dataset/image_pairs.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr PairLimits kStereoLimits = {0.005, 2};
constexpr std::size_t kMostStereoFrames = 1'000'000;

PairNames stereo_names(std::string_view first, std::string_view second) {
  const std::vector<std::string_view> endings = {".png", ".jpg", ".jpeg"};
  return {{first}, {second}, {first}, {second}, endings, endings};
}

/// Colour before grey where KITTI has both.
std::vector<PairNames> all_stereo_names() {
  return {stereo_names("left", "right"),
          stereo_names("image_2", "image_3"),
          stereo_names("image_02", "image_03"),
          stereo_names("image_0", "image_1"),
          stereo_names("image_00", "image_01"),
          stereo_names("cam0", "cam1"),
          stereo_names("im0", "im1")};
}

/// The camera's number of "image_2" or "image_02"; -1 of another name.
int kitti_number(const std::string& name) {
  const bool is_kitti = name.starts_with("image_") && name.size() <= 8;
  return is_kitti ? name.back() - '0' : -1;
}

std::vector<std::string> one_file_names() {
  std::vector<std::string> names = calibration_names(
      {"stereo", "stereo_calib", "stereo_calibration", "calib", "calibration", "camchain", "rig"});
  names.insert(names.end(), {"calib.txt", "calib_cam_to_cam.txt"});
  return names;
}

/// The pair of two files, one a camera, or of lenses and pose.
std::optional<CameraPair> pair_of_two_files(const fs::path& folder, const PictureHalves& halves,
                                            const PairSizes& sizes) {
  const std::vector<std::array<std::string, 2>> kStems = {
      {"left", "right"},
      {"rgb", "rgb_right"},
      {"cam0", "cam1"},
      {halves.first_name + "/sensor", halves.second_name + "/sensor"},
      {halves.first_name + "/camera_info", halves.second_name + "/camera_info"},
      {"intrinsics", "extrinsics"}};
  for (const auto& stems : kStems) {
    const auto first = calibration_there(folder, stems[0]);
    const auto second = calibration_there(folder, stems[1]);
    if (!first || !second) continue;
    const YamlValues a = values_of_file(read_calibration(*first), first->string());
    const YamlValues b = values_of_file(read_calibration(*second), second->string());
    return stems[1] == "extrinsics" ? pair_of_opencv(a, b, sizes) : pair_of_two(a, b, sizes);
  }
  return std::nullopt;
}

CameraPair stereo_pair(const fs::path& folder, const std::string& intrinsics,
                       const PictureHalves& halves, const PairSizes& sizes) {
  const std::array<int, 2> numbers = {kitti_number(halves.first_name),
                                      kitti_number(halves.second_name)};
  std::vector<fs::path> files;
  if (!intrinsics.empty())
    files.emplace_back(intrinsics);
  else
    files = files_there(folder, one_file_names());
  if (files.size() > 1)
    throw std::runtime_error(files[0].string() + " and " + files[1].string() +
                             " are calibrations of the pair; give one of them by --intrinsics");
  if (files.empty()) {
    if (const auto pair = pair_of_two_files(folder, halves, sizes)) return *pair;
    throw std::runtime_error(
        folder.string() +
        ": no calibration of the pair (stereo.yaml, calib.txt, camchain.yaml, left.yaml and "
        "right.yaml, intrinsics.yml and extrinsics.yml): give --intrinsics, a file of two cameras");
  }
  if (const auto pair = pair_of_file(files.front(), sizes, numbers)) return *pair;
  throw std::runtime_error(files.front().string() +
                           ": has one camera; a pair needs both and the pose between them: M1, D1, "
                           "M2, D2, R, T of OpenCV, or left, right and right_to_left");
}

/// The second camera must stand on the right of the first.
void check_order(const CameraPair& pair) {
  const Eigen::Vector3d centre =
      centre_in_world_m(pair.second_from_first) + Eigen::Vector3d::Zero();  // no -0 in messages
  const double across = std::max(std::abs(centre.y()), std::abs(centre.z()));
  if (centre.x() > across) return;
  throw std::runtime_error(pair.place + ": the second camera stands at (" + short_text(centre.x()) +
                           ", " + short_text(centre.y()) + ", " + short_text(centre.z()) +
                           ") m of the first, x to the right: " +
                           (centre.x() < -across ? "on its left. Are left and right swapped?"
                                                 : "not on its right, as a stereo pair's must"));
}

/// Both halves have the same names.
std::vector<std::string> keys_of_both(const fs::path& folder, const PictureHalves& halves) {
  std::vector<std::string> keys;
  const auto lacks = [&](const fs::path& file, const std::string& other) {
    throw std::runtime_error(
        file.string() + ": has no partner of its name in " + (folder / other).string() + " (" +
        std::to_string(halves.first.size()) + " pictures are " + halves.first_name + ", " +
        std::to_string(halves.second.size()) + " are " + halves.second_name + ")");
  };
  for (const auto& [key, file] : halves.first) {
    if (!halves.second.contains(key)) lacks(file, halves.second_name);
    keys.push_back(key);
  }
  for (const auto& [key, file] : halves.second) {
    if (!halves.first.contains(key)) lacks(file, halves.first_name);
  }
  if (keys.size() > kMostStereoFrames)
    throw std::runtime_error(folder.string() + ": " + std::to_string(keys.size()) +
                             " pairs; the limit is 1000000");
  return keys;
}

}  // namespace

Capture import_stereo(const fs::path& folder, const std::string& intrinsics,
                      std::optional<double> length_unit_m) {
  const std::vector<PairNames> names = all_stereo_names();
  PictureHalves halves = find_halves(
      folder, names,
      "two folders left/ and right/ (or image_0 and image_1, image_2 and image_3, cam0 and cam1), "
      "nor pictures with such words in their names, as im0.png and im1.png");
  const std::vector<std::string> keys = keys_of_both(folder, halves);
  std::array<std::vector<fs::path>, 2> images;
  for (const std::string& key : keys) {
    images[0].push_back(halves.first.at(key));
    images[1].push_back(halves.second.at(key));
  }
  CameraPair pair =
      stereo_pair(folder, intrinsics, halves,
                  {read_image_size(images[0].front()), read_image_size(images[1].front())});
  scale_pair(pair, length_unit_m, kStereoLimits);
  check_order(pair);

  Capture capture;
  capture.warnings = std::move(halves.warnings);
  capture.rig.push_back({.camera = pair.first});
  capture.rig.push_back(
      {.name = "rgb_right", .camera = pair.second, .sensor_from_rig = pair.second_from_first});
  for (const double time_s : times_of_names(keys)) {
    Frame& frame = capture.frames.emplace_back();
    frame.id = static_cast<int>(capture.frames.size()) - 1;
    frame.time_s = time_s;
    for (const SensorReport& sensor : capture.rig)
      frame.sensors.push_back({.reported = sensor.camera});
  }
  std::vector<fs::path> all = images[0];
  all.insert(all.end(), images[1].begin(), images[1].end());
  check_images_memory(folder, all);
  for (std::size_t s = 0; s < 2; ++s) read_frame_colors(capture, images[s], s);
  return capture;
}

}  // namespace cousin
