// Camera calibrations in YAML:
//   OpenCV   image_width, image_height, camera_matrix {data: [9]}, distortion_coefficients {data:
//   [4, 5, 8 or 12]} ROS      the same with distortion_model: plumb_bob, rational_polynomial,
//   equidistant (or fisheye) BoofCV   pinhole {fx, fy, cx, cy, width, height, skew},
//   radial_tangential {radial: [up to 3], t1, t2}
// Only what these files use of YAML is read: nested mappings by indentation, scalars, [a, b] over
// several lines, and
// "- a" lists; tags, comments and document marks are skipped.

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>

#include "sim/dataset/import.h"

namespace cousin {
namespace {

/// Values of a file by their dotted key; a scalar is a list of one.
class YamlValues {
 public:
  YamlValues(std::string_view text, std::string name) : name_(std::move(name)) { parse(text); }

  bool has(const std::string& key) const { return values_.contains(key); }
  const std::vector<std::string>& list(const std::string& key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) fail("the key \"" + key + "\" is missing");
    return found->second;
  }
  std::string text(const std::string& key) const {
    if (list(key).size() != 1) fail(key + " is not one value");
    return list(key).front();
  }
  std::vector<double> numbers(const std::string& key) const {
    std::vector<double> result;
    for (const std::string& item : list(key)) {
      double value = 0;
      const char* begin = item.data() + (item.starts_with('+') ? 1 : 0);
      const auto [end, error] = std::from_chars(begin, item.data() + item.size(), value);
      if (error != std::errc{} || end != item.data() + item.size() || !std::isfinite(value)) {
        fail(key + " = " + item.substr(0, 60) + " is not a finite number");
      }
      result.push_back(value);
    }
    return result;
  }
  double number(const std::string& key) const {
    const std::vector<double> values = numbers(key);
    if (values.size() != 1) fail(key + " is not one number");
    return values.front();
  }
  int pixels(const std::string& key) const {
    const double value = number(key);
    if (!(value >= 1 && value <= 65535) || value != std::floor(value)) {
      fail(key + " = " + text(key) + " is not a whole number in [1, 65535]");
    }
    return static_cast<int>(value);
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(name_ + ": " + what);
  }

 private:
  static std::string trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
  }

  /// Adds the items of "a, b" to `into`.
  static void split(std::string_view text, std::vector<std::string>& into) {
    while (!text.empty()) {
      const std::size_t comma = text.find(',');
      std::string item = trimmed(text.substr(0, comma));
      if (!item.empty()) into.push_back(std::move(item));
      text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
    }
  }

  void parse(std::string_view text) {
    std::vector<std::pair<std::size_t, std::string>> parents;  // indentation and dotted key
    std::string open_list;  // key of a "[" that is not closed yet
    int number = 0;
    while (!text.empty()) {
      const std::size_t newline = text.find('\n');
      std::string_view line = text.substr(0, newline);
      text = newline == std::string_view::npos ? std::string_view() : text.substr(newline + 1);
      ++number;
      if (line.starts_with("%") || line.starts_with("---") || line.starts_with("...")) continue;
      if (const std::size_t comment = line.find('#'); comment != std::string_view::npos)
        line = line.substr(0, comment);
      const std::string content = trimmed(line);
      if (content.empty()) continue;
      if (!open_list.empty()) {
        const std::size_t close = content.find(']');
        split(std::string_view(content).substr(0, close), values_[open_list]);
        if (close != std::string::npos) open_list.clear();
        continue;
      }
      const std::size_t indent = line.find_first_not_of(" \t");
      if (content.starts_with("- ")) {
        if (parents.empty())
          fail("line " + std::to_string(number) + ": a list entry without a key");
        values_[parents.back().second].push_back(trimmed(std::string_view(content).substr(2)));
        continue;
      }
      const std::size_t colon = content.find(':');
      if (colon == std::string::npos)
        fail("line " + std::to_string(number) + ": neither \"key: value\" nor a list entry");
      while (!parents.empty() && parents.back().first >= indent) parents.pop_back();
      if (parents.size() > 32) fail("line " + std::to_string(number) + ": nested deeper than 32");
      const std::string key =
          (parents.empty() ? "" : parents.back().second + ".") + content.substr(0, colon);
      if (values_.contains(key))
        fail("line " + std::to_string(number) + ": " + key + " occurs twice");
      std::string value = trimmed(std::string_view(content).substr(colon + 1));
      if (value.starts_with("!!")) value.clear();
      parents.emplace_back(indent, key);
      if (value.starts_with('[')) {
        const std::size_t close = value.find(']');
        split(std::string_view(value).substr(1, close == std::string::npos ? close : close - 1),
              values_[key]);
        if (close == std::string::npos) open_list = key;
      } else if (!value.empty()) {
        std::erase(value, '"');
        std::erase(value, '\'');
        values_[key].push_back(value);
      }
    }
    if (!open_list.empty()) fail(open_list + ": the \"[\" is not closed");
  }

  std::string name_;
  std::map<std::string, std::vector<std::string>> values_;
};

Camera from_boofcv(const YamlValues& yaml) {
  Camera camera;
  camera.width_px = yaml.pixels("pinhole.width");
  camera.height_px = yaml.pixels("pinhole.height");
  camera.fx_px = yaml.number("pinhole.fx");
  camera.fy_px = yaml.number("pinhole.fy");
  camera.cx_px = yaml.number("pinhole.cx");
  camera.cy_px = yaml.number("pinhole.cy");
  if (yaml.has("pinhole.skew") && yaml.number("pinhole.skew") != 0)
    yaml.fail("pinhole.skew is not zero");
  if (!yaml.has("radial_tangential.radial")) return camera;
  camera.model = LensModel::opencv5;
  const std::vector<double> radial = yaml.numbers("radial_tangential.radial");
  if (radial.size() > 3) yaml.fail("radial_tangential.radial has more than 3 numbers");
  constexpr std::array<std::size_t, 3> kPlaces = {0, 1, 4};
  for (std::size_t i = 0; i < radial.size(); ++i) camera.distortion[kPlaces[i]] = radial[i];
  camera.distortion[2] = yaml.has("radial_tangential.t1") ? yaml.number("radial_tangential.t1") : 0;
  camera.distortion[3] = yaml.has("radial_tangential.t2") ? yaml.number("radial_tangential.t2") : 0;
  return camera;
}

LensModel lens_model(const YamlValues& yaml, std::size_t count) {
  const std::string name = yaml.has("distortion_model") ? yaml.text("distortion_model") : "";
  if (name == "equidistant" || name == "fisheye") {
    if (count != 4)
      yaml.fail("distortion_coefficients: " + name + " has 4, not " + std::to_string(count));
    return LensModel::kannala_brandt4;
  }
  if (name != "" && name != "plumb_bob" && name != "rational_polynomial" && name != "thin_prism" &&
      name != "none") {
    yaml.fail(
        "distortion_model = " + name.substr(0, 60) +
        " is not one of plumb_bob, rational_polynomial, thin_prism, equidistant, fisheye, none");
  }
  if (count == 0) return LensModel::pinhole;
  if (count == 4 || count == 5) return LensModel::opencv5;
  if (count == 8) return LensModel::opencv8;
  if (count == 12) return LensModel::opencv12;
  yaml.fail("distortion_coefficients: " + std::to_string(count) +
            " numbers; 0, 4, 5, 8 or 12 are read");
}

Camera from_opencv(const YamlValues& yaml) {
  const auto data_key = [&](std::initializer_list<const char*> names) {
    for (const std::string name : names) {
      for (const std::string& key : {name + ".data", name}) {
        if (yaml.has(key)) return key;
      }
    }
    yaml.fail(std::string("the key \"") + *names.begin() + "\" is missing");
  };
  Camera camera;
  camera.width_px = yaml.pixels("image_width");
  camera.height_px = yaml.pixels("image_height");
  const std::string matrix_key = data_key({"camera_matrix", "Camera_Matrix", "cameraMatrix", "K"});
  const std::vector<double> k = yaml.numbers(matrix_key);
  if (k.size() != 9 || k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    yaml.fail(matrix_key + " is not fx 0 cx, 0 fy cy, 0 0 1");
  }
  camera.fx_px = k[0];
  camera.cx_px = k[2];
  camera.fy_px = k[4];
  camera.cy_px = k[5];
  const std::vector<double> distortion = yaml.numbers(
      data_key({"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "D"}));
  camera.model = lens_model(yaml, distortion.size());
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  return camera;
}

}  // namespace

Camera camera_from_yaml(std::string_view text, const std::string& name) {
  const YamlValues yaml(text, name);
  const Camera camera = yaml.has("pinhole.fx") ? from_boofcv(yaml) : from_opencv(yaml);
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    yaml.fail(error.what());
  }
  return camera;
}

}  // namespace cousin
