#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/dataset/yaml_values.h"
#include "sim/imaging/image_size.h"
#include "sim/types/camera.h"

namespace cousin {

/// Private to sim/dataset: what a calibration calls a camera's matrix and its distortion; the first
/// that is there counts.
struct CameraKeys {
  std::vector<std::string> matrix = {"camera_matrix", "Camera_Matrix",   "cameraMatrix", "K", "k",
                                     "cam_K",         "intrinsic_matrix"};
  std::vector<std::string> distortion = {"distortion_coefficients",
                                         "Distortion_Coefficients",
                                         "distCoeffs",
                                         "D",
                                         "d",
                                         "coeffs",
                                         "distortion",
                                         "distortion_coeffs",
                                         "dist_coeffs"};
};

/// The camera that keys of OpenCV, ROS, BoofCV, EuRoC, librealsense or Open3D say.
/// @param images  size of its images, where the keys say none. @throws std::runtime_error naming
/// the file and the key.
Camera camera_from_values(const YamlValues& values, std::optional<ImageSize> images = {},
                          const CameraKeys& keys = {});

/// The keys of a file: JSON where its name ends with ".json", else YAML.
YamlValues values_of_file(std::string_view text, const std::string& name);

/// Whether the keys are those of our rig.json.
bool is_rig_json(const YamlValues& values);

}  // namespace cousin
