#include "sim/dataset/camera_pair.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/dataset/camera_values.h"
#include "sim/dataset/matrix_pose.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

/// What OpenCV's users call the matrices of the first camera and of the second.
constexpr std::array<std::array<const char*, 2>, 8> kMatrixNames = {
    {{"M1", "M2"},
     {"K1", "K2"},
     {"cameraMatrix1", "cameraMatrix2"},
     {"camera_matrix_1", "camera_matrix_2"},
     {"camera_matrix1", "camera_matrix2"},
     {"camera_matrix_left", "camera_matrix_right"},
     {"left_camera_matrix", "right_camera_matrix"},
     {"K_left", "K_right"}}};
constexpr std::array<std::array<const char*, 2>, 8> kDistortionNames = {
    {{"D1", "D2"},
     {"distCoeffs1", "distCoeffs2"},
     {"dist_coeffs_1", "dist_coeffs_2"},
     {"dist_coeffs1", "dist_coeffs2"},
     {"distortion_coefficients_left", "distortion_coefficients_right"},
     {"left_distortion_coefficients", "right_distortion_coefficients"},
     {"dist_left", "dist_right"},
     {"D_left", "D_right"}}};

/// Two sections of cameras, and the transforms that may stand beside them.
struct SectionNames {
  const char* first;
  const char* second;
  const char* second_from_first;
  const char* first_from_second;
};
constexpr std::array<SectionNames, 4> kSections = {
    {{"color", "depth", "color_to_depth", "depth_to_color"},
     {"rgb", "depth", "rgb_to_depth", "depth_to_rgb"},
     {"left", "right", "left_to_right", "right_to_left"},
     {"left", "right", "leftToRight", "rightToLeft"}}};

std::string matrix_key(const YamlValues& values, const std::string& name) {
  return values.has(name + ".data") ? name + ".data" : name;
}

bool has_matrix(const YamlValues& values, const std::string& name) {
  return values.has(matrix_key(values, name));
}

std::vector<double> matrix_of(const YamlValues& values, const std::string& name,
                              std::size_t count) {
  const std::string key = matrix_key(values, name);
  std::vector<double> numbers = values.numbers(key);
  if (numbers.size() != count)
    values.fail(key + " has " + std::to_string(numbers.size()) + " numbers, not " +
                std::to_string(count));
  return numbers;
}

Eigen::Matrix3d rows_of_3(const std::vector<double>& numbers) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
}

/// A pose whose errors name the key.
template <class Make>
Pose pose_at(const YamlValues& values, const std::string& key, const Make& make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    values.fail(key + ": " + error.what());
  }
}

Pose pose_of_parts(const YamlValues& values, const std::string& key,
                   const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation;
  matrix.topRightCorner<3, 1>() = translation;
  return pose_at(values, key, [&] { return pose_of_matrix(matrix); });
}

Pose pose_of_rows(const YamlValues& values, const std::string& key) {
  const std::vector<double> numbers = matrix_of(values, key, 16);
  const Eigen::Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  return pose_at(values, key, [&] { return pose_of_matrix(matrix); });
}

/// OpenCV's R and T.
Pose pose_of_opencv(const YamlValues& values) {
  const std::vector<double> t = matrix_of(values, "T", 3);
  return pose_of_parts(values, "R", rows_of_3(matrix_of(values, "R", 9)),
                       Eigen::Vector3d(t[0], t[1], t[2]));
}

/// A transform of kSections.
Pose pose_of_section(const YamlValues& values, const std::string& key) {
  if (has_matrix(values, key)) return pose_of_rows(values, key);
  const YamlValues parts = values.below(key);
  if (parts.has("R")) return pose_of_opencv(parts);
  const std::vector<double> rotation = matrix_of(parts, "rotation", 9);
  if (parts.has("x"))  // BoofCV's
    return pose_of_parts(parts, "rotation", rows_of_3(rotation),
                         {parts.number("x"), parts.number("y"), parts.number("z")});
  if (parts.is_nested("rotation"))
    parts.fail("rotation has rows, but librealsense's is 9 numbers column by column; write " + key +
               " as a 4 x 4 matrix row by row");
  const std::vector<double> t = matrix_of(parts, "translation", 3);
  return pose_of_parts(parts, "rotation", rows_of_3(rotation).transpose(),
                       Eigen::Vector3d(t[0], t[1], t[2]));
}

bool has_section_pose(const YamlValues& values, const std::string& key) {
  return has_matrix(values, key) || !values.below(key).empty();
}

std::optional<CameraPair> pair_of_sections(const YamlValues& values, const PairSizes& sizes) {
  const SectionNames* cameras = nullptr;
  for (const SectionNames& names : kSections) {
    const YamlValues first = values.below(names.first), second = values.below(names.second);
    if (first.empty() || second.empty()) continue;
    if (cameras == nullptr) cameras = &names;
    const bool is_forward = has_section_pose(values, names.second_from_first);
    const bool is_backward = has_section_pose(values, names.first_from_second);
    if (!is_forward && !is_backward) continue;
    if (is_forward && is_backward)
      values.fail(std::string(names.second_from_first) + " and " + names.first_from_second +
                  " stand beside each other; keep one of them");
    CameraPair pair;
    pair.first = camera_from_values(first, sizes[0]);
    pair.second = camera_from_values(second, sizes[1]);
    const std::string key = is_forward ? names.second_from_first : names.first_from_second;
    const Pose pose = pose_of_section(values, key);
    pair.second_from_first = is_forward ? pose : inverse(pose);
    pair.place = values.name() + ": " + key;
    return pair;
  }
  if (cameras != nullptr)
    values.fail("has " + std::string(cameras->first) + " and " + cameras->second +
                ", but not where they stand: the key \"" + cameras->first_from_second +
                "\" is missing, a 4 x 4 matrix in metres");
  return std::nullopt;
}

/// The keys of one camera of OpenCV's stereo files.
CameraKeys opencv_keys(std::size_t camera) {
  CameraKeys keys{{}, {}};
  for (const auto& names : kMatrixNames) keys.matrix.emplace_back(names[camera]);
  for (const auto& names : kDistortionNames) keys.distortion.emplace_back(names[camera]);
  return keys;
}

bool has_opencv_pair(const YamlValues& values) {
  return std::any_of(kMatrixNames.begin(), kMatrixNames.end(), [&](const auto& names) {
    return has_matrix(values, names[0]) && has_matrix(values, names[1]);
  });
}

/// ROS: cameras turned to be level, the second's moved along x by P[3] / P[0] metres.
Pose pose_of_ros(const YamlValues& first, const YamlValues& second) {
  const auto rectification = [](const YamlValues& values) {
    const std::string key = values.has("rectification_matrix.data") ? "rectification_matrix" : "R";
    return pose_of_parts(values, key, rows_of_3(matrix_of(values, key, 9)),
                         Eigen::Vector3d::Zero());
  };
  const std::string key = has_matrix(second, "projection_matrix") ? "projection_matrix" : "P";
  const std::vector<double> p = matrix_of(second, key, 12);
  if (!(p[0] > 0)) second.fail(key + " has no focal length");
  if (p[3] == 0)
    second.fail(key + " has no distance to the other camera (its fourth number is 0): give R and " +
                "T, x_second = R x_first + T");
  if (p[7] != 0 || p[11] != 0) second.fail(key + " is of cameras that are not side by side");
  const Pose level{Eigen::Quaterniond::Identity(), Eigen::Vector3d(p[3] / p[0], 0, 0)};
  return inverse(rectification(second)) * level * rectification(first);
}

}  // namespace

std::optional<CameraPair> pair_of_values(const YamlValues& values, const PairSizes& sizes) {
  if (has_opencv_pair(values)) return pair_of_opencv(values, values, sizes);
  return pair_of_sections(values, sizes);
}

bool says_pair_pose(const YamlValues& values) {
  return (has_matrix(values, "R") && has_matrix(values, "T")) ||
         std::any_of(kSections.begin(), kSections.end(), [&](const SectionNames& names) {
           return has_section_pose(values, names.second_from_first) ||
                  has_section_pose(values, names.first_from_second);
         });
}

CameraPair pair_of_opencv(const YamlValues& lenses, const YamlValues& pose,
                          const PairSizes& sizes) {
  if (!has_matrix(pose, "R") || !has_matrix(pose, "T"))
    pose.fail("has no R and T: x_second = R x_first + T");
  CameraPair pair;
  pair.first = camera_from_values(lenses, sizes[0], opencv_keys(0));
  pair.second = camera_from_values(lenses, sizes[1], opencv_keys(1));
  pair.second_from_first = pose_of_opencv(pose);
  pair.place = pose.name() + ": T";
  return pair;
}

CameraPair pair_of_two(const YamlValues& first, const YamlValues& second, const PairSizes& sizes) {
  CameraPair pair;
  pair.first = camera_from_values(first, sizes[0]);
  pair.second = camera_from_values(second, sizes[1]);
  if (has_matrix(second, "R") && has_matrix(second, "T")) {
    if (has_matrix(first, "T") && pose_of_opencv(first).translation_m.norm() != 0)
      first.fail("T is not zero: R and T of the second camera are from the first");
    pair.second_from_first = pose_of_opencv(second);
    pair.place = second.name() + ": T";
  } else if (has_matrix(first, "T_BS") && has_matrix(second, "T_BS")) {
    pair.second_from_first = inverse(pose_of_rows(second, "T_BS")) * pose_of_rows(first, "T_BS");
    pair.place = second.name() + ": T_BS";
  } else if (has_matrix(second, "projection_matrix") || has_matrix(second, "P")) {
    pair.second_from_first = pose_of_ros(first, second);
    pair.place = second.name() + ": projection_matrix";
  } else {
    second.fail("does not say where the camera stands: give R and T, x_second = R x_first + T");
  }
  return pair;
}

void scale_pair(CameraPair& pair, std::optional<double> length_unit_m, const PairLimits& limits) {
  const double given = pair.second_from_first.translation_m.norm();
  pair.second_from_first.translation_m *= length_unit_m.value_or(pair.unit_m);
  const double metres = pair.second_from_first.translation_m.norm();
  if (metres >= limits.least_m && metres <= limits.most_m) return;
  throw std::runtime_error(
      pair.place + ": the cameras are " + short_text(metres) + " m apart, outside [" +
      exact_text(limits.least_m) + ", " + exact_text(limits.most_m) +
      "] m. Give --length-unit, metres a unit of the file: 0.001 (mm: " +
      short_text(0.001 * given) + " m), 0.01 (cm: " + short_text(0.01 * given) +
      " m), or the side of a square of the board, if that was the unit");
}

}  // namespace cousin
