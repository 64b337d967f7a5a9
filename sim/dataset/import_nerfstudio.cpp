// transforms.json of nerfstudio and instant-ngp
//   {keys of a lens (nerfstudio_lens.cpp), "applied_scale", "applied_transform", "unit",
//    "integer_depth_scale", "depth_unit_scale_factor",
//    "frames": [{"file_path": "images/0001.jpg", "transform_matrix": [[4] x 4],
//                "depth_file_path" or "depth_path", and any key of a lens}]}
// transform_matrix is camera-to-world with OpenGL axes (x right, y up, z backward); cx and cy count
// from the image's corner [docs.nerf.studio, "Data conventions"]. Lengths of the file are those of
// the capture times applied_scale [nerfstudio_dataparser.py: dataparser_scale]; its depth images
// are of the capture, 1 mm a unit. instant-ngp's depth images are integer_depth_scale of the file's
// lengths a unit.

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/import.h"
#include "sim/dataset/import_images.h"
#include "sim/dataset/nerfstudio_lens.h"
#include "sim/dataset/text_fields.h"
#include "sim/imaging/image_io.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxNerfstudioFrames = 1'000'000;
constexpr std::size_t kNerfstudioLimitBytes = std::size_t{1} << 29;

/// Keys that say nothing of where a pixel looks, how long a length is or what an image means: the
/// volume that a training fills, how it draws and splits, and what a generator noted.
constexpr std::array<std::string_view, 17> kHarmlessKeys = {"aabb_scale",
                                                            "aabb",
                                                            "scale",
                                                            "offset",
                                                            "sharpness",
                                                            "ply_file_path",
                                                            "up",
                                                            "orientation_override",
                                                            "colmap_im_id",
                                                            "train_filenames",
                                                            "val_filenames",
                                                            "test_filenames",
                                                            "rotation",
                                                            "n_frames",
                                                            "render_aabb",
                                                            "enable_depth_loading",
                                                            "sparse_pcd_path"};
/// Keys that are read, beside those of a lens.
constexpr std::array<std::string_view, 12> kReadKeys = {"frames",
                                                        "file_path",
                                                        "transform_matrix",
                                                        "applied_scale",
                                                        "applied_transform",
                                                        "unit",
                                                        "units",
                                                        "length_unit",
                                                        "depth_file_path",
                                                        "depth_path",
                                                        "depth_unit_scale_factor",
                                                        "integer_depth_scale"};
/// Keys that change what a pose or a time means, in ways that are not read.
constexpr std::array<std::string_view, 6> kRefusedKeys = {"transform_matrix_start",
                                                          "transform_matrix_end",
                                                          "rolling_shutter",
                                                          "normal_mts_args",
                                                          "from_na",
                                                          "from_mitsuba"};

template <class Keys>
bool is_one_of(std::string_view key, const Keys& keys) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

void refuse_keys(const JsonNode& node) {
  for (const std::string_view key : kRefusedKeys) {
    if (node.has(key) && !is_false_or_zero(node[key]))
      node[key].fail("changes what the poses mean, in a way that is not read");
  }
}

void warn_unknown_keys(const JsonNode& node, const std::string& where,
                       std::set<std::string>& warned, std::vector<std::string>& warnings) {
  refuse_keys(node);
  for (const auto& [key, value] : node.members(1000)) {
    if (is_one_of(key, kHarmlessKeys) || is_one_of(key, kReadKeys) ||
        is_one_of(key, kRefusedKeys) || is_nerfstudio_lens_key(key))
      continue;
    if (warned.insert(key).second) {
      warnings.push_back(node.file() + ": " + where + " has the key \"" + cut_utf8(key, 100) +
                         "\", which is not used" +
                         (key == "mask_path" ? " (masks of a training are --set masks=FOLDER of "
                                               "`cousin perceive --pipeline views`)"
                                             : ""));
    }
  }
}

/// Metres of one unit of the file's lengths; 1 where it names none.
double metres_per_unit(const JsonNode& root) {
  for (const char* key : {"unit", "units", "length_unit"}) {
    if (!root.has(key)) continue;
    const std::string unit = root[key].text(64);
    if (unit == "m" || unit == "metre" || unit == "meter" || unit == "meters") return 1;
    if (unit == "cm") return 0.01;
    if (unit == "mm") return 0.001;
    root[key].fail("is not one of m, cm, mm");
  }
  return 1;
}

/// What the file's lengths have been multiplied with. A turn of the world changes no length.
double applied_scale(const JsonNode& root, std::vector<std::string>& warnings) {
  if (root.has("applied_transform")) {
    const JsonNode node = root["applied_transform"];
    Eigen::Matrix3d turn;
    if (node.size(4) < 3) node.fail("does not have 3 or 4 rows");
    for (std::size_t row = 0; row < 3; ++row)
      turn.row(static_cast<Eigen::Index>(row)) = node[row].vector<4>().head<3>().transpose();
    if (!(turn * turn.transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-4) ||
        turn.determinant() < 0)
      node.fail("does not turn the world alone: it scales or mirrors it");
  }
  if (!root.has("applied_scale")) return 1;
  const double scale = root["applied_scale"].number(1e-9, 1e9);
  if (scale != 1)
    warnings.push_back(root.file() + ": lengths are divided by applied_scale = " +
                       exact_text(scale) + ", which gives those of the capture");
  return scale;
}

Pose read_camera_from_world(const JsonNode& node, double metres, const std::string& context) {
  if (node.size(4) < 3) node.fail("does not have 3 or 4 rows (" + context + ")");
  Eigen::Matrix4d world_from_camera = Eigen::Matrix4d::Identity();
  for (std::size_t row = 0; row < node.size(4); ++row) {
    world_from_camera.row(static_cast<Eigen::Index>(row)) = node[row].vector<4>().transpose();
  }
  if ((world_from_camera.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-6) {
    node.fail("does not end in the row 0 0 0 1 (" + context + ")");
  }
  if (world_from_camera.topRightCorner<3, 1>().cwiseAbs().maxCoeff() > kMostCoordinate)
    node.fail("has a place beyond 1e9 (" + context + ")");
  if (metres != 1) world_from_camera.topRightCorner<3, 1>() *= metres;
  world_from_camera.col(1) *= -1;  // OpenGL's y is up and its z backward
  world_from_camera.col(2) *= -1;
  try {
    return inverse(pose_from_matrix(world_from_camera));
  } catch (const std::invalid_argument& error) {
    node.fail("(" + context + "): " + error.what());
  }
}

/// Metres of a unit of the frames' depth images.
struct DepthUnits {
  double nerfstudio_m = 0.001;
  double ngp_m = 0;  ///< 0: not said
};

DepthUnits depth_units(const JsonNode& root, double metres) {
  DepthUnits units;
  if (root.has("depth_unit_scale_factor"))
    units.nerfstudio_m = root["depth_unit_scale_factor"].number(1e-9, 1e3);
  if (root.has("integer_depth_scale"))
    units.ngp_m = root["integer_depth_scale"].number(1e-12, 1e6) * metres;
  return units;
}

void read_depth_keys(const JsonNode& node, const DepthUnits& units, NerfstudioFrame& frame) {
  if (node.has("depth_file_path")) {
    if (node.has("depth_path")) node["depth_path"].fail("stands beside depth_file_path");
    frame.depth = node["depth_file_path"].text();
    frame.depth_unit_m = units.nerfstudio_m;
  } else if (node.has("depth_path")) {
    frame.depth = node["depth_path"].text();
    frame.depth_unit_m = units.ngp_m;
  }
}

/// The depth images that the frames name, where they have the colour image's pixels.
void read_depth(const std::string& name, const fs::path& folder,
                const std::vector<NerfstudioFrame>& frames, std::optional<double> unit_m,
                Capture& capture) {
  std::vector<fs::path> there;
  for (const NerfstudioFrame& listed : frames) {
    const auto file = listed.depth.empty() ? std::nullopt : find_listed_image(folder, listed.depth);
    if (file && file->extension() == ".png") there.push_back(*file);
  }
  check_depth_memory(folder, capture, there);
  std::vector<std::string> skipped(capture.frames.size());
  for_each_frame(capture.frames.size(), [&](std::size_t i) {
    const NerfstudioFrame& listed = frames[static_cast<std::size_t>(capture.frames[i].id)];
    SensorFrame& sensor = capture.frames[i].sensors.front();
    if (listed.depth.empty()) return;
    const std::string frame = "frame " + std::to_string(capture.frames[i].id);
    const std::optional<fs::path> file = find_listed_image(folder, listed.depth);
    if (!file) {
      skipped[i] = frame + " has no depth: " + listed.depth + " is absent";
    } else if (file->extension() != ".png") {
      skipped[i] = frame + " has no depth: " + listed.depth + " is not a PNG of 16 bits";
    } else if (const double metres = unit_m.value_or(listed.depth_unit_m); metres > 0) {
      Image<std::uint16_t> depth = read_png16(*file);
      if (depth.width() == sensor.reported.width_px &&
          depth.height() == sensor.reported.height_px) {
        sensor.depth = std::move(depth);
        sensor.depth_unit_m = metres;
      } else {
        skipped[i] = frame + " has no depth: " + listed.depth + " is " +
                     std::to_string(depth.width()) + " x " + std::to_string(depth.height()) +
                     " pixels, unlike the image";
      }
    } else {
      throw std::runtime_error(name + ": " + frame +
                               " has a depth_path, but the file has no integer_depth_scale: give "
                               "--depth-unit, metres a unit");
    }
  });
  for (const std::string& text : skipped) {
    if (!text.empty()) capture.warnings.push_back(name + ": " + text);
  }
}

}  // namespace

NerfstudioFile parse_nerfstudio(std::string_view text, const std::string& name,
                                const ImageSizeOf& size_of) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  NerfstudioFile result;
  std::set<std::string> warned;
  warn_unknown_keys(root, "the file", warned, result.warnings);
  const double metres = metres_per_unit(root) / applied_scale(root, result.warnings);
  const DepthUnits units = depth_units(root, metres);
  const bool loads_depth =
      !root.has("enable_depth_loading") || root["enable_depth_loading"].boolean();
  const std::vector<JsonNode> frames = root["frames"].elements(kMaxNerfstudioFrames);
  const bool says_size = root.has("w") || root.has("h") || !size_of;
  std::optional<Camera> shared;  // the file's lens, where no frame has its own
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const JsonNode& node = frames[i];
    const std::string context = "frame " + std::to_string(i);
    warn_unknown_keys(node, context, warned, result.warnings);
    NerfstudioFrame frame;
    frame.image = node["file_path"].text();
    bool has_own = !says_size;
    for (const auto& [key, value] : node.members(1000))
      has_own = has_own || is_nerfstudio_lens_key(key);
    const bool needs_size = !says_size && !node.has("w") && !node.has("h");
    const std::optional<ImageSize> size = needs_size ? size_of(frame.image) : std::nullopt;
    if (has_own || !shared) {
      // An image that is absent has no size; its frame is skipped.
      if (!needs_size || size)
        frame.camera = nerfstudio_lens(FrameKeys(root, node), size, context, result.warnings);
      if (!has_own) shared = frame.camera;
    } else {
      frame.camera = *shared;
    }
    frame.camera_from_world = read_camera_from_world(node["transform_matrix"], metres, context);
    if (loads_depth) read_depth_keys(node, units, frame);
    result.frames.push_back(std::move(frame));
  }
  return result;
}

NerfstudioFile read_nerfstudio(const fs::path& transforms_json) {
  const fs::path folder = transforms_json.parent_path();
  return parse_nerfstudio(
      read_file(transforms_json, kNerfstudioLimitBytes), transforms_json.string(),
      [&](const std::string& image) -> std::optional<ImageSize> {
        const auto file = find_listed_image(folder.empty() ? fs::path(".") : folder, image);
        if (!file) return std::nullopt;
        return read_image_size(*file);
      });
}

Capture import_nerfstudio(const fs::path& transforms_json, std::optional<double> depth_unit_m) {
  const fs::path folder =
      transforms_json.has_parent_path() ? transforms_json.parent_path() : fs::path(".");
  NerfstudioFile file = read_nerfstudio(transforms_json);

  Capture capture;
  capture.warnings = std::move(file.warnings);
  std::vector<fs::path> images;
  for (std::size_t i = 0; i < file.frames.size(); ++i) {
    const std::string& listed = file.frames[i].image;
    const std::optional<fs::path> image = find_listed_image(folder, listed);
    if (!image) {
      capture.warnings.push_back(
          transforms_json.string() + ": frame " + std::to_string(i) + " is skipped: " + listed +
          (fs::path(listed).has_extension() ? "" : " (.png, .jpg or .jpeg)") + " is absent");
      continue;
    }
    Frame frame{.id = static_cast<int>(i),
                .time_s = static_cast<double>(i),
                .rig_from_world = file.frames[i].camera_from_world};
    frame.sensors.push_back({.reported = file.frames[i].camera});
    capture.frames.push_back(std::move(frame));
    images.push_back(*image);
  }
  if (capture.frames.empty()) {
    throw std::runtime_error(
        transforms_json.string() + ": none of the listed images is there" +
        (file.frames.empty() ? ""
                             : "; the first is " + (folder / file.frames.front().image).string()));
  }
  capture.rig.push_back({.camera = capture.frames.front().sensors.front().reported});
  read_frame_colors(capture, images);
  read_depth(transforms_json.string(), folder, file.frames, depth_unit_m, capture);
  return capture;
}

}  // namespace cousin
