#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/dataset/scene_look_json.h"
#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

class JsonNode;

/// Private to sim/dataset: the JSON files of truth/ as text; the schemas are in truth_io.cpp.
/// Readers: @throws std::runtime_error naming `name`, key, value and limit.

/// Members of an object whose keys are the frames of `views`, in the order of the views.
std::vector<JsonNode> by_view(const JsonNode& root, const std::vector<TrueView>& views);

std::string views_to_json(const std::vector<TrueView>& views,
                          const std::vector<SensorViews>& others);  ///< camera.json
std::vector<TrueView> views_from_json(std::string_view text, const std::string& name,
                                      std::vector<SensorViews>& others);

std::string shared_plants_to_json(const std::vector<std::string>& plants);  ///< shared_plants.json
std::vector<std::string> shared_plants_from_json(std::string_view text, const std::string& name);

std::string scene_to_json(const Scene& scene);  ///< scene.json: all but meshes, keypoints, traits
/// Files that scene.json names, below truth/.
struct SceneFiles {
  std::vector<std::string> meshes;  ///< one a model
  std::vector<EnvironmentFile> environments;
};
/// Models come without meshes, environments with files without pictures; `files` names them.
Scene scene_from_json(std::string_view text, const std::string& name, SceneFiles& files);
std::string mesh_file(std::size_t model);  ///< "models/obj_000001.ply": BOP counts objects from 1

/// With the frames' keypoints, if any image has some.
std::string keypoints_to_json(const Scene& scene, const std::vector<TrueView>& views,
                              const std::vector<TruthImages>& images);
void keypoints_from_json(std::string_view text, const std::string& name, Scene& scene);
/// The frames' part, for a scene whose keypoints are read.
void keypoint_views_from_json(std::string_view text, const std::string& name, const Scene& scene,
                              const std::vector<TrueView>& views, std::vector<TruthImages>& images);
/// With what the views show, if any image has leaf areas.
std::string true_traits_to_json(const Scene& scene, const std::vector<TrueView>& views,
                                const std::vector<TruthImages>& images);
void true_traits_from_json(std::string_view text, const std::string& name, Scene& scene);

std::string scene_gt_to_json(const Scene& scene, const std::vector<TrueView>& views);
std::string scene_gt_info_to_json(const std::vector<TrueView>& views,
                                  const std::vector<TruthImages>& images);
/// Fills `visibility` of the images, one for each view.
void scene_gt_info_from_json(std::string_view text, const std::string& name,
                             const std::vector<TrueView>& views, std::vector<TruthImages>& images);

}  // namespace cousin
