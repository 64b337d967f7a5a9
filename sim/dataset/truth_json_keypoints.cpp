#include <algorithm>
#include <map>

#include "sim/dataset/json_interop.h"
#include "sim/dataset/truth_json.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxModels = 1'000'000;
constexpr std::size_t kMaxKeypoints = 10'000'000;
constexpr int kMaxKeypointId = 1'000'000'000;

Json json_of(const KeypointView& keypoint) {
  const char* state = keypoint.state == PointState::visible    ? "visible"
                      : keypoint.state == PointState::occluded ? "occluded"
                                                               : "outside";
  return {{"instance", keypoint.instance},
          {"keypoint", keypoint.keypoint},
          {"state", state},
          {"u_px", nan_to_null(keypoint.pixel_px.x())},
          {"v_px", nan_to_null(keypoint.pixel_px.y())},
          {"depth_m", nan_to_null(keypoint.depth_m)}};
}

}  // namespace

std::string keypoints_to_json(const Scene& scene, const std::vector<TrueView>& views,
                              const std::vector<TruthImages>& images) {
  Json models = Json::array();
  for (std::size_t i = 0; i < scene.models.size(); ++i) {
    if (scene.models[i].keypoints.empty()) continue;
    Json keypoints = Json::array();
    for (const Keypoint& keypoint : scene.models[i].keypoints) {
      keypoints.push_back(
          {{"name", keypoint.name}, {"in_object_m", to_json(keypoint.in_object_m)}});
    }
    models.push_back({{"model", i}, {"keypoints", keypoints}});
  }
  Json root = Json::object();
  root["models"] = models;
  const bool is_seen = std::any_of(images.begin(), images.end(),
                                   [](const TruthImages& i) { return !i.keypoints.empty(); });
  for (std::size_t i = 0; is_seen && i < images.size(); ++i) {
    Json entries = Json::array();
    for (const KeypointView& keypoint : images[i].keypoints) entries.push_back(json_of(keypoint));
    root["frames"][std::to_string(views[i].frame)] = entries;
  }
  return to_text(root);
}

void keypoint_views_from_json(std::string_view text, const std::string& name, const Scene& scene,
                              const std::vector<TrueView>& views,
                              std::vector<TruthImages>& images) {
  const JsonDocument document(text, name);
  if (!document.root().has("frames")) return;
  const std::vector<JsonNode> nodes = by_view(document.root()["frames"], views);
  std::map<int, std::size_t> keypoints_of;
  for (const Instance* instance : specimens_of(scene))
    keypoints_of[instance->id] =
        scene.models[static_cast<std::size_t>(instance->model)].keypoints.size();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const JsonNode& node : nodes[i].elements(kMaxKeypoints)) {
      node.expect_keys({"instance", "keypoint", "state", "u_px", "v_px", "depth_m"});
      KeypointView keypoint;
      keypoint.instance = static_cast<int>(node["instance"].integer(0, kMaxKeypointId));
      keypoint.keypoint = static_cast<int>(node["keypoint"].integer(0, kMaxKeypointId));
      const auto found = keypoints_of.find(keypoint.instance);
      if (found == keypoints_of.end()) node["instance"].fail("is not a specimen of the scene");
      if (static_cast<std::size_t>(keypoint.keypoint) >= found->second)
        node["keypoint"].fail("is not an index into the model's keypoints");
      const std::string state = node["state"].text(16);
      if (state != "visible" && state != "occluded" && state != "outside")
        node["state"].fail("is not one of visible, occluded, outside");
      keypoint.state = state == "visible"    ? PointState::visible
                       : state == "occluded" ? PointState::occluded
                                             : PointState::outside;
      keypoint.pixel_px = {node["u_px"].number_or_nan(), node["v_px"].number_or_nan()};
      keypoint.depth_m = node["depth_m"].number_or_nan();
      images[i].keypoints.push_back(keypoint);
    }
  }
}

void keypoints_from_json(std::string_view text, const std::string& name, Scene& scene) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"models"}, {"frames"});
  for (const JsonNode& node : root["models"].elements(kMaxModels)) {
    node.expect_keys({"model", "keypoints"});
    const auto index = static_cast<std::size_t>(node["model"].integer(0, kMaxKeypointId));
    if (index >= scene.models.size()) node["model"].fail("is not a model of the scene");
    if (!scene.models[index].keypoints.empty()) node["model"].fail("is a model that occurs twice");
    for (const JsonNode& entry : node["keypoints"].elements(100'000)) {
      entry.expect_keys({"name", "in_object_m"});
      scene.models[index].keypoints.push_back(
          {entry["name"].text(), entry["in_object_m"].vector<3>()});
    }
  }
}

}  // namespace cousin
