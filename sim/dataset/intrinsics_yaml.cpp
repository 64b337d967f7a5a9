// Camera calibrations by their keys, in YAML:
//   OpenCV   image_width, image_height, camera_matrix {data: [9]}, distortion_coefficients {data:
//            [4, 5, 8, 12 or 14]}; a fisheye says so by fisheye_model: 1
//   ROS      the same with distortion_model: plumb_bob, rational_polynomial, equidistant (fisheye),
//            or camera_model: fisheye; a message of camera_info has width, height, K and D
//   BoofCV   model: pinhole_radial_tangential, pinhole {fx, fy, cx, cy, width, height, skew},
//            radial_tangential {radial: [up to 3], t1, t2}
//   Kalibr   cam0 {camera_model, intrinsics, distortion_model, distortion_coeffs, resolution}
//   EuRoC    resolution, intrinsics [4], distortion_model, distortion_coefficients
// and in JSON:
//   RealSense  width, height, fx, fy, ppx, ppy, model, coeffs
//   Open3D     width, height, intrinsic_matrix [9, column by column]
// The words for a lens are in lens_words.h.

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>

#include "sim/dataset/camera_files.h"
#include "sim/dataset/camera_values.h"
#include "sim/dataset/import.h"
#include "sim/dataset/lens_words.h"
#include "sim/dataset/picture_list.h"
#include "sim/dataset/yaml_values.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

Camera from_boofcv(const YamlValues& yaml) {
  // Its fisheye and omnidirectional models have the same keys and more.
  for (const std::string key : {"model", "camera_model"}) {
    if (!yaml.has(key)) continue;
    const std::string model = yaml.text(key);
    if (model != "pinhole" && model != "pinhole_radial_tangential" && model != "pinhole_brown")
      yaml.fail(key + " = " + cut_utf8(model, 60) +
                " is not one of pinhole, pinhole_radial_tangential, pinhole_brown");
  }
  for (const std::string key : {"mirror_offset", "symmetric.coefficients", "symmetric"}) {
    if (yaml.has(key)) yaml.fail(key + " belongs to a lens that is not read");
  }
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

struct LensWord {
  LensKind kind = LensKind::unsaid;
  std::string key;
  std::string word;
};

/// The kind of lens by every key that names one. Words that contradict each other are an error.
LensWord lens_word(const YamlValues& yaml) {
  LensWord result;
  const auto say = [&](LensKind kind, const std::string& key, const std::string& word) {
    if (kind == LensKind::unsaid) return;
    if (result.kind != LensKind::unsaid && result.kind != kind)
      yaml.fail(key + " = " + cut_utf8(word, 60) + " contradicts " + result.key + " = " +
                cut_utf8(result.word, 60));
    result = {kind, key, word};
  };
  for (const char* key : {"distortion_model", "distortion_type", "camera_model", "lens_model",
                          "model_type", "camera_type", "model"}) {
    if (!yaml.has(key)) continue;
    const std::string word = yaml.text(key);
    const std::optional<LensKind> kind = lens_kind_of(word);
    if (!kind)
      yaml.fail(std::string(key) + " = " + cut_utf8(word, 60) + " is not one of " + lens_words());
    // That a camera is a pinhole camera says nothing of its distortion.
    if (*kind != LensKind::none || std::string_view(key).starts_with("distortion"))
      say(*kind, key, word);
  }
  for (const char* key : {"fisheye_model", "fisheye", "is_fisheye"}) {
    if (!yaml.has(key)) continue;
    const std::string word = yaml.text(key);
    const bool is_true = word == "1" || word == "true" || word == "True";
    if (!is_true && word != "0" && word != "false" && word != "False")
      yaml.fail(std::string(key) + " = " + cut_utf8(word, 60) + " is neither 0 nor 1");
    if (is_true)
      say(LensKind::fisheye, key, word);
    else if (result.kind == LensKind::fisheye)
      yaml.fail(std::string(key) + " = " + word + " contradicts " + result.key + " = " +
                cut_utf8(result.word, 60));
  }
  return result;
}

/// The lens model, and the coefficients that count in it.
LensModel lens_model(const YamlValues& yaml, const std::string& key, std::vector<double>& values) {
  const LensWord said = lens_word(yaml);
  const std::size_t given = values.size();
  const auto count_error = [&](const std::string& read) {
    yaml.fail(key + ": " + std::to_string(given) + " numbers; " +
              (said.word.empty() ? "" : cut_utf8(said.word, 60) + " has ") + read);
  };
  // OpenCV writes coefficients that its flags fix at zero.
  const auto drop_zeros_beyond = [&](std::size_t count) {
    while (values.size() > count && values.back() == 0) values.pop_back();
  };
  switch (said.kind) {
    case LensKind::fisheye:
      if (values.size() != 4) count_error("4");
      return LensModel::kannala_brandt4;
    case LensKind::none:
    case LensKind::not_read:
      for (const double value : values) {
        if (value != 0)
          yaml.fail(key + " is not zero, but " + said.key + " = " + cut_utf8(said.word, 60) +
                    (said.kind == LensKind::none
                         ? ""
                         : ", whose polynomial is not read; `cousin calibrate` finds a lens"));
      }
      break;
    case LensKind::plumb_bob:
      drop_zeros_beyond(5);
      if (!values.empty() && values.size() != 4 && values.size() != 5) count_error("4 or 5");
      break;
    case LensKind::rational:
      drop_zeros_beyond(8);
      if (values.size() != 4 && values.size() != 5 && values.size() != 8) count_error("8");
      break;
    case LensKind::thin_prism:
    case LensKind::unsaid:
      break;
  }
  if (values.size() == 14 && values[12] == 0 && values[13] == 0) values.resize(12);
  if (values.size() == 14) yaml.fail(key + " has a tilted imager, which is not read");
  if (values.empty()) return LensModel::pinhole;
  if (values.size() == 4 || values.size() == 5) return LensModel::opencv5;
  if (values.size() == 8) return LensModel::opencv8;
  if (values.size() == 12) return LensModel::opencv12;
  count_error("0, 4, 5, 8, 12 or 14 are read");
  throw std::logic_error("unreachable");
}

/// Matrices of a message of camera_info count on the whole imager, at full resolution.
void refuse_part_of_imager(const YamlValues& yaml) {
  for (const std::string key : {"binning_x", "binning_y"}) {
    if (yaml.has(key) && yaml.number(key) > 1)
      yaml.fail(key + " = " + yaml.text(key) + ": images of joined pixels are not read");
  }
  for (const std::string key : {"roi.x_offset", "roi.y_offset"}) {
    if (yaml.has(key) && yaml.number(key) != 0)
      yaml.fail(key + " = " + yaml.text(key) + ": images of a part of the imager are not read");
  }
}

/// An angle of view beside a focal length says the same again, or something else.
void refuse_angles_of_view(const YamlValues& values) {
  constexpr std::array<const char*, 4> kWords = {"fov", "angle_of_view", "view_angle",
                                                 "camera_angle"};
  for (const std::string& key : values.first_keys()) {
    const std::string lower = lower_case(key);
    if (std::any_of(kWords.begin(), kWords.end(),
                    [&](const char* word) { return lower.find(word) != std::string::npos; }))
      values.fail("the key \"" + cut_utf8(key, 60) +
                  "\" may be an angle of view, which fx and fy say, and is not read; remove it");
  }
}

/// The first of the keys that is there, as `key` or as OpenCV's matrix `key.data`; "" if none is.
std::string first_there(const YamlValues& values, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) {
    for (const std::string& name : {key + ".data", key}) {
      if (values.has(name)) return name;
    }
  }
  return "";
}

void read_size(const YamlValues& values, std::optional<ImageSize> images, Camera& camera) {
  const bool is_message = !values.has("image_width") && values.has("width") && values.has("height");
  for (const std::string key : {"resolution", "image_size", "imageSize"}) {
    if (!values.has(key)) continue;
    const std::vector<double> size = values.numbers(key);
    const auto is_side = [](double side) {
      return side >= 1 && side <= 65535 && side == static_cast<int>(side);
    };
    if (size.size() != 2 || !is_side(size[0]) || !is_side(size[1]))
      values.fail(key + " is not two whole numbers in [1, 65535]");
    camera.width_px = static_cast<int>(size[0]);
    camera.height_px = static_cast<int>(size[1]);
    return;
  }
  if (images && !is_message && !values.has("image_width")) {
    camera.width_px = images->width_px;
    camera.height_px = images->height_px;
    return;
  }
  camera.width_px = values.pixels(is_message ? "width" : "image_width");
  camera.height_px = values.pixels(is_message ? "height" : "image_height");
}

void read_matrix(const YamlValues& values, const std::string& key, Camera& camera) {
  std::vector<double> k = values.numbers(key);
  // Open3D's stands column by column.
  if (key == "intrinsic_matrix" && k.size() == 9 && k[2] == 0 && k[5] == 0) {
    std::swap(k[2], k[6]);
    std::swap(k[5], k[7]);
  }
  if (k.size() != 9 || k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    values.fail(key + " is not fx 0 cx, 0 fy cy, 0 0 1");
  camera.fx_px = k[0];
  camera.cx_px = k[2];
  camera.fy_px = k[4];
  camera.cy_px = k[5];
}

/// Focal lengths and principal point by a matrix, by four keys or by a list of four.
/// @return whether it is a matrix of OpenCV's or ROS's, beside which the distortion must stand.
bool read_projection(const YamlValues& values, const CameraKeys& keys, Camera& camera) {
  const std::string matrix = first_there(values, keys.matrix);
  if (!matrix.empty()) {
    read_matrix(values, matrix, camera);
    return matrix != "intrinsic_matrix" && matrix != "cam_K";
  }
  if (values.has("fx")) {
    camera.fx_px = values.number("fx");
    camera.fy_px = values.number("fy");
    camera.cx_px = values.number(values.has("ppx") ? "ppx" : "cx");
    camera.cy_px = values.number(values.has("ppy") ? "ppy" : "cy");
    if (values.has("skew") && values.number("skew") != 0) values.fail("skew is not zero");
    return false;
  }
  if (values.has("intrinsics")) {
    const std::vector<double> four = values.numbers("intrinsics");
    if (four.size() != 4) values.fail("intrinsics is not fx, fy, cx, cy");
    camera.fx_px = four[0];
    camera.fy_px = four[1];
    camera.cx_px = four[2];
    camera.cy_px = four[3];
    return true;
  }
  values.fail("the key \"" + keys.matrix.front() + "\" is missing");
}

/// Of keys "k1", "k2", ...: OpenCV's order; nothing where there is none.
std::vector<double> single_coefficients(const YamlValues& values) {
  constexpr std::array<const char*, 12> kKeys = {"k1", "k2", "p1", "p2", "k3", "k4",
                                                 "k5", "k6", "s1", "s2", "s3", "s4"};
  if (std::none_of(kKeys.begin(), kKeys.end(), [&](const char* key) { return values.has(key); }))
    return {};
  std::vector<double> result;
  for (const char* key : kKeys) result.push_back(values.has(key) ? values.number(key) : 0);
  while (result.size() > 5 && result.back() == 0) result.pop_back();
  if (result.size() > 5) result.resize(result.size() > 8 ? 12 : 8);
  return result;
}

void read_distortion(const YamlValues& values, const CameraKeys& keys, bool is_needed,
                     Camera& camera) {
  std::string key = first_there(values, keys.distortion);
  std::vector<double> coefficients;
  if (!key.empty()) {
    coefficients = values.numbers(key);
  } else {
    coefficients = single_coefficients(values);
    key = "k1";
    if (is_needed && coefficients.empty())
      values.fail("the key \"" + keys.distortion.front() + "\" is missing");
    for (const std::string& other : values.first_keys()) {
      if ((other.starts_with("dist") || other == "coefficients") && !other.ends_with("_model") &&
          other != "distortion_type")
        values.fail(other + " is not a list of coefficients");
    }
  }
  camera.model = lens_model(values, key, coefficients);
  std::copy(coefficients.begin(), coefficients.end(), camera.distortion.begin());
}

}  // namespace

Camera camera_from_yaml(std::string_view text, const std::string& name) {
  const YamlValues yaml(text, name);
  if (yaml.has("cam0.intrinsics")) {
    if (yaml.has("cam1.intrinsics"))
      yaml.fail("has cam0 and cam1; keep the camera that took the images, as cam0");
    return cameras_from_kalibr(text, name).front().camera;
  }
  return camera_from_values(yaml);
}

Camera camera_from_values(const YamlValues& values, std::optional<ImageSize> images,
                          const CameraKeys& keys) {
  Camera camera;
  if (values.has("pinhole.fx")) {
    camera = from_boofcv(values);
  } else {
    read_size(values, images, camera);
    refuse_part_of_imager(values);
    refuse_angles_of_view(values);
    const bool has_opencv_matrix = read_projection(values, keys, camera);
    read_distortion(values, keys, has_opencv_matrix, camera);
  }
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    values.fail(error.what());
  }
  return camera;
}

}  // namespace cousin
