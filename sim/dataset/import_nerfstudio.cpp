// transforms.json of nerfstudio and instant-ngp
//   {"fl_x", "fl_y", "cx", "cy", "w", "h", "k1", "k2", "k3", "k4", "p1", "p2", "camera_model",
//    "camera_angle_x", "is_fisheye",
//    "frames": [{"file_path": "images/0001.jpg", "transform_matrix": [[4] x 4], and any of the
//                intrinsics}]}
// transform_matrix is camera-to-world with OpenGL axes (x right, y up, z backward); cx and cy count
// from the image's corner [docs.nerf.studio, "Data conventions"].

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/json_interop.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxFrames = 1'000'000;

/// Keys of other tools that do not change where a pixel looks.
constexpr std::array<std::string_view, 19> kIgnoredKeys = {"aabb_scale",
                                                           "aabb",
                                                           "scale",
                                                           "offset",
                                                           "sharpness",
                                                           "camera_angle_y",
                                                           "ply_file_path",
                                                           "applied_transform",
                                                           "applied_scale",
                                                           "orientation_override",
                                                           "colmap_im_id",
                                                           "depth_file_path",
                                                           "train_filenames",
                                                           "val_filenames",
                                                           "test_filenames",
                                                           "from_na",
                                                           "enable_depth_loading",
                                                           "integer_depth_scale",
                                                           "up"};
constexpr std::array<std::string_view, 16> kUsedKeys = {"fl_x",
                                                        "fl_y",
                                                        "cx",
                                                        "cy",
                                                        "w",
                                                        "h",
                                                        "k1",
                                                        "k2",
                                                        "k3",
                                                        "k4",
                                                        "p1",
                                                        "p2",
                                                        "camera_model",
                                                        "camera_angle_x",
                                                        "is_fisheye",
                                                        "frames"};

void warn_unknown_keys(const JsonNode& node, const std::string& where,
                       std::set<std::string>& warned, std::vector<std::string>& warnings) {
  for (const auto& [key, value] : node.members(1000)) {
    const auto knows = [&key = key](const auto& keys) {
      return std::find(keys.begin(), keys.end(), key) != keys.end();
    };
    if (knows(kIgnoredKeys) || knows(kUsedKeys) || key == "file_path" || key == "transform_matrix")
      continue;
    if (warned.insert(key).second) {
      warnings.push_back(node.file() + ": " + where + " has the key \"" + key.substr(0, 100) +
                         "\", which is not used" +
                         (key == "mask_path" ? " (masks of a training are --set masks=FOLDER of "
                                               "`cousin perceive --pipeline views`)"
                                             : ""));
    }
  }
}

/// A key of the frame, else of the file.
class Intrinsics {
 public:
  Intrinsics(const JsonNode& file, const JsonNode& frame) : file_(file), frame_(frame) {}
  bool has(std::string_view key) const { return frame_.has(key) || file_.has(key); }
  JsonNode at(std::string_view key) const { return frame_.has(key) ? frame_[key] : file_[key]; }
  double number_or(std::string_view key, double otherwise) const {
    return has(key) ? at(key).number() : otherwise;
  }
  /// Sizes are often written as 1080.0.
  int pixels(std::string_view key) const {
    const double value = at(key).number(1, 65535);
    if (value != std::floor(value)) at(key).fail("is not a whole number of pixels");
    return static_cast<int>(value);
  }

 private:
  JsonNode file_;
  JsonNode frame_;
};

bool is_fisheye(const Intrinsics& values) {
  if (values.has("is_fisheye") && values.at("is_fisheye").boolean()) return true;
  if (!values.has("camera_model")) return false;
  const std::string model = values.at("camera_model").text(64);
  if (model == "OPENCV_FISHEYE") return true;
  if (model != "OPENCV" && model != "PINHOLE" && model != "SIMPLE_PINHOLE" &&
      model != "SIMPLE_RADIAL" && model != "RADIAL") {
    values.at("camera_model")
        .fail(
            "is not one of OPENCV, OPENCV_FISHEYE, PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL");
  }
  return false;
}

Camera read_lens(const Intrinsics& values, const std::string& context) {
  Camera camera;
  camera.width_px = values.pixels("w");
  camera.height_px = values.pixels("h");
  if (values.has("fl_x") || !values.has("camera_angle_x")) {
    camera.fx_px = values.at("fl_x").number();
  } else {
    camera.fx_px =
        0.5 * camera.width_px / std::tan(0.5 * values.at("camera_angle_x").number(1e-3, 3.1));
  }
  camera.fy_px = values.number_or("fl_y", camera.fx_px);
  // From the image's corner to the centre of its first pixel.
  camera.cx_px = values.number_or("cx", 0.5 * camera.width_px) - 0.5;
  camera.cy_px = values.number_or("cy", 0.5 * camera.height_px) - 0.5;
  const double k1 = values.number_or("k1", 0), k2 = values.number_or("k2", 0),
               k3 = values.number_or("k3", 0);
  const double k4 = values.number_or("k4", 0), p1 = values.number_or("p1", 0),
               p2 = values.number_or("p2", 0);
  if (is_fisheye(values)) {
    camera.model = LensModel::kannala_brandt4;
    camera.distortion = {k1, k2, k3, k4};
  } else if (k1 != 0 || k2 != 0 || k3 != 0 || p1 != 0 || p2 != 0) {
    camera.model = LensModel::opencv5;
    camera.distortion = {k1, k2, p1, p2, k3};
  }
  if (k4 != 0 && camera.model != LensModel::kannala_brandt4) {
    values.at("k4").fail("is not zero, but the lens is not a fisheye (" + context + ")");
  }
  try {
    validate(camera);
  } catch (const std::invalid_argument& error) {
    values.at(values.has("fl_x") ? "fl_x" : "w")
        .fail("with the other intrinsics (" + context + "): " + error.what());
  }
  return camera;
}

Pose read_camera_from_world(const JsonNode& node, const std::string& context) {
  if (node.size(4) < 3) node.fail("does not have 3 or 4 rows (" + context + ")");
  Eigen::Matrix4d world_from_camera = Eigen::Matrix4d::Identity();
  for (std::size_t row = 0; row < node.size(4); ++row) {
    world_from_camera.row(static_cast<Eigen::Index>(row)) = node[row].vector<4>().transpose();
  }
  if ((world_from_camera.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-6) {
    node.fail("does not end in the row 0 0 0 1 (" + context + ")");
  }
  world_from_camera.col(1) *= -1;  // OpenGL's y is up and its z backward
  world_from_camera.col(2) *= -1;
  try {
    return inverse(pose_from_matrix(world_from_camera));
  } catch (const std::invalid_argument& error) {
    node.fail("(" + context + "): " + error.what());
  }
}

}  // namespace

NerfstudioFile parse_nerfstudio(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  NerfstudioFile result;
  std::set<std::string> warned;
  warn_unknown_keys(root, "the file", warned, result.warnings);
  const std::vector<JsonNode> frames = root["frames"].elements(kMaxFrames);
  std::optional<Camera> shared;  // the file's lens, where no frame has its own
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const JsonNode& node = frames[i];
    const std::string context = "frame " + std::to_string(i);
    warn_unknown_keys(node, context, warned, result.warnings);
    NerfstudioFrame frame;
    frame.image = node["file_path"].text();
    const bool has_own = std::any_of(kUsedKeys.begin(), kUsedKeys.end(),
                                     [&](std::string_view key) { return node.has(key); });
    if (has_own || !shared) {
      frame.camera = read_lens(Intrinsics(root, node), context);
      if (!has_own) shared = frame.camera;
    } else {
      frame.camera = *shared;
    }
    frame.camera_from_world = read_camera_from_world(node["transform_matrix"], context);
    result.frames.push_back(std::move(frame));
  }
  return result;
}

Capture import_nerfstudio(const fs::path& transforms_json) {
  const fs::path folder =
      transforms_json.has_parent_path() ? transforms_json.parent_path() : fs::path(".");
  NerfstudioFile file =
      parse_nerfstudio(read_file(transforms_json, std::size_t{1} << 29), transforms_json.string());

  Capture capture;
  capture.warnings = std::move(file.warnings);
  std::vector<fs::path> images;
  for (std::size_t i = 0; i < file.frames.size(); ++i) {
    fs::path relative = file.frames[i].image;
    if (!relative.has_extension()) relative += ".png";  // Blender's synthetic sets leave it out
    const fs::path image = resolve_inside(folder, relative);
    if (!fs::exists(image)) {
      capture.warnings.push_back(transforms_json.string() + ": frame " + std::to_string(i) +
                                 " is skipped: " + relative.string() + " is absent");
      continue;
    }
    Frame frame{.id = static_cast<int>(i),
                .time_s = static_cast<double>(i),
                .rig_from_world = file.frames[i].camera_from_world};
    frame.sensors.push_back({.reported = file.frames[i].camera});
    capture.frames.push_back(std::move(frame));
    images.push_back(image);
  }
  if (capture.frames.empty())
    throw std::runtime_error(transforms_json.string() + ": none of the listed images is there");
  capture.rig.push_back({.camera = capture.frames.front().sensors.front().reported});
  read_frame_colors(capture, images);
  return capture;
}

}  // namespace cousin
