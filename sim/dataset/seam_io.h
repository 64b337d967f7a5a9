#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "sim/types/seams.h"
#include "sim/types/tracks.h"

namespace cousin {

/// Seams on disk, design §3; each reader bounds counts, rejects unknown keys and wrong types and
/// names file, key and value.
void write_corners(const std::filesystem::path& dir, const Corners& corners);  // corners.json
Corners read_corners(const std::filesystem::path& dir);
void write_poses(const std::filesystem::path& dir, const Poses& poses);  // poses.json
Poses read_poses(const std::filesystem::path& dir);
void write_depths(const std::filesystem::path& dir,
                  const Depths& depths);  // depth/000000.exr, depth_sigma/, depth_normal/
Depths read_depths(const std::filesystem::path& dir);
void write_cloud(const std::filesystem::path& dir, const Cloud& cloud);  // cloud.ply
Cloud read_cloud(const std::filesystem::path& dir);
void write_clusters(const std::filesystem::path& dir, const Clusters& clusters);  // clusters.ply
Clusters read_clusters(const std::filesystem::path& dir);
/// masks.json, COCO results: image_id = 1,000,000 scene + frame, sub-pixel polygons, `instance_id`,
/// and per-point "cousin" arrays (normal, sigma, on_object) that other programs may leave out.
void write_silhouettes(const std::filesystem::path& dir, const Silhouettes& silhouettes,
                       int scene_index);
/// What masks may be of.
struct MaskImages {
  int scene = -1;                          ///< -1: any
  std::map<int, Eigen::Vector2i> size_px;  ///< width and height of each frame; empty: not known
};
/// Polygons and run lengths. @throws std::runtime_error also where a mask is not of `images`.
Silhouettes read_silhouettes(const std::filesystem::path& dir, const MaskImages& images = {});
/// What boxes and keypoints may be of.
struct DetectionImages {
  int scene = -1;  ///< -1: any
  /// Width and height of each image, by frame and sensor; empty: not known.
  std::map<std::pair<int, int>, Eigen::Vector2i> size_px;
};
/// boxes.json and keypoints.json, COCO results; see seam_detections.cpp.
void write_boxes(const std::filesystem::path& dir, const Boxes& boxes, int scene_index);
Boxes read_boxes(const std::filesystem::path& dir, const DetectionImages& images = {});
void write_keypoints(const std::filesystem::path& dir, const Keypoints& keypoints, int scene_index);
Keypoints read_keypoints(const std::filesystem::path& dir, const DetectionImages& images = {});
void write_fits(const std::filesystem::path& dir, const Fits& fits);  // fits.json
Fits read_fits(const std::filesystem::path& dir);
void write_tracks(const std::filesystem::path& dir, const Tracks& tracks);  // tracks.json
Tracks read_tracks(const std::filesystem::path& dir);
void write_surfaces(const std::filesystem::path& dir,
                    const Surfaces& surfaces);  // meshes/000000.ply, surfaces.json
Surfaces read_surfaces(const std::filesystem::path& dir);
void write_traits(const std::filesystem::path& dir, const Traits& traits);  // traits.json
Traits read_traits(const std::filesystem::path& dir);
void write_timings(const std::filesystem::path& dir,
                   const std::vector<StageTiming>& timings);  // timings.json
std::vector<StageTiming> read_timings(const std::filesystem::path& dir);

}  // namespace cousin
