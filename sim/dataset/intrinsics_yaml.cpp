// Camera calibrations in YAML:
//   OpenCV   image_width, image_height, camera_matrix {data: [9]}, distortion_coefficients {data:
//            [4, 5, 8, 12 or 14]}; a fisheye says so by fisheye_model: 1
//   ROS      the same with distortion_model: plumb_bob, rational_polynomial, equidistant (fisheye),
//            or camera_model: fisheye; a message of camera_info has width, height, K and D
//   BoofCV   model: pinhole_radial_tangential, pinhole {fx, fy, cx, cy, width, height, skew},
//            radial_tangential {radial: [up to 3], t1, t2}
//   Kalibr   cam0 {camera_model, intrinsics, distortion_model, distortion_coeffs, resolution}
// The words for a lens are in lens_words.h.

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>

#include "sim/dataset/camera_files.h"
#include "sim/dataset/import.h"
#include "sim/dataset/lens_words.h"
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
      for (const double value : values) {
        if (value != 0)
          yaml.fail(key + " is not zero, but " + said.key + " = " + cut_utf8(said.word, 60));
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
  const bool is_message = !yaml.has("image_width") && yaml.has("width") && yaml.has("height");
  camera.width_px = yaml.pixels(is_message ? "width" : "image_width");
  camera.height_px = yaml.pixels(is_message ? "height" : "image_height");
  refuse_part_of_imager(yaml);
  const std::string matrix_key =
      data_key({"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k"});
  const std::vector<double> k = yaml.numbers(matrix_key);
  if (k.size() != 9 || k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    yaml.fail(matrix_key + " is not fx 0 cx, 0 fy cy, 0 0 1");
  }
  camera.fx_px = k[0];
  camera.cx_px = k[2];
  camera.fy_px = k[4];
  camera.cy_px = k[5];
  const std::string distortion_key =
      data_key({"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "D", "d"});
  std::vector<double> distortion = yaml.numbers(distortion_key);
  camera.model = lens_model(yaml, distortion_key, distortion);
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  return camera;
}

}  // namespace

Camera camera_from_yaml(std::string_view text, const std::string& name) {
  const YamlValues yaml(text, name);
  if (yaml.has("cam0.intrinsics")) {
    if (yaml.has("cam1.intrinsics"))
      yaml.fail("has cam0 and cam1; keep the camera that took the images, as cam0");
    return cameras_from_kalibr(text, name).front().camera;
  }
  const Camera camera = yaml.has("pinhole.fx") ? from_boofcv(yaml) : from_opencv(yaml);
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    yaml.fail(error.what());
  }
  return camera;
}

}  // namespace cousin
