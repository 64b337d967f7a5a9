#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "sim/dataset/yaml_values.h"
#include "sim/imaging/image_size.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// Private to sim/dataset: two cameras and the pose between them, of a stereo pair or of colour and
/// depth.
struct CameraPair {
  Camera first, second;
  Pose second_from_first;  ///< its lengths are the file's until `scale_pair`
  double unit_m = 1;       ///< metres of these, by the format
  std::string place;       ///< "stereo.yaml: T", for messages
};

/// Sizes of the two cameras' images, where a file says none.
using PairSizes = std::array<std::optional<ImageSize>, 2>;

/// Of one file's keys: our rig.json aside, those of
///   OpenCV     M1, D1, M2, D2 and R, T (x_second = R x_first + T); other names in camera_pair.cpp
///   BoofCV     left, right, rightToLeft {rotation [9], x, y, z}
///   sections   color and depth, or left and right, each a camera, and depth_to_color,
///              color_to_depth, left_to_right or right_to_left: a 4 x 4 matrix row by row, or
///              librealsense's {rotation [9, column by column], translation}
/// nothing where the keys are of one camera. @throws std::runtime_error naming file and key; so
/// where two cameras stand without the pose between them.
std::optional<CameraPair> pair_of_values(const YamlValues& values, const PairSizes& sizes);

/// Whether keys say where one of two cameras stands: R and T, or a transform of the sections above.
bool says_pair_pose(const YamlValues& values);

/// A pair from two files, one a camera. The pose between the cameras is R and T in the second file
/// (OpenCV, as `cousin export` writes them), T_BS in both (EuRoC), or rectification_matrix and
/// projection_matrix in both (ROS).
CameraPair pair_of_two(const YamlValues& first, const YamlValues& second, const PairSizes& sizes);

/// OpenCV's intrinsics.yml (M1, D1, M2, D2) beside extrinsics.yml (R, T).
CameraPair pair_of_opencv(const YamlValues& lenses, const YamlValues& pose, const PairSizes& sizes);

/// Middlebury's calib.txt: cam0, cam1, doffs, baseline (mm), width, height. Rectified.
CameraPair pair_of_middlebury(std::string_view text, const std::string& name);

/// KITTI's calib.txt (P0: ... P3:) or calib_cam_to_cam.txt (P_rect_00: ...): the cameras of those
/// numbers, rectified, in metres.
CameraPair pair_of_kitti(std::string_view text, const std::string& name,
                         const std::array<int, 2>& numbers, const PairSizes& sizes);

/// Limits of the distance between two cameras.
struct PairLimits {
  double least_m = 0;
  double most_m = 0;
};
/// Makes metres of a pair's lengths: `length_unit_m` each if given, else as its format says.
/// @throws std::runtime_error naming the place, the distance and the limits where it is outside of
/// them, and the option.
void scale_pair(CameraPair& pair, std::optional<double> length_unit_m, const PairLimits& limits);

}  // namespace cousin
