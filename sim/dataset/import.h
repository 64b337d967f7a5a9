#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/imaging/image_size.h"
#include "sim/types/capture.h"

namespace cousin {

/// nerfstudio / instant-ngp transforms.json: camera-to-world, OpenGL axes, corner-based principal
/// point; without a size in it, that of the images. A name without an ending is that of a .png,
/// .jpg or .jpeg. Listed images that are absent are skipped and named in Capture::warnings, as are
/// keys that are not known; keys that change what a pixel, a pose or a length means are read or
/// refused. Lengths are the file's over its applied_scale (often not metres) and are taken as
/// metres unless it names its unit.
/// @param depth_unit_m  of the depth images that it names; none: nerfstudio's 0.001, instant-ngp's
/// integer_depth_scale. @throws std::runtime_error naming file, key or frame.
Capture import_nerfstudio(const std::filesystem::path& transforms_json,
                          std::optional<double> depth_unit_m = {});

/// The frames that a transforms.json lists, before any image is read.
struct NerfstudioFrame {
  std::string image;  ///< path below the file's folder, as it stands there
  Camera camera;      ///< without a size where neither the file nor the image gives one
  Pose camera_from_world;
  std::string depth;        ///< likewise; "" = none
  double depth_unit_m = 0;  ///< 0: not said
};
struct NerfstudioFile {
  std::vector<NerfstudioFrame> frames;
  std::vector<std::string> warnings;  ///< keys that are not known
};
/// Size of the image of a file_path, or nothing if it is absent.
using ImageSizeOf = std::function<std::optional<ImageSize>(const std::string& file_path)>;
/// @param name  for errors. @param size_of  asked where the file gives no size; none: that is an
/// error. @throws std::runtime_error naming `name`, the key, the value and the limit.
NerfstudioFile parse_nerfstudio(std::string_view text, const std::string& name,
                                const ImageSizeOf& size_of = {});
/// The same of a file beside its images.
NerfstudioFile read_nerfstudio(const std::filesystem::path& transforms_json);

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

/// A COLMAP workspace: images/ (or the images in SOURCE itself) and a sparse model in SOURCE, in
/// the one of sparse/0, sparse/1, ... that has most images, in sparse/ or in sparse_txt/, binary if
/// it is there, else text. One sensor; frames in the order of the images' names, each with its own
/// camera and pose. Listed images that are absent are skipped and named in Capture::warnings, as
/// are models that are not taken. Lengths are the model's (often not metres) and are taken as
/// metres. @throws std::runtime_error naming file, place, value and limit.
Capture import_colmap(const std::filesystem::path& folder);

/// A TUM RGB-D sequence: rgb.txt, and depth.txt (in the colour image's pixels) and groundtruth.txt
/// if they are there. Times are seconds, or nanoseconds since 1970. A depth image within 0.02 s of
/// a colour image belongs to it; a pose is interpolated between neighbours at most 0.1 s apart, or
/// that of a neighbour within 0.001 s. TUM's files hold no lens: `intrinsics` is as for a folder of
/// images, empty = the folder's camera.yaml. What is absent is skipped and named in
/// Capture::warnings.
/// @param depth_unit_m  none: of a comment of depth.txt such as "# 5000 = 1 m", else 5000 = 1 m if
/// the median depth is then 0.4 to 10 m. @throws std::runtime_error naming file, line, value and
/// limit.
Capture import_tum(const std::filesystem::path& folder, const std::string& intrinsics,
                   std::optional<double> depth_unit_m = {});

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

/// What a person says of a capture's units.
struct ImportUnits {
  std::optional<double> depth_m;   ///< metres of one unit of a depth image
  std::optional<double> length_m;  ///< metres of one unit of a calibration's lengths
};

/// Colour and depth images: folders rgb/ (color, colour, image, images) and depth/, or files with
/// such words in their names, as frame-000000.color.png; poses beside them. Depth is 16-bit PNG, or
/// floats in metres (.npy, .exr). One sensor, with depth in the colour image's pixels; or a second
/// one "depth" in its own, where the intrinsics have a depth camera and its place.
/// @param intrinsics  file of one camera or of both, or "fx,fy,cx,cy[,k1,k2,p1,p2,k3]"; "" = of a
/// usual name in the folder. @throws std::runtime_error naming file, key, value and limit: no unit
/// of the depth, a median depth outside 1 cm to 20 m, an image of another size than its camera,
/// cameras more than 0.5 m apart, a pose that is none.
Capture import_rgbd(const std::filesystem::path& folder, const std::string& intrinsics,
                    const ImportUnits& units = {});

/// Pictures of two cameras side by side: in folders left/ and right/ (or image_0 and image_1,
/// image_2 and image_3, cam0 and cam1, their pictures in data/ or not), or with such words in their
/// names. The rig's sensors are "rgb", the left one, and "rgb_right". Names that are time stamps
/// give the frames' times.
/// @param intrinsics  file of both cameras in a format of camera_pair.h; "" = of a usual name in
/// the folder, or two such files. @param length_unit_m  metres of the file's lengths; none: as the
/// format says, else metres. @throws std::runtime_error naming file, key, value and limit: a
/// picture without its partner or of another size than its camera, cameras less than 5 mm or more
/// than 2 m apart, or a second camera that is not on the right of the first.
Capture import_stereo(const std::filesystem::path& folder, const std::string& intrinsics,
                      std::optional<double> length_unit_m = {});

/// A lens that nobody has calibrated.
struct AssumedLens {
  Camera camera;
  double focal_sigma_px = 0;  ///< standard deviation of the focal length
  std::string from;           ///< what it rests on and what is assumed, for the message
};
/// Of photographs, frames with colour images alone.
using LensOfPhotographs = std::function<AssumedLens(const Capture& photographs)>;

/// A folder of images (PNG, JPEG; sorted by name) with intrinsics in an OpenCV/ROS/Kalibr/BoofCV
/// YAML, a .cameramodel of mrcal, our rig.json (its first sensor's camera), or given as text
/// "fx,fy,cx,cy[,k1,k2,p1,p2,k3]" (pixel centres, at the images' size); no poses. Without
/// `intrinsics` ("") the focal length is EXIF's, else `solve` says it; Capture::warnings has the
/// value, its deviation and its source. EXIF's orientation is not applied. @throws
/// std::runtime_error naming file and key, an image of another size than its camera, or photographs
/// of two focal lengths; std::invalid_argument for text that is no intrinsics.
Capture import_folder(const std::filesystem::path& folder, const std::string& intrinsics,
                      const LensOfPhotographs& solve = {});

/// The camera that `intrinsics` of import_folder says, for images of that size.
Camera camera_from_intrinsics(const std::string& intrinsics, int width_px, int height_px);

/// A pinhole camera of square pixels that looks through the centre of its image.
Camera camera_of_focal(double focal_px, int width_px, int height_px);

/// Camera of an OpenCV (camera_matrix, distortion_coefficients), ROS (camera_info), Kalibr (of one
/// camera) or BoofCV YAML file's text.
/// @param name  for errors. @throws std::runtime_error naming it and the key.
Camera camera_from_yaml(std::string_view text, const std::string& name);

}  // namespace cousin
