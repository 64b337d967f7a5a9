#include "sim/dataset/camera_files.h"

#include <numbers>
#include <stdexcept>

#include "sim/dataset/text_fields.h"
#include "sim/dataset/yaml_text.h"
#include "sim/dataset/yaml_values.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

[[noreturn]] void refuse(const CalibratedCamera& c, const std::string& format,
                         const std::string& why = "") {
  throw std::invalid_argument("sensor \"" + c.name + "\" has the lens model " +
                              std::string(to_string(c.camera.model)) + ", which " + format +
                              " does not have" + why);
}

std::vector<double> coefficients(const Camera& camera) {
  return {camera.distortion.begin(), camera.distortion.begin() + distortion_count(camera.model)};
}

std::vector<double> row_major(const Eigen::MatrixXd& matrix) {
  std::vector<double> values;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      values.push_back(matrix(row, column));
  }
  return values;
}

Eigen::Matrix3d intrinsic_matrix(const Camera& c) {
  return Eigen::Matrix3d{{c.fx_px, 0, c.cx_px}, {0, c.fy_px, c.cy_px}, {0, 0, 1}};
}

std::string opencv_matrix(const std::string& key, int rows, int columns,
                          const std::vector<double>& values) {
  return key + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " +
         yaml_numbers(values) + " ]\n";
}

std::string ros_matrix(const std::string& key, int rows, int columns,
                       const std::vector<double>& values) {
  return key + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(columns) +
         "\n  data: [" + yaml_numbers(values) + "]\n";
}

/// "/rgb/image_raw"; quoted where the camera's name needs it.
std::string topic_of(const std::string& name) {
  const std::string topic = "/" + name + "/image_raw";
  return yaml_name("a" + name) == "a" + name ? topic : yaml_quoted(topic);
}

std::string kalibr_camera(const CalibratedCamera& c) {
  const Camera& lens = c.camera;
  std::string model = "none";
  std::vector<double> values;
  if (lens.model == LensModel::opencv5) {
    if (lens.distortion[4] != 0) refuse(c, "Kalibr", " (its radtan has no k3)");
    model = "radtan";
    values.assign(lens.distortion.begin(), lens.distortion.begin() + 4);
  } else if (lens.model == LensModel::kannala_brandt4) {
    model = "equidistant";
    values = coefficients(lens);
  } else if (lens.model != LensModel::pinhole) {
    refuse(c, "Kalibr");
  }
  return "  camera_model: pinhole\n  distortion_coeffs: [" + yaml_numbers(values) +
         "]\n  distortion_model: " + model + "\n  intrinsics: [" +
         yaml_numbers({lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px}) + "]\n  resolution: [" +
         std::to_string(lens.width_px) + ", " + std::to_string(lens.height_px) +
         "]\n  rostopic: " + topic_of(c.name) + "\n";
}

Pose pose_in(const YamlValues& yaml, const std::string& key) {
  const std::vector<double> values = yaml.numbers(key);
  if (values.size() != 16) yaml.fail(key + " does not have 4 rows of 4 numbers");
  const Eigen::Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  if ((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-9)
    yaml.fail(key + " does not end in the row 0 0 0 1");
  try {
    return pose_from_matrix(matrix);
  } catch (const std::invalid_argument& error) {
    yaml.fail(key + ": " + error.what());
  }
}

Camera kalibr_lens(const YamlValues& yaml, const std::string& key) {
  if (yaml.text(key + "camera_model") != "pinhole")
    yaml.fail(key + "camera_model = " + cut_utf8(yaml.text(key + "camera_model"), 60) +
              " is not pinhole, the only one that is read");
  const std::vector<double> k = yaml.numbers(key + "intrinsics");
  const std::vector<double> size = yaml.numbers(key + "resolution");
  const std::vector<double> values = yaml.numbers(key + "distortion_coeffs");
  if (k.size() != 4) yaml.fail(key + "intrinsics does not have 4 numbers");
  for (const double side : size) {
    if (!(side >= 1 && side <= 65535) || side != static_cast<int>(side) || size.size() != 2)
      yaml.fail(key + "resolution is not two whole numbers in [1, 65535]");
  }
  if (size.size() != 2) yaml.fail(key + "resolution is not two whole numbers in [1, 65535]");
  Camera camera{.width_px = static_cast<int>(size[0]), .height_px = static_cast<int>(size[1])};
  camera.fx_px = k[0];
  camera.fy_px = k[1];
  camera.cx_px = k[2];
  camera.cy_px = k[3];
  const std::string model = yaml.text(key + "distortion_model");
  if (model != "radtan" && model != "equidistant" && model != "none")
    yaml.fail(key + "distortion_model = " + cut_utf8(model, 60) +
              " is not one of radtan, equidistant, none");
  if (values.size() != (model == "none" ? 0U : 4U))
    yaml.fail(key + "distortion_coeffs has " + std::to_string(values.size()) + " numbers; " +
              model + " has " + (model == "none" ? "none" : "4"));
  if (model == "radtan") camera.model = LensModel::opencv5;
  if (model == "equidistant") camera.model = LensModel::kannala_brandt4;
  std::copy(values.begin(), values.end(), camera.distortion.begin());
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    yaml.fail(key + "intrinsics: " + error.what());
  }
  return camera;
}

}  // namespace

std::string opencv_yaml(const CalibratedCamera& c, const CalibratedCamera& first) {
  const Camera& lens = c.camera;
  if (lens.model == LensModel::splined_stereographic) refuse(c, "OpenCV");
  const Pose camera_from_first = c.camera_from_reference * inverse(first.camera_from_reference);
  std::string text = "%YAML 1.0\n---\ncamera_name: " + yaml_quoted(c.name) +
                     "\nimage_width: " + std::to_string(lens.width_px) +
                     "\nimage_height: " + std::to_string(lens.height_px) + "\n";
  text += opencv_matrix("camera_matrix", 3, 3, row_major(intrinsic_matrix(lens)));
  std::vector<double> values = coefficients(lens);
  // No distortion is five zeros: an empty matrix is no calibration to OpenCV's readers.
  if (values.empty()) values.resize(5);
  if (lens.model == LensModel::kannala_brandt4) text += "distortion_model: fisheye\n";
  text += opencv_matrix("distortion_coefficients", 1, static_cast<int>(values.size()), values);
  text += "# X_camera = R X_" + terminal_text(first.name) + " + T, metres\n";
  text += opencv_matrix("R", 3, 3, row_major(camera_from_first.rotation.toRotationMatrix()));
  text += opencv_matrix("T", 3, 1, row_major(camera_from_first.translation_m));
  return text;
}

std::string ros_camera_info(const CalibratedCamera& c) {
  const Camera& lens = c.camera;
  std::string model = "plumb_bob";
  std::vector<double> values = coefficients(lens);
  if (lens.model == LensModel::pinhole) {
    values.resize(5);
  } else if (lens.model == LensModel::opencv8) {
    model = "rational_polynomial";
  } else if (lens.model == LensModel::kannala_brandt4) {
    model = "equidistant";
  } else if (lens.model != LensModel::opencv5) {
    refuse(c, "ROS");
  }
  Eigen::Matrix<double, 3, 4> projection = Eigen::Matrix<double, 3, 4>::Zero();
  projection.leftCols<3>() = intrinsic_matrix(lens);
  return "image_width: " + std::to_string(lens.width_px) +
         "\nimage_height: " + std::to_string(lens.height_px) +
         "\ncamera_name: " + yaml_name(c.name) + "\n" +
         ros_matrix("camera_matrix", 3, 3, row_major(intrinsic_matrix(lens))) +
         "distortion_model: " + model + "\n" +
         ros_matrix("distortion_coefficients", 1, static_cast<int>(values.size()), values) +
         ros_matrix("rectification_matrix", 3, 3, row_major(Eigen::Matrix3d::Identity())) +
         ros_matrix("projection_matrix", 3, 4, row_major(projection));
}

std::string kalibr_camchain(const std::vector<CalibratedCamera>& cameras) {
  std::string text;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    text += "cam" + std::to_string(i) + ":\n" + kalibr_camera(cameras[i]);
    if (i == 0) continue;
    const Pose next_from_last =
        cameras[i].camera_from_reference * inverse(cameras[i - 1].camera_from_reference);
    const std::vector<double> m = row_major(to_matrix(next_from_last));
    text += "  T_cn_cnm1:\n";
    for (std::size_t row = 0; row < 4; ++row) {
      const auto begin = m.begin() + static_cast<std::ptrdiff_t>(4 * row);
      text += "  - [" + yaml_numbers(std::vector<double>(begin, begin + 4)) + "]\n";
    }
  }
  return text;
}

std::vector<CalibratedCamera> cameras_from_kalibr(std::string_view text, const std::string& name) {
  const YamlValues yaml(text, name);
  std::vector<CalibratedCamera> cameras;
  for (int i = 0; yaml.has("cam" + std::to_string(i) + ".intrinsics"); ++i) {
    const std::string key = "cam" + std::to_string(i) + ".";
    CalibratedCamera& camera = cameras.emplace_back();
    camera.name = "cam" + std::to_string(i);
    camera.camera = kalibr_lens(yaml, key);
    if (i > 0) {
      camera.camera_from_reference = pose_in(yaml, key + "T_cn_cnm1") *
                                     cameras[static_cast<std::size_t>(i) - 1].camera_from_reference;
    }
  }
  if (cameras.empty()) yaml.fail("the key \"cam0.intrinsics\" is missing");
  return cameras;
}

std::string mrcal_cameramodel(const CalibratedCamera& c) {
  const Camera& lens = c.camera;
  std::string model;
  std::vector<double> intrinsics = {lens.fx_px, lens.fy_px, lens.cx_px, lens.cy_px};
  std::vector<double> values = coefficients(lens);
  if (lens.model == LensModel::pinhole) {
    model = "LENSMODEL_PINHOLE";
  } else if (lens.model == LensModel::splined_stereographic) {
    const double degrees = lens.spline.fov_x_rad * 180 / std::numbers::pi;
    const int whole = static_cast<int>(degrees + 0.5);
    if (whole * std::numbers::pi / 180 != lens.spline.fov_x_rad)
      refuse(c, "mrcal",
             " with a field of view of " + exact_text(degrees) +
                 " degrees (its models are named by whole ones)");
    model = "LENSMODEL_SPLINED_STEREOGRAPHIC_order=" + std::to_string(lens.spline.order) +
            "_Nx=" + std::to_string(lens.spline.columns) +
            "_Ny=" + std::to_string(lens.spline.rows) + "_fov_x_deg=" + std::to_string(whole);
    values = lens.spline.delta_u;
  } else if (lens.model == LensModel::kannala_brandt4) {
    refuse(c, "mrcal");
  } else {
    model = "LENSMODEL_OPENCV" + std::to_string(distortion_count(lens.model));
  }
  intrinsics.insert(intrinsics.end(), values.begin(), values.end());
  const Eigen::AngleAxisd turn(c.camera_from_reference.rotation);
  const Eigen::Vector3d r = turn.angle() * turn.axis(), t = c.camera_from_reference.translation_m;
  return "{\n    'lensmodel':  '" + model +
         "',\n\n    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n    'intrinsics': "
         "[ " +
         exact_text(intrinsics, ", ") +
         " ],\n\n    # extrinsics are rt_fromref: metres\n    'extrinsics': [ " +
         exact_text({r.x(), r.y(), r.z(), t.x(), t.y(), t.z()}, ", ") +
         " ],\n\n    'imagersize': [ " + std::to_string(lens.width_px) + ", " +
         std::to_string(lens.height_px) + " ]\n}\n";
}

}  // namespace cousin
