// Camera calibrations in YAML:
//   OpenCV   image_width, image_height, camera_matrix {data: [9]}, distortion_coefficients {data:
//            [4, 5, 8 or 12]}
//   ROS      the same with distortion_model: plumb_bob, rational_polynomial, equidistant (fisheye)
//   BoofCV   pinhole {fx, fy, cx, cy, width, height, skew},
//            radial_tangential {radial: [up to 3], t1, t2}
//   Kalibr   cam0 {camera_model, intrinsics, distortion_model, distortion_coeffs, resolution}

#include <algorithm>
#include <array>
#include <stdexcept>

#include "sim/dataset/camera_files.h"
#include "sim/dataset/import.h"
#include "sim/dataset/yaml_values.h"

namespace cousin {
namespace {

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
