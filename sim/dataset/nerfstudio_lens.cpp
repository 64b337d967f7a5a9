// Lenses of transforms.json
//   fl_x, fl_y (pixels), or camera_angle_x, camera_angle_y (radians over the whole side), or x_fov,
//   y_fov (degrees); of one axis alone, pixels are square
//   cx, cy (from the image's corner), w, h, k1 k2 k3 k4 p1 p2 or distortion_params (these six in
//   that order), camera_model, is_fisheye
// [docs.nerf.studio, "Data conventions"; instant-ngp, src/nerf_loader.cu, read_focal_length]

#include "sim/dataset/nerfstudio_lens.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

constexpr std::array<std::string_view, 6> kDistortionKeys = {"k1", "k2", "k3", "k4", "p1", "p2"};
constexpr std::array<std::string_view, 13> kOtherLensKeys = {"fl_x",
                                                             "fl_y",
                                                             "cx",
                                                             "cy",
                                                             "w",
                                                             "h",
                                                             "camera_model",
                                                             "camera_angle_x",
                                                             "camera_angle_y",
                                                             "x_fov",
                                                             "y_fov",
                                                             "is_fisheye",
                                                             "distortion_params"};

/// Where they are not zero, pixels look where no lens of ours lets them.
constexpr std::array<std::string_view, 9> kForeignCoefficients = {"k5", "k6", "s1", "s2",  "s3",
                                                                  "s4", "b1", "b2", "skew"};

/// Two numbers for the same thing that differ by more are not the same number rounded.
constexpr double kSameFocalShare = 0.01;

bool differ(double a, double b) { return std::abs(a - b) > kSameFocalShare * std::abs(a); }

/// Focal length of one axis by a frame's or a file's own keys; 0 where it has none.
double focal_px(const JsonNode& node, char axis, int side_px, std::vector<std::string>& warnings) {
  const std::string fl = std::string("fl_") + axis, angle = std::string("camera_angle_") + axis,
                    fov = std::string(1, axis) + "_fov";
  const auto of_angle = [&](double angle_rad) { return 0.5 * side_px / std::tan(0.5 * angle_rad); };
  double result = node.has(fl) ? node[fl].number() : 0;
  if (node.has(fov)) {
    const double px = of_angle(node[fov].number(0.05, 178) * std::numbers::pi / 180);
    if (node.has(fl) && differ(result, px))
      node[fov].fail("gives a focal length of " + exact_text(px) + " pixels, but " + fl + " is " +
                     exact_text(result) + "; keep one of them");
    if (!node.has(fl)) result = px;
  }
  if (node.has(angle)) {
    const double px = of_angle(node[angle].number(1e-3, 3.1));
    if (!node.has(fl) && !node.has(fov)) return px;
    if (differ(result, px)) {
      const std::string warning = node.file() + ": " + angle + " gives a focal length of " +
                                  exact_text(px) + " pixels; it is not used, as " +
                                  (node.has(fl) ? fl : fov) + " gives " + exact_text(result);
      if (std::find(warnings.begin(), warnings.end(), warning) == warnings.end())
        warnings.push_back(warning);
    }
  }
  return result;
}

double focal_px(const FrameKeys& keys, char axis, int side_px, std::vector<std::string>& warnings) {
  const std::string name(1, axis);
  for (const std::string& key : {"fl_" + name, "camera_angle_" + name, name + "_fov"}) {
    if (keys.frame().has(key)) return focal_px(keys.frame(), axis, side_px, warnings);
  }
  return focal_px(keys.file(), axis, side_px, warnings);
}

bool is_fisheye(const FrameKeys& keys) {
  if (!keys.has("camera_model")) return keys.has("is_fisheye") && keys.at("is_fisheye").boolean();
  const JsonNode node = keys.at("camera_model");
  const std::string model = node.text(64);
  const bool by_model = model == "OPENCV_FISHEYE";
  if (!by_model && model != "OPENCV" && model != "PINHOLE" && model != "SIMPLE_PINHOLE" &&
      model != "SIMPLE_RADIAL" && model != "RADIAL") {
    node.fail(
        "is not one of OPENCV, OPENCV_FISHEYE, PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL");
  }
  if (keys.has("is_fisheye") && keys.at("is_fisheye").boolean() != by_model)
    node.fail("contradicts the key \"is_fisheye\"; keep one of them");
  return by_model;
}

/// Sizes are often written as 1080.0.
int pixels(const FrameKeys& keys, std::string_view key) {
  const double value = keys.at(key).number(1, 65535);
  if (value != std::floor(value)) keys.at(key).fail("is not a whole number of pixels");
  return static_cast<int>(value);
}

/// k1 k2 k3 k4 p1 p2.
std::array<double, 6> distortion(const FrameKeys& keys, const std::string& context) {
  std::array<double, 6> values{};
  bool has_single = false;
  for (std::size_t i = 0; i < values.size(); ++i) {
    has_single = has_single || keys.has(kDistortionKeys[i]);
    values[i] = keys.number_or(kDistortionKeys[i], 0);
  }
  if (!keys.has("distortion_params")) return values;
  const JsonNode node = keys.at("distortion_params");
  if (has_single)
    node.fail("stands beside k1, k2, k3, k4, p1 or p2 (" + context + "); keep one of them");
  const std::vector<double> list = node.numbers(values.size(), values.size());
  std::copy(list.begin(), list.end(), values.begin());
  return values;
}

void refuse_foreign_lenses(const FrameKeys& keys, const std::string& context) {
  for (const std::string_view key : kForeignCoefficients) {
    if (keys.has(key) && !is_false_or_zero(keys.at(key)))
      keys.at(key).fail("is not zero, and no lens that is read has it (" + context + ")");
  }
  for (const std::string_view key :
       {"ftheta_p0", "ftheta_p1", "ftheta_p2", "ftheta_p3", "ftheta_p4"}) {
    if (keys.has(key))
      keys.at(key).fail("belongs to an F-theta lens, which is not read (" + context + ")");
  }
  for (const std::string_view key : {"equirectangular", "latlong", "orthographic"}) {
    if (keys.has(key) && !is_false_or_zero(keys.at(key)))
      keys.at(key).fail("names a projection that is not read (" + context + ")");
  }
}

}  // namespace

bool is_false_or_zero(const JsonNode& node) {
  if (node.is_number()) return node.number() == 0;
  if (!node.is_array()) return node.is_false();
  const std::vector<JsonNode> elements = node.elements(64);
  return std::all_of(elements.begin(), elements.end(),
                     [](const JsonNode& element) { return is_false_or_zero(element); });
}

bool is_nerfstudio_lens_key(std::string_view key) {
  const auto in = [&](const auto& keys) {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  };
  return in(kDistortionKeys) || in(kOtherLensKeys) || in(kForeignCoefficients) ||
         key.starts_with("ftheta_p") || key == "equirectangular" || key == "latlong" ||
         key == "orthographic";
}

Camera nerfstudio_lens(const FrameKeys& keys, const std::optional<ImageSize>& image,
                       const std::string& context, std::vector<std::string>& warnings) {
  refuse_foreign_lenses(keys, context);
  Camera camera;
  const bool says_size = keys.has("w") || keys.has("h") || !image;
  camera.width_px = says_size ? pixels(keys, "w") : image->width_px;
  camera.height_px = says_size ? pixels(keys, "h") : image->height_px;
  camera.fx_px = focal_px(keys, 'x', camera.width_px, warnings);
  camera.fy_px = focal_px(keys, 'y', camera.height_px, warnings);
  // Of one axis alone, pixels are square. Without any, the error names fl_x.
  if (camera.fx_px == 0 && camera.fy_px != 0 && !keys.has("fl_x")) camera.fx_px = camera.fy_px;
  if (camera.fx_px == 0 && !keys.has("fl_x")) keys.at("fl_x");
  if (camera.fy_px == 0 && !keys.has("fl_y")) camera.fy_px = camera.fx_px;
  // From the image's corner to the centre of its first pixel.
  camera.cx_px = keys.number_or("cx", 0.5 * camera.width_px) - 0.5;
  camera.cy_px = keys.number_or("cy", 0.5 * camera.height_px) - 0.5;
  const auto [k1, k2, k3, k4, p1, p2] = distortion(keys, context);
  if (is_fisheye(keys)) {
    camera.model = LensModel::kannala_brandt4;
    camera.distortion = {k1, k2, k3, k4};
    if (p1 != 0 || p2 != 0)
      keys.at(keys.has("p1")   ? "p1"
              : keys.has("p2") ? "p2"
                               : "distortion_params")
          .fail("has a tangential part that is not zero, but the lens is a fisheye (" + context +
                ")");
  } else if (k1 != 0 || k2 != 0 || k3 != 0 || p1 != 0 || p2 != 0) {
    camera.model = LensModel::opencv5;
    camera.distortion = {k1, k2, p1, p2, k3};
  }
  if (k4 != 0 && camera.model != LensModel::kannala_brandt4) {
    keys.at(keys.has("k4") ? "k4" : "distortion_params")
        .fail("has a k4 that is not zero, but the lens is not a fisheye (" + context + ")");
  }
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    for (const char* key : {"fl_x", "fl_y", "camera_angle_x", "x_fov", "camera_angle_y", "y_fov"}) {
      if (keys.has(key))
        keys.at(key).fail("with the other intrinsics (" + context + "): " + error.what());
    }
    throw std::logic_error("a lens without a focal length");
  }
  return camera;
}

}  // namespace cousin
