#include "sim/dataset/rgbd_intrinsics.h"

#include <array>
#include <stdexcept>

#include "sim/dataset/calibration_files.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/camera_values.h"
#include "sim/dataset/capture_json.h"
#include "sim/dataset/import.h"
#include "sim/dataset/picture_list.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// Between the lenses of one device.
constexpr PairLimits kRgbdLimits = {0, 0.5};

void set_pair(CameraPair pair, std::optional<double> length_unit_m, RgbdCameras& cameras) {
  scale_pair(pair, length_unit_m, kRgbdLimits);
  cameras.color = pair.first;
  const bool is_same_place = pair.second_from_first.translation_m.norm() == 0 &&
                             angle_rad(pair.second_from_first.rotation) == 0;
  cameras.says_aligned = true;
  if (is_same_place && pair.first == pair.second) return;
  cameras.depth = pair.second;
  cameras.depth_from_color = pair.second_from_first;
}

/// The section of the colour camera, where there are sections.
YamlValues color_section(const YamlValues& values) {
  for (const char* name : {"color", "rgb", "intrinsic"}) {
    const YamlValues section = values.below(name);
    if (!section.empty()) return section;
  }
  return values;
}

/// A colour and a depth camera that are the same, where no pose stands between them: depth is in
/// the colour image's pixels.
bool are_same_cameras(const YamlValues& color, const YamlValues& depth, const PairSizes& sizes) {
  return camera_from_values(color, sizes[0]) == camera_from_values(depth, sizes[1]);
}

RgbdCameras of_values(const YamlValues& values, const PairSizes& sizes,
                      std::optional<double> length_unit_m) {
  RgbdCameras cameras;
  cameras.depth_keys = read_depth_keys(values);
  const std::optional<bool> aligned = cameras.depth_keys.aligned;
  const YamlValues color = color_section(values), depth = values.below("depth");
  if (!depth.empty() && color.name() == values.name())
    values.fail("has depth, but no section color beside it");
  const bool is_one =
      aligned.value_or(false) || (!aligned && !depth.empty() && !says_pair_pose(values) &&
                                  are_same_cameras(color, depth, sizes));
  if (!is_one) {
    if (const auto pair = pair_of_values(values, sizes)) {
      set_pair(*pair, length_unit_m, cameras);
      return cameras;
    }
    if (aligned)
      values.fail(
          "aligned = false, but there is one camera: write color, depth and depth_to_color");
  }
  cameras.color = camera_from_values(color, sizes[0]);
  cameras.says_aligned = is_one;
  return cameras;
}

RgbdCameras of_rig(std::string_view text, const std::string& name,
                   std::optional<double> length_unit_m) {
  RgbdCameras cameras;
  const std::vector<SensorReport> rig = rig_from_json(text, name).rig;
  cameras.color = rig.front().camera;
  cameras.says_aligned = true;
  const std::size_t depth = depth_sensor(rig);
  if (depth == rig.size()) return cameras;
  set_pair({rig.front().camera, rig[depth].camera,
            rig[depth].sensor_from_rig * inverse(rig.front().sensor_from_rig), 1,
            name + ": /sensors/" + std::to_string(depth) + "/sensor_from_rig"},
           length_unit_m, cameras);
  return cameras;
}

/// "fx 0 cx, 0 fy cy, 0 0 1", in 3 rows, or in 4 with zeros and a one more.
RgbdCameras of_matrix(std::string_view text, const std::string& name,
                      std::optional<ImageSize> size) {
  const std::vector<TextLine> lines = records(text, name);
  const std::size_t side = lines.size();
  if (side != 3 && side != 4)
    throw std::runtime_error(name + ": has " + std::to_string(side) +
                             " rows; a camera matrix has 3 or 4");
  std::array<std::array<double, 4>, 4> m{};
  for (std::size_t row = 0; row < side; ++row) {
    if (lines[row].size() != side)
      lines[row].fail("has " + std::to_string(lines[row].size()) + " numbers, not " +
                      std::to_string(side));
    for (std::size_t column = 0; column < side; ++column) {
      m[row][column] = lines[row].number(column);
      const bool may_be_any = row < 2 && (column == row || column == 2);
      if (!may_be_any && m[row][column] != (row == column ? 1 : 0))
        lines[row].fail("is not a row of fx 0 cx, 0 fy cy, 0 0 1");
    }
  }
  RgbdCameras cameras;
  cameras.color = {.fx_px = m[0][0], .fy_px = m[1][1], .cx_px = m[0][2], .cy_px = m[1][2]};
  if (size) {
    cameras.color.width_px = size->width_px;
    cameras.color.height_px = size->height_px;
  }
  try {
    validate(cameras.color);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(name + ": " + error.what());
  }
  return cameras;
}

std::vector<std::string> single_names() {
  // BoofCV writes intrinsic.yaml beside visualdepth.yaml, which says more.
  std::vector<std::string> names = calibration_names(
      {"visualdepth", "intrinsics", "intrinsic", "camera_intrinsics", "camera_intrinsic", "camera",
       "camera_info", "calibration", "camchain", "rig"});
  names.insert(names.end(), {"camera-intrinsics.txt", "camera_intrinsics.txt", "intrinsics.txt",
                             "intrinsic.txt"});
  return names;
}

/// color.yaml and depth.yaml.
std::optional<RgbdCameras> of_two_files(const fs::path& folder, const PairSizes& sizes,
                                        std::optional<double> length_unit_m) {
  const auto depth = calibration_there(folder, "depth");
  for (const char* stem : {"color", "colour", "rgb"}) {
    const auto color = calibration_there(folder, stem);
    if (!color || !depth) continue;
    const YamlValues a = values_of_file(read_calibration(*color), color->string());
    const YamlValues b = values_of_file(read_calibration(*depth), depth->string());
    RgbdCameras cameras;
    cameras.depth_keys = read_depth_keys(b);
    if (!b.first_keys().contains("T") && are_same_cameras(a, b, sizes)) {
      cameras.color = camera_from_values(a, sizes[0]);
      cameras.says_aligned = true;
    } else {
      set_pair(pair_of_two(a, b, sizes), length_unit_m, cameras);
    }
    return cameras;
  }
  return std::nullopt;
}

RgbdCameras of_file(const fs::path& file, const PairSizes& sizes,
                    std::optional<double> length_unit_m) {
  return rgbd_cameras_of_text(read_calibration(file), file.string(), sizes, length_unit_m);
}

}  // namespace

RgbdCameras rgbd_cameras_of_text(std::string_view text, const std::string& name,
                                 const PairSizes& sizes, std::optional<double> length_unit_m) {
  const std::string ending = lower_case(fs::path(name).extension().string());
  RgbdCameras cameras;
  if (ending == ".txt") return of_matrix(text, name, sizes[0]);
  if (ending == ".cameramodel") {
    cameras.color = camera_from_mrcal(text, name).camera;
    return cameras;
  }
  const YamlValues values = values_of_file(text, name);
  if (is_rig_json(values)) return of_rig(text, name, length_unit_m);
  if (!values.has("cam0.intrinsics")) return of_values(values, sizes, length_unit_m);
  const std::vector<CalibratedCamera> kalibr = cameras_from_kalibr(text, name);
  cameras.color = kalibr.front().camera;
  if (kalibr.size() > 2)
    throw std::runtime_error(name + ": has " + std::to_string(kalibr.size()) +
                             " cameras; keep those of colour and of depth");
  if (kalibr.size() == 2)
    set_pair({kalibr[0].camera, kalibr[1].camera, kalibr[1].camera_from_reference, 1,
              name + ": cam1.T_cn_cnm1"},
             length_unit_m, cameras);
  return cameras;
}

RgbdCameras rgbd_cameras(const fs::path& folder, const std::string& intrinsics,
                         const PairSizes& sizes, std::optional<double> length_unit_m) {
  std::error_code error;
  if (!intrinsics.empty() && fs::is_regular_file(intrinsics, error))
    return of_file(intrinsics, sizes, length_unit_m);
  if (!intrinsics.empty()) {
    RgbdCameras cameras;
    cameras.color =
        camera_from_intrinsics(intrinsics, sizes[0].value().width_px, sizes[0].value().height_px);
    return cameras;
  }
  const std::vector<fs::path> files = files_there(folder, single_names());
  if (files.empty()) {
    if (const auto cameras = of_two_files(folder, sizes, length_unit_m)) return *cameras;
    throw std::runtime_error(folder.string() +
                             ": no intrinsics (intrinsics.json, camera.yaml, color.yaml and "
                             "depth.yaml, camera-intrinsics.txt, ...): give --intrinsics, a file "
                             "or fx,fy,cx,cy[,k1,k2,p1,p2,k3]");
  }
  RgbdCameras cameras = of_file(files.front(), sizes, length_unit_m);
  for (std::size_t i = 1; i < files.size(); ++i) {
    const RgbdCameras other = of_file(files[i], sizes, length_unit_m);
    if (!(other.color == cameras.color) || other.depth || other.depth_keys.unit_m)
      throw std::runtime_error(files[i].string() + " and " + files.front().string() +
                               " say different things; give one of them by --intrinsics");
  }
  return cameras;
}

}  // namespace cousin
