// A plant of OpenAlea's phenomenal:
//   calibration/calibration_camera_side.json and ..._top.json
//     {"cam_width_image", "cam_height_image", "cam_focal_length_x", "cam_focal_length_y",
//      "cam_pos_x", "cam_pos_y", "cam_pos_z" (mm), "cam_rot_x", "cam_rot_y", "cam_rot_z" (rad),
//      "cam_origin_axis": [16, row-major], "angle_factor", "target_..." (not used)}
//   bin/side/ANGLE.png (degrees of the turntable), bin/top/0.png: not zero on the plant
//   voxels/SIZE.npz: carvings, see phenomenal_voxels.cpp
//
// The projection [github.com/openalea/phenomenal, class OldCalibrationCamera: get_projection and
// camera_frame] of a world point p in mm, with a = angle * angle_factor:
//   q = M(a) p,                 M(a) = [-cos a, -sin a, 0; -sin a, cos a, 0; 0, 0, 1], a reflection
//   c = R^T (q - position),     R = cam_origin_axis Rx Ry Rz; its columns are the camera's axes
//   u = fx c_x / c_z + width / 2,  v = fy c_y / c_z + height / 2
// Both cameras look along their -z: c_z < 0 in front of them. The point -c projects to the same
// pixel from a positive depth, so camera_from_world = (-R^T M(a), R^T position). Two reflections
// make a rotation: p's world is right-handed and needs no change. u and v come from OpenCV's corner
// detector, which counts from pixel centres, so there is no half pixel to shift.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/json_interop.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

struct CabinCamera {
  Camera camera;
  Eigen::Matrix3d axes;        ///< R
  Eigen::Vector3d position_m;  ///< in the cabin
  double angle_factor = 1;     ///< true over nominal turntable angle
};

CabinCamera read_cabin_camera(const fs::path& plant_dir, const fs::path& relative) {
  resolve_inside(plant_dir, relative);
  const JsonDocument document = JsonDocument::read(plant_dir / relative);
  const JsonNode root = document.root();
  root.expect_keys({"angle_factor", "cam_focal_length_x", "cam_focal_length_y", "cam_height_image",
                    "cam_origin_axis", "cam_pos_x", "cam_pos_y", "cam_pos_z", "cam_rot_x",
                    "cam_rot_y", "cam_rot_z", "cam_width_image"},
                   {"target_1_pos_x", "target_1_pos_y", "target_1_pos_z", "target_1_rot_x",
                    "target_1_rot_y", "target_1_rot_z", "target_2_pos_x", "target_2_pos_y",
                    "target_2_pos_z", "target_2_rot_x", "target_2_rot_y", "target_2_rot_z"});
  CabinCamera cabin;
  cabin.camera.width_px = static_cast<int>(root["cam_width_image"].integer(1, 65535));
  cabin.camera.height_px = static_cast<int>(root["cam_height_image"].integer(1, 65535));
  cabin.camera.fx_px = root["cam_focal_length_x"].number();
  cabin.camera.fy_px = root["cam_focal_length_y"].number();
  cabin.camera.cx_px = 0.5 * cabin.camera.width_px;
  cabin.camera.cy_px = 0.5 * cabin.camera.height_px;
  try {
    validate(cabin.camera);
  } catch (const std::invalid_argument& error) {
    root["cam_focal_length_x"].fail(std::string("with the image size: ") + error.what());
  }
  cabin.angle_factor = root["angle_factor"].number(0.5, 2);
  const auto place_m = [&](const char* key) {
    return 1e-3 * root[key].number(-kMostCoordinate, kMostCoordinate);
  };
  cabin.position_m = {place_m("cam_pos_x"), place_m("cam_pos_y"), place_m("cam_pos_z")};
  const Eigen::Matrix3d origin = root["cam_origin_axis"].matrix<4, 4>().topLeftCorner<3, 3>();
  if (!(origin * origin.transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-6) ||
      origin.determinant() < 0) {
    root["cam_origin_axis"].fail("is not a rotation");
  }
  const auto turn = [&](const char* key, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(root[key].number(-1e3, 1e3), axis).toRotationMatrix();
  };
  cabin.axes = origin * turn("cam_rot_x", Eigen::Vector3d::UnitX()) *
               turn("cam_rot_y", Eigen::Vector3d::UnitY()) *
               turn("cam_rot_z", Eigen::Vector3d::UnitZ());
  return cabin;
}

Pose camera_from_world(const CabinCamera& cabin, double angle_deg) {
  const double angle = angle_deg * cabin.angle_factor * std::numbers::pi / 180;
  Eigen::Matrix3d mirror;
  mirror << -std::cos(angle), -std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0, 0, 0, 1;
  return {Eigen::Quaterniond(Eigen::Matrix3d(-cabin.axes.transpose() * mirror)).normalized(),
          cabin.axes.transpose() * cabin.position_m};
}

/// White where the silhouette is not zero.
Image<Rgb8> binarized(Image<Rgb8> image) {
  for (Rgb8& pixel : image) {
    const bool inside = pixel.r != 0 || pixel.g != 0 || pixel.b != 0;
    pixel = inside ? Rgb8{255, 255, 255} : Rgb8{};
  }
  return image;
}

struct View {
  int angle_deg = 0;
  fs::path image;
};

/// ANGLE.png of a folder by angle.
std::vector<View> views_in(const fs::path& plant_dir, const fs::path& relative) {
  const fs::path folder = plant_dir / relative;
  if (!fs::is_directory(folder))
    throw std::runtime_error(folder.string() + ": the folder is missing");
  std::vector<View> views;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string stem = entry.path().stem().string();
    if (entry.path().extension() != ".png") continue;
    if (stem.empty() || stem.size() > 3 ||
        stem.find_first_not_of("0123456789") != std::string::npos) {
      throw std::runtime_error(entry.path().string() +
                               ": the name is not an angle in whole degrees");
    }
    views.push_back(
        {std::stoi(stem), resolve_inside(plant_dir, relative / entry.path().filename())});
  }
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return a.angle_deg < b.angle_deg; });
  return views;
}

}  // namespace

Capture import_phenomenal(const fs::path& plant_dir) {
  Capture capture;
  capture.board = "none";
  std::vector<fs::path> images;
  const auto add = [&](const char* calibration, const char* folder) {
    const CabinCamera cabin = read_cabin_camera(plant_dir, fs::path("calibration") / calibration);
    for (const View& view : views_in(plant_dir, fs::path("bin") / folder)) {
      const int id = static_cast<int>(capture.frames.size());
      Frame frame{.id = id,
                  .time_s = static_cast<double>(id),
                  .rig_from_world = camera_from_world(cabin, view.angle_deg)};
      frame.sensors.push_back({.reported = cabin.camera});
      capture.frames.push_back(std::move(frame));
      images.push_back(view.image);
    }
  };
  add("calibration_camera_side.json", "side");
  if (fs::exists(plant_dir / "calibration" / "calibration_camera_top.json"))
    add("calibration_camera_top.json", "top");
  if (capture.frames.empty())
    throw std::runtime_error(plant_dir.string() + ": no silhouettes in bin/side or bin/top");
  capture.rig.push_back({.camera = capture.frames.front().sensors.front().reported});

  check_images_memory(plant_dir, images);
  for_each_frame(images.size(), [&](std::size_t i) {
    SensorFrame& sensor = capture.frames[i].sensors.front();
    sensor.color = binarized(read_color(images[i]));
    if (sensor.color.width() != sensor.reported.width_px ||
        sensor.color.height() != sensor.reported.height_px) {
      throw std::runtime_error(
          images[i].string() + " (frame " + std::to_string(i) + "): the image is " +
          std::to_string(sensor.color.width()) + " x " + std::to_string(sensor.color.height()) +
          " pixels; its calibration has " + std::to_string(sensor.reported.width_px) + " x " +
          std::to_string(sensor.reported.height_px));
    }
  });
  return capture;
}

}  // namespace cousin
