#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/dataset/truth_format.h"
#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// All truth of one scene, apart from per-frame images.
struct SceneTruth {
  std::uint64_t seed = 0;
  std::string config_toml;  ///< resolved
  Scene scene;              ///< with instances where they came to rest
  /// Names of plants that other scenes of the dataset show too, on another day or in another light:
  /// exports keep those scenes on one side of a split.
  std::vector<std::string> shared_plants;
  std::vector<TrueView> views;             ///< of the rig's first sensor
  std::vector<SensorViews> other_sensors;  ///< in the rig's order, as many views each
  std::vector<TruthImages> images;  ///< of the first sensor: one for each view, or empty; what was
                                    ///< not planned is empty
};

/// SCENE_DIR/truth: config.toml, seed, shared_plants.json (if there are some), camera.json,
/// scene_gt.json, scene_gt_info.json (BOP), traits.json, keypoints.json, models/*.ply, and image
/// folders for what is there; sensors/NAME/ for what another sensor sees. Library target of its
/// own: perception cannot link it. `images` is empty or one for each view; visibility of an image
/// is empty or of all specimens by id, and so are shares.
/// @throws std::invalid_argument otherwise or if the scene is not valid, std::runtime_error if a
/// file cannot be written.
void write_truth(const std::filesystem::path& scene_dir, const SceneTruth& truth,
                 TruthFormat format = TruthFormat::npy);
/// The image files of one frame alone, so that a long scene need not be in memory at once:
/// write_truth with what is then left of each frame, its `visibility`, `keypoints` and
/// `leaf_areas`, makes the same folder.
/// @param sensor  whose images they are; empty: the first
/// @throws as write_truth.
void write_truth_images(const std::filesystem::path& scene_dir, const Scene& scene, int frame,
                        const TruthImages& images, TruthFormat format = TruthFormat::npy,
                        const std::string& sensor = {});
/// Everything that scoring needs: specimens with meshes, poses, traits, views, visibility; images
/// if they exist, each of the format that is there. All that was written comes back bit by bit but
/// for depths as png16, the models' vertex albedo and vertex normals, and leaf areas seen; of the
/// last three no score uses any.
/// @throws std::runtime_error naming file, key, value and limit.
SceneTruth read_truth(const std::filesystem::path& scene_dir);

/// What is true of one sensor of the rig, 0 = first. @throws std::out_of_range
struct SensorTruth {
  const std::vector<TrueView>& views;
  const std::vector<TruthImages>& images;
};
SensorTruth truth_of_sensor(const SceneTruth& truth, std::size_t sensor);
/// Places in the rig of the first sensor and of those others whose images there are.
std::vector<std::size_t> sensors_with_truth(const SceneTruth& truth);

}  // namespace cousin
