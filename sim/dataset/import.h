#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/capture.h"

namespace cousin {

/// nerfstudio / instant-ngp transforms.json: camera-to-world, OpenGL axes, corner-based principal
/// point. Listed images that are absent are skipped and named in Capture::warnings, as are keys
/// that are not known. Lengths are the file's (often not metres) and are taken as metres. @throws
/// std::runtime_error naming file, key or frame.
Capture import_nerfstudio(const std::filesystem::path& transforms_json);

/// The frames that a transforms.json lists, before any image is read.
struct NerfstudioFrame {
  std::string image;  ///< path below the file's folder
  Camera camera;
  Pose camera_from_world;
};
struct NerfstudioFile {
  std::vector<NerfstudioFrame> frames;
  std::vector<std::string> warnings;  ///< keys that are not known
};
/// @param name  for errors. @throws std::runtime_error naming it, the key, the value and the limit.
NerfstudioFile parse_nerfstudio(std::string_view text, const std::string& name);

/// The OpenAlea phenomenal calibration of a turntable cabin with its binary silhouettes, as a
/// Capture whose frames carry poses; silhouettes become white-on-black colour images. Millimetres
/// become metres. One sensor; frames are the side views by turntable angle, then the top view, each
/// with its own camera. World: z up along the turntable's axis.
/// @throws std::runtime_error naming file and key, or the missing folder.
Capture import_phenomenal(const std::filesystem::path& plant_dir);

/// A voxel carving of phenomenal (numpy .npz), for comparison with a carving of the imported
/// capture.
struct VoxelCarving {
  double voxel_m = 0;  ///< side
  std::vector<Eigen::Vector3d>
      centres_m;  ///< of the filled voxels, in the imported capture's world
};
/// @throws std::runtime_error naming the file if it is not such an archive or has more than 2^30
/// voxels.
VoxelCarving read_phenomenal_voxels(const std::filesystem::path& npz);

/// A COLMAP workspace: images/ (or the images in SOURCE itself) and a sparse model in SOURCE,
/// sparse/0/ or sparse/, binary if it is there, else text. One sensor; frames in the order of the
/// images' names, each with its own camera and pose. Listed images that are absent are skipped and
/// named in Capture::warnings. Lengths are the model's (often not metres) and are taken as metres.
/// @throws std::runtime_error naming file, place, value and limit.
Capture import_colmap(const std::filesystem::path& folder);

/// A TUM RGB-D sequence: rgb.txt, and depth.txt (5000 = 1 m, in the colour image's pixels) and
/// groundtruth.txt if they are there. A depth image within 0.02 s of a colour image belongs to it;
/// a pose is interpolated between neighbours at most 0.1 s apart. TUM's files hold no lens:
/// `intrinsics` is as for a folder of images, empty = the folder's camera.yaml. What is skipped is
/// named in Capture::warnings. @throws std::runtime_error naming file, line, value and limit.
Capture import_tum(const std::filesystem::path& folder, const std::string& intrinsics);

/// Lines of a TUM list: rgb.txt and depth.txt (time, file), groundtruth.txt (time, pose).
struct TumFile {
  double time_s = 0;
  std::string file;
};
std::vector<TumFile> tum_files(std::string_view text, const std::string& name);
struct TumPose {
  double time_s = 0;
  Pose world_from_camera;
};
std::vector<TumPose> tum_poses(std::string_view text, const std::string& name);

/// A folder of images (PNG, JPEG; sorted by name) with intrinsics in an OpenCV/ROS/Kalibr/BoofCV
/// YAML, a .cameramodel of mrcal, our rig.json (its first sensor's camera), or given as text
/// "fx,fy,cx,cy[,k1,k2,p1,p2,k3]" (pixel centres, at the images' size); no poses. @throws
/// std::runtime_error naming file and key, or an image of another size than its camera.
Capture import_folder(const std::filesystem::path& folder, const std::string& intrinsics);

/// The camera that `intrinsics` of import_folder says, for images of that size.
Camera camera_from_intrinsics(const std::string& intrinsics, int width_px, int height_px);

/// Camera of an OpenCV (camera_matrix, distortion_coefficients), ROS (camera_info), Kalibr (of one
/// camera) or BoofCV YAML file's text.
/// @param name  for errors. @throws std::runtime_error naming it and the key.
Camera camera_from_yaml(std::string_view text, const std::string& name);

}  // namespace cousin
