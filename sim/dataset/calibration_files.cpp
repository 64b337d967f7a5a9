#include "sim/dataset/calibration_files.h"

#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/camera_values.h"
#include "sim/dataset/capture_json.h"
#include "sim/dataset/picture_list.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostCalibrationBytes = std::size_t{1} << 24;

CameraPair pair_of_kalibr(const std::string& text, const std::string& name) {
  const std::vector<CalibratedCamera> cameras = cameras_from_kalibr(text, name);
  if (cameras.size() > 2)
    throw std::runtime_error(name + ": has " + std::to_string(cameras.size()) +
                             " cameras; keep the two that took the images");
  return {cameras[0].camera, cameras[1].camera, cameras[1].camera_from_reference, 1,
          name + ": cam1.T_cn_cnm1"};
}

CameraPair pair_of_text(const std::string& text, const std::string& name, const PairSizes& sizes,
                        const std::array<int, 2>& kitti_numbers) {
  if (text.find("cam0=") != std::string::npos) return pair_of_middlebury(text, name);
  if (text.find("P0:") == std::string::npos && text.find("P_rect_0") == std::string::npos)
    throw std::runtime_error(name +
                             ": neither Middlebury's calib.txt (cam0=...) nor KITTI's (P0: ...)");
  if (kitti_numbers[0] < 0)
    throw std::runtime_error(name + ": which of its cameras took the images is not known: name " +
                             "their folders image_0 and image_1, or image_2 and image_3");
  return pair_of_kitti(text, name, kitti_numbers, sizes);
}

}  // namespace

std::string read_calibration(const fs::path& file) {
  return read_file(file, kMostCalibrationBytes);
}

std::vector<fs::path> files_there(const fs::path& folder, const std::vector<std::string>& names) {
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    if (fs::exists(fs::symlink_status(folder / name)))
      files.push_back(resolve_inside(folder, name));
  }
  return files;
}

std::vector<std::string> calibration_names(const std::vector<std::string>& stems) {
  std::vector<std::string> names;
  for (const std::string& stem : stems) {
    for (const char* ending : {".yaml", ".yml", ".json"}) names.push_back(stem + ending);
  }
  return names;
}

std::optional<fs::path> calibration_there(const fs::path& folder, const std::string& stem) {
  const std::vector<fs::path> files = files_there(folder, calibration_names({stem}));
  if (files.size() > 1)
    throw std::runtime_error(files[0].string() + " and " + files[1].string() +
                             ": two calibrations of one camera; keep one of them");
  return files.empty() ? std::nullopt : std::optional(files.front());
}

CameraPair pair_of_rig(std::string_view text, const std::string& name) {
  const std::vector<SensorReport> rig = rig_from_json(text, name).rig;
  if (rig.size() < 2) throw std::runtime_error(name + ": /sensors has one sensor; a pair has two");
  return {rig[0].camera, rig[1].camera, rig[1].sensor_from_rig * inverse(rig[0].sensor_from_rig), 1,
          name + ": /sensors/1/sensor_from_rig"};
}

std::optional<CameraPair> pair_of_file(const fs::path& file, const PairSizes& sizes,
                                       const std::array<int, 2>& kitti_numbers) {
  const std::string name = file.string(), text = read_calibration(file);
  if (lower_case(file.extension().string()) == ".txt")
    return pair_of_text(text, name, sizes, kitti_numbers);
  const YamlValues values = values_of_file(text, name);
  if (is_rig_json(values)) return pair_of_rig(text, name);
  if (values.has("cam1.intrinsics")) return pair_of_kalibr(text, name);
  return pair_of_values(values, sizes);
}

}  // namespace cousin
