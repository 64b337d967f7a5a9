#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"
#include "sim/types/capture.h"

namespace cousin {

/// The true side of a scene, without meshes and without images.
struct ExportTruth {
  std::vector<std::string> shared_plants;  ///< that other scenes show too
  std::vector<TrueView> views;             ///< of the rig's first sensor
  /// Of the rest, in the rig's order; images as `labels`, empty where truth is not of the sensor.
  std::vector<SensorViews> other_sensors;
  Scene scene;                          ///< models without meshes
  std::vector<std::string> mesh_files;  ///< of the models, below truth/
  std::vector<TruthImages> labels;  ///< visibility and keypoints of each view; empty = not planned
};

/// A picture that a sensor took, still on disk.
struct ExportPicture {
  std::size_t frame = 0;       ///< into Capture::frames
  std::size_t sensor = 0;      ///< into Capture::rig
  std::filesystem::path file;  ///< PNG or JPEG
  bool is_grey = false;
};

/// A scene of a dataset as exports read it: everything but pixels and meshes, so that many and
/// long scenes fit into memory.
struct ExportScene {
  std::filesystem::path folder;
  int number = 0;                                   ///< that the folder is named by
  Capture capture;                                  ///< without images
  std::vector<ExportPicture> pictures;              ///< colour or grey, by frame and sensor
  std::vector<std::filesystem::path> depth_images;  ///< of each frame of the first sensor or the
                                                    ///< rig's depth sensor; empty path = none
  std::optional<std::size_t> depth_sensor;          ///< whose pixels these have
  std::optional<ExportTruth> truth;                 ///< if there is truth/
};
/// @throws std::runtime_error naming file, key, value and limit, or the image that is missing.
ExportScene read_export_scene(const std::filesystem::path& scene_dir);

/// How a dataset is handed over.
enum class MaskCode { rle, polygon };
enum class YoloTask { detect, segment, pose };
struct ExportOptions {
  bool undistort = false;     ///< pictures and labels as a pinhole camera would have taken them
  bool true_cameras = false;  ///< true lenses and poses in place of what the rig reports
  /// Shares of train, val and test; scenes that show the same plants stay together.
  std::array<double, 3> split = {0.8, 0.1, 0.1};
  MaskCode masks = MaskCode::rle;
  YoloTask task = YoloTask::detect;
  /// Label of the specimens by which COCO and YOLO sort them; empty: the dataset's categories.
  std::string category;
  double least_visible = 0;  ///< objects of which less is seen are left out of COCO and YOLO
};
/// Options by their names on a command line: "rle", "polygon"; "detect", "segment", "pose";
/// "0.8,0.1,0.1". @throws std::invalid_argument naming the text and what it must be.
MaskCode mask_code_from_string(const std::string& text);
YoloTask yolo_task_from_string(const std::string& text);
std::array<double, 3> split_from_string(const std::string& text);
std::string_view to_string(MaskCode code);
std::string_view to_string(YoloTask task);

/// The lens and place of one picture, reported or true; before it is undistorted.
struct ExportCamera {
  Camera camera;
  std::optional<Pose> camera_from_world;  ///< of the middle row; nothing where the rig knows none
  double time_s = 0;
};
/// @throws std::invalid_argument naming the scene if true cameras are asked and it has no truth.
ExportCamera camera_of(const ExportScene& scene, const ExportPicture& picture, bool is_true);
/// camera_of, its pose required: @throws std::invalid_argument saying how to get one.
Pose pose_of(const ExportScene& scene, const ExportPicture& picture, const ExportCamera& camera);

/// The camera of the picture as it is handed over: the lens, or the pinhole camera of --undistort.
Camera handed_over(const Camera& lens, const ExportOptions& options);

/// @throws std::invalid_argument naming the scene and the format unless there is truth.
const ExportTruth& truth_of(const ExportScene& scene, const std::string& format);

}  // namespace cousin
