#pragma once

#include <cstdint>
#include <vector>

#include "perception/sfm/sfm_model.h"
#include "sim/geometry/similarity.h"
#include "sim/types/board.h"
#include "sim/types/seams.h"

namespace cousin {

/// How cameras stand about a plant of 0.2 m on a board: all around it and turned about the line of
/// sight; upright; straight down on a flat bench; towards it along the optical axis; all within a
/// few millimetres.
enum class CameraPath { around, upright, nadir_flat, forward, still };

struct PlantViewsConfig {
  int images = 18;
  int points = 100;
  double noise_px = 0.3;
  double corner_noise_px = 0.05;
  double focal_spread = 0;  ///< relative deviation of each image's own focal length
  CameraPath path = CameraPath::around;
  std::vector<int> lost;  ///< images that structure from motion did not place
};

/// What is true, what structure from motion hands over of it (in a frame and unit of its own), and
/// where the board's corners are seen.
struct PlantViews {
  Camera lens;
  std::vector<Camera> lenses;           ///< of each image: with its own focal length
  std::vector<Pose> camera_from_world;  ///< in metres, of all images
  std::vector<Eigen::Vector3d> points_in_world_m;
  WorldSimilarity model_from_world;
  SfmModel model;
  std::vector<int> frames;  ///< ids: 10, 11, ...
  SeedBoard board;
  Corners corners;
};
PlantViews plant_views(const PlantViewsConfig& config, std::uint64_t seed);

/// The lens of its images, 1280 x 720.
Camera plant_lens();

}  // namespace cousin
