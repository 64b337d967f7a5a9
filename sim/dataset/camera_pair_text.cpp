// Calibrations of stereo benchmarks, rectified.
//   Middlebury   cam0=[f 0 cx; 0 f cy; 0 0 1], cam1, doffs (cx1 - cx0), baseline (mm), width,
//   height
//                [vision.middlebury.edu/stereo/data/scenes2014, "File formats"]
//   KITTI        P0: 12 numbers, of the 3 x 4 matrix K [1 | t]; S_rect_00: width height
//                [Geiger, Lenz & Urtasun, CVPR 2012, development kit]

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "sim/dataset/camera_pair.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

/// cx1 - cx0 may be rounded.
constexpr double kMostDoffsError_px = 1;

/// The values of lines "key=value" or "key: value".
using TextKeys = std::map<std::string, TextLine>;

/// @param name  outlives the lines
TextKeys keys_of_lines(std::string_view text, const std::string& name, char separator) {
  TextKeys keys;
  int number = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    ++number;
    const std::size_t at = line.find(separator);
    if (at == std::string_view::npos) continue;
    const TextLine key(line.substr(0, at), name, number);
    if (key.size() != 1) continue;
    const bool is_new =
        keys.emplace(key.text(0), TextLine(line.substr(at + 1), name, number)).second;
    if (!is_new) key.fail("the key " + key.text(0) + " stands twice");
  }
  return keys;
}

const TextLine& line_of(const TextKeys& keys, const std::string& key, const std::string& name) {
  const auto found = keys.find(key);
  if (found == keys.end()) throw std::runtime_error(name + ": the key \"" + key + "\" is missing");
  return found->second;
}

void check_lens(const Camera& camera, const std::string& name, const std::string& key) {
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(name + ": " + key + ": " + error.what());
  }
}

/// A matrix as MATLAB prints it: "[f 0 cx; 0 f cy; 0 0 1]".
std::vector<double> matlab_matrix(const TextLine& line, const std::string& name) {
  std::string bare = line.rest(0);
  std::replace_if(
      bare.begin(), bare.end(), [](char c) { return c == '[' || c == ']' || c == ';' || c == ','; },
      ' ');
  const TextLine words(bare, name, line.line_number());
  std::vector<double> numbers;
  for (std::size_t i = 0; i < words.size(); ++i) numbers.push_back(words.number(i));
  return numbers;
}

Camera middlebury_camera(const TextKeys& keys, const std::string& key, const std::string& name) {
  const TextLine& line = line_of(keys, key, name);
  const std::vector<double> k = matlab_matrix(line, name);
  if (k.size() != 9 || k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    line.fail(key + " is not [f 0 cx; 0 f cy; 0 0 1]");
  Camera camera{.fx_px = k[0], .fy_px = k[4], .cx_px = k[2], .cy_px = k[5]};
  camera.width_px = static_cast<int>(line_of(keys, "width", name).integer(0, 1, 65535));
  camera.height_px = static_cast<int>(line_of(keys, "height", name).integer(0, 1, 65535));
  check_lens(camera, name, key);
  return camera;
}

struct RectifiedCamera {
  Camera camera;
  Eigen::Vector3d camera_from_reference = Eigen::Vector3d::Zero();
};

RectifiedCamera kitti_camera(const TextKeys& keys, int number, std::optional<ImageSize> size,
                             const std::string& name) {
  const std::string raw = "P_rect_0" + std::to_string(number);
  const std::string key = keys.contains(raw) ? raw : "P" + std::to_string(number);
  const TextLine& line = line_of(keys, key, name);
  if (line.size() != 12)
    line.fail(key + " has " + std::to_string(line.size()) + " numbers, not 12");
  const auto p = [&](std::size_t row, std::size_t column) { return line.number(4 * row + column); };
  if (p(0, 1) != 0 || p(1, 0) != 0 || p(2, 0) != 0 || p(2, 1) != 0 || p(2, 2) != 1)
    line.fail(key + " is not f 0 cx tx, 0 f cy ty, 0 0 1 tz");
  RectifiedCamera result;
  Camera& camera = result.camera;
  camera = {.fx_px = p(0, 0), .fy_px = p(1, 1), .cx_px = p(0, 2), .cy_px = p(1, 2)};
  if (const auto s = keys.find("S_rect_0" + std::to_string(number)); s != keys.end()) {
    const auto side = [&](std::size_t word) {
      const double px = s->second.number(word);
      if (!(px >= 1 && px <= 65535) || px != std::floor(px))
        s->second.fail(s->first + " is not two whole numbers in [1, 65535]");
      return static_cast<int>(px);
    };
    camera.width_px = side(0);
    camera.height_px = side(1);
  } else if (size) {
    camera.width_px = size->width_px;
    camera.height_px = size->height_px;
  }
  check_lens(camera, name, key);
  Eigen::Vector3d& t = result.camera_from_reference;
  t.z() = p(2, 3);
  t.x() = (p(0, 3) - camera.cx_px * t.z()) / camera.fx_px;
  t.y() = (p(1, 3) - camera.cy_px * t.z()) / camera.fy_px;
  return result;
}

}  // namespace

CameraPair pair_of_middlebury(std::string_view text, const std::string& name) {
  const TextKeys keys = keys_of_lines(text, name, '=');
  CameraPair pair;
  pair.first = middlebury_camera(keys, "cam0", name);
  pair.second = middlebury_camera(keys, "cam1", name);
  if (keys.contains("doffs")) {
    const TextLine& line = line_of(keys, "doffs", name);
    const double between = pair.second.cx_px - pair.first.cx_px;
    if (std::abs(line.number(0) - between) > kMostDoffsError_px)
      line.fail("doffs = " + exact_text(line.number(0)) + " contradicts cx of cam1 - cx of cam0, " +
                exact_text(between) + "; the limit is 1 px");
  }
  const TextLine& baseline = line_of(keys, "baseline", name);
  pair.second_from_first.translation_m.x() = -baseline.number(0);
  pair.unit_m = 1e-3;
  pair.place = name + ": baseline";
  return pair;
}

CameraPair pair_of_kitti(std::string_view text, const std::string& name,
                         const std::array<int, 2>& numbers, const PairSizes& sizes) {
  const TextKeys keys = keys_of_lines(text, name, ':');
  const RectifiedCamera first = kitti_camera(keys, numbers[0], sizes[0], name);
  const RectifiedCamera second = kitti_camera(keys, numbers[1], sizes[1], name);
  CameraPair pair{.first = first.camera, .second = second.camera};
  pair.second_from_first.translation_m = second.camera_from_reference - first.camera_from_reference;
  pair.place = name + ": P" + std::to_string(numbers[1]);
  return pair;
}

}  // namespace cousin
