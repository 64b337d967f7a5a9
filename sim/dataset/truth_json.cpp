#include "sim/dataset/truth_json.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "sim/dataset/json_interop.h"
#include "sim/dataset/scene_look_json.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxSensors = 64;
constexpr std::size_t kMaxViews = 1'000'000;
constexpr std::size_t kMaxInstances = 1'000'000;
constexpr std::size_t kMaxTriangles = std::size_t{1} << 26;
constexpr int kMaxId = 1'000'000'000;

// ---- parts of a scene ---------------------------------------------------------------------------

Json json_of(const Instance& instance) {
  Json motion = Json::array();
  for (const TimedPose& step : instance.motion) {
    motion.push_back(
        {{"time_s", step.time_s}, {"world_from_object", to_json(step.world_from_object)}});
  }
  Json json = {{"id", instance.id},
               {"name", instance.name},
               {"category", instance.category},
               {"is_specimen", instance.is_specimen},
               {"model", instance.model},
               {"material", instance.material},
               {"mass_kg", instance.mass_kg},
               {"world_from_object", to_json(instance.world_from_object)},
               {"motion", motion}};
  for (const TrueLabel& label : instance.labels) json["labels"][label.name] = label.value;
  if (!instance.part_materials.empty()) json["part_materials"] = instance.part_materials;
  if (instance.part_of >= 0) json["part_of"] = instance.part_of;
  if (!instance.keypoint_carriers.empty()) json["keypoint_carriers"] = instance.keypoint_carriers;
  return json;
}

Instance read_instance(const JsonNode& node) {
  node.expect_keys({"id", "name", "category", "is_specimen", "model", "material", "mass_kg",
                    "world_from_object", "motion"},
                   {"labels", "part_materials", "part_of", "keypoint_carriers"});
  Instance instance;
  instance.id = static_cast<int>(node["id"].integer(0, kMaxId));
  instance.name = node["name"].text();
  instance.category = node["category"].text();
  instance.is_specimen = node["is_specimen"].boolean();
  instance.model = static_cast<int>(node["model"].integer(0, kMaxId));
  instance.material = static_cast<int>(node["material"].integer(0, kMaxId));
  if (node.has("labels")) {
    for (const auto& [label, value] : node["labels"].members(100))
      instance.labels.push_back({label, value.text()});
  }
  if (node.has("part_materials")) {
    for (const JsonNode& part : node["part_materials"].elements(65535))
      instance.part_materials.push_back(static_cast<int>(part.integer(0, kMaxId)));
  }
  if (node.has("part_of")) instance.part_of = static_cast<int>(node["part_of"].integer(0, kMaxId));
  if (node.has("keypoint_carriers")) {
    for (const JsonNode& carrier : node["keypoint_carriers"].elements(100'000))
      instance.keypoint_carriers.push_back(static_cast<int>(carrier.integer(0, kMaxId)));
  }
  instance.mass_kg = node["mass_kg"].number(0);
  instance.world_from_object = read_pose(node["world_from_object"]);
  for (const JsonNode& step : node["motion"].elements(10'000'000)) {
    step.expect_keys({"time_s", "world_from_object"});
    instance.motion.push_back({step["time_s"].number(), read_pose(step["world_from_object"])});
  }
  return instance;
}

/// Triangles of a part follow each other: a part and how many, and the next.
Json part_runs(const ObjectModel& model) {
  Json runs = Json::array();
  const auto& parts = model.triangle_part;
  for (std::size_t i = 0; i < parts.size();) {
    std::size_t end = i;
    while (end < parts.size() && parts[end] == parts[i]) ++end;
    runs.push_back(parts[i]);
    runs.push_back(end - i);
    i = end;
  }
  return runs;
}

/// @param left  triangles that the file may still have: few numbers could stand for any memory
std::vector<std::uint16_t> read_part_runs(const JsonNode& runs, std::size_t part_count,
                                          std::size_t& left) {
  std::vector<std::uint16_t> parts;
  const std::size_t count = runs.size(kMaxTriangles);
  if (count % 2 != 0) runs.fail("is not pairs of a part and a count");
  for (std::size_t i = 0; i < count; i += 2) {
    const auto part = static_cast<std::uint16_t>(runs[i].integer(0, 65534));
    if (part >= part_count) runs[i].fail("is not an index into part_names");
    const auto run =
        static_cast<std::size_t>(runs[i + 1].integer(0, static_cast<std::int64_t>(left)));
    parts.insert(parts.end(), run, part);
    left -= run;
  }
  return parts;
}

Json json_of(const ObjectModel& model, std::size_t index) {
  return {{"name", model.name},
          {"mesh", mesh_file(index)},
          {"part_names", model.part_names},
          {"part_runs", part_runs(model)}};
}

ObjectModel read_model(const JsonNode& node, std::vector<std::string>& mesh_files,
                       std::size_t& triangles_left) {
  node.expect_keys({"name", "mesh", "part_names", "part_runs"});
  ObjectModel model;
  model.name = node["name"].text();
  mesh_files.push_back(node["mesh"].text());
  for (const JsonNode& part : node["part_names"].elements(65535))
    model.part_names.push_back(part.text());
  model.triangle_part = read_part_runs(node["part_runs"], model.part_names.size(), triangles_left);
  return model;
}

Json json_of(const std::vector<TrueView>& views) {
  Json list = Json::array();
  std::set<int> frames;
  for (const TrueView& view : views) {
    if (view.frame < 0 || view.frame > 999'999 || !frames.insert(view.frame).second) {
      throw std::invalid_argument("truth: view frame " + std::to_string(view.frame) +
                                  " is not unique in 0..999999");
    }
    list.push_back({{"frame", view.frame},
                    {"time_s", view.time_s},
                    {"camera", to_json(view.camera)},
                    {"camera_from_world", to_json(view.camera_from_world)},
                    {"camera_from_world_end", to_json(view.camera_from_world_end)},
                    {"exposure_s", view.exposure_s},
                    {"readout_s", view.readout_s},
                    {"aperture_radius_m", view.aperture_radius_m},
                    {"focus_m", std::isinf(view.focus_m) ? Json() : Json(view.focus_m)}});
  }
  return list;
}

std::vector<TrueView> read_views(const JsonNode& list) {
  std::vector<TrueView> views;
  std::set<int> frames;
  for (const JsonNode& node : list.elements(kMaxViews)) {
    node.expect_keys({"frame", "time_s", "camera", "camera_from_world", "camera_from_world_end"},
                     {"exposure_s", "readout_s", "aperture_radius_m", "focus_m"});
    TrueView view;
    view.frame = static_cast<int>(node["frame"].integer(0, 999'999));
    if (!frames.insert(view.frame).second) node["frame"].fail("is a frame that occurs twice");
    view.time_s = node["time_s"].number();
    view.camera = read_camera(node["camera"], "frame " + std::to_string(view.frame));
    view.camera_from_world = read_pose(node["camera_from_world"]);
    view.camera_from_world_end = read_pose(node["camera_from_world_end"]);
    const auto read = [&](const char* key, double& value) {
      if (node.has(key) && !node[key].is_null()) value = node[key].number(0);
    };
    read("exposure_s", view.exposure_s);
    read("readout_s", view.readout_s);
    read("aperture_radius_m", view.aperture_radius_m);
    read("focus_m", view.focus_m);
    views.push_back(view);
  }
  return views;
}

}  // namespace

std::vector<JsonNode> by_view(const JsonNode& root, const std::vector<TrueView>& views) {
  if (root.members(kMaxViews).size() != views.size())
    root.fail("does not have one entry for each frame of camera.json");
  std::vector<JsonNode> nodes;
  for (const TrueView& view : views) nodes.push_back(root[std::to_string(view.frame)]);
  return nodes;
}

// ---- camera.json --------------------------------------------------------------------------------

std::string views_to_json(const std::vector<TrueView>& views,
                          const std::vector<SensorViews>& others) {
  Json root = Json{{"views", json_of(views)}};
  for (const SensorViews& other : others) {
    if (other.views.size() != views.size()) {
      throw std::invalid_argument("truth: sensor \"" + other.sensor + "\" has " +
                                  std::to_string(other.views.size()) + " views; the first has " +
                                  std::to_string(views.size()));
    }
    root["other_sensors"].push_back({{"sensor", other.sensor}, {"views", json_of(other.views)}});
  }
  return to_text(root);
}

std::vector<TrueView> views_from_json(std::string_view text, const std::string& name,
                                      std::vector<SensorViews>& others) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"views"}, {"other_sensors"});
  const std::vector<TrueView> views = read_views(root["views"]);
  others.clear();
  if (!root.has("other_sensors")) return views;
  for (const JsonNode& node : root["other_sensors"].elements(kMaxSensors)) {
    node.expect_keys({"sensor", "views"});
    others.push_back({node["sensor"].text(64), read_views(node["views"])});
    bool same = others.back().views.size() == views.size();
    for (std::size_t i = 0; same && i < views.size(); ++i)
      same = others.back().views[i].frame == views[i].frame;
    if (!same) node["views"].fail("are not of the frames of the first sensor");
  }
  return views;
}

// ---- shared_plants.json -------------------------------------------------------------------------

std::string shared_plants_to_json(const std::vector<std::string>& plants) {
  return to_text(Json{{"shared_plants", plants}});
}

std::vector<std::string> shared_plants_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  document.root().expect_keys({"shared_plants"});
  std::vector<std::string> plants;
  for (const JsonNode& plant : document.root()["shared_plants"].elements(kMaxInstances))
    plants.push_back(plant.text());
  return plants;
}

// ---- scene.json ---------------------------------------------------------------------------------

std::string mesh_file(std::size_t model) {
  return "models/obj_" + six_digits(static_cast<std::int64_t>(model) + 1) + ".ply";
}

std::string scene_to_json(const Scene& scene) {
  Json models = Json::array(), materials = Json::array(), instances = Json::array(),
       lights = Json::array();
  Json views = Json::array();
  for (std::size_t i = 0; i < scene.models.size(); ++i)
    models.push_back(json_of(scene.models[i], i));
  for (const Material& material : scene.materials) materials.push_back(to_json(material));
  for (const Instance& instance : scene.instances) instances.push_back(json_of(instance));
  for (std::size_t i = 0; i < scene.lights.size(); ++i)
    lights.push_back(to_json(scene.lights[i], i));
  for (const View& view : scene.views) {
    views.push_back({{"time_s", view.time_s},
                     {"rig_from_world", to_json(view.rig_from_world)},
                     {"rig_from_world_end", to_json(view.rig_from_world_end)}});
    if (view.focus_in_world_m != Eigen::Vector3d::Zero())
      views.back()["focus_in_world_m"] = to_json(view.focus_in_world_m);
  }
  return to_text(Json{{"name", scene.name},
                      {"rig", scene.rig},
                      {"board", scene.board},
                      {"models", models},
                      {"materials", materials},
                      {"instances", instances},
                      {"lights", lights},
                      {"views", views}});
}

Scene scene_from_json(std::string_view text, const std::string& name, SceneFiles& files) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"name", "rig", "board", "models", "materials", "instances", "lights", "views"});
  Scene scene;
  scene.name = root["name"].text();
  scene.rig = root["rig"].text();
  scene.board = root["board"].text();
  std::size_t triangles_left = kMaxTriangles;
  for (const JsonNode& node : root["models"].elements(kMaxInstances))
    scene.models.push_back(read_model(node, files.meshes, triangles_left));
  for (const JsonNode& node : root["materials"].elements(kMaxInstances))
    scene.materials.push_back(read_material(node));
  for (const JsonNode& node : root["instances"].elements(kMaxInstances))
    scene.instances.push_back(read_instance(node));
  for (const JsonNode& node : root["lights"].elements(10'000))
    scene.lights.push_back(read_light(node, scene.lights.size(), files.environments));
  for (const JsonNode& node : root["views"].elements(kMaxViews)) {
    node.expect_keys({"time_s", "rig_from_world", "rig_from_world_end"}, {"focus_in_world_m"});
    View& view = scene.views.emplace_back();
    view.time_s = node["time_s"].number();
    view.rig_from_world = read_pose(node["rig_from_world"]);
    view.rig_from_world_end = read_pose(node["rig_from_world_end"]);
    if (node.has("focus_in_world_m")) view.focus_in_world_m = node["focus_in_world_m"].vector<3>();
  }
  return scene;
}

// ---- traits.json
// -----------------------------------------------------------------------------------

namespace {

/// Whole and seen leaf area of each specimen, over some views together.
Json leaf_areas_json(const std::vector<const TruthImages*>& images) {
  Json entries = Json::array();
  for (std::size_t k = 0; k < images.front()->leaf_areas.size(); ++k) {
    std::vector<const LeafAreaView*> views;
    for (const TruthImages* image : images) {
      if (image->leaf_areas.size() != images.front()->leaf_areas.size())
        throw std::invalid_argument("truth: not all views have the leaf areas of all specimens");
      views.push_back(&image->leaf_areas[k]);
    }
    const Json whole = {{"name", "leaf_area"}, {"unit", "m2"}, {"value", views.front()->whole_m2}};
    const Json seen = {
        {"name", "visible_leaf_area"}, {"unit", "m2"}, {"value", seen_area_m2(views)}};
    entries.push_back({{"instance", views.front()->instance}, {"traits", {whole, seen}}});
  }
  return entries;
}

}  // namespace

std::string true_traits_to_json(const Scene& scene, const std::vector<TrueView>& views,
                                const std::vector<TruthImages>& images) {
  Json instances = Json::array();
  for (const Instance& instance : scene.instances) {
    if (instance.traits.empty()) continue;
    Json traits = Json::array();
    for (const TrueTrait& trait : instance.traits) {
      traits.push_back({{"name", trait.name}, {"unit", trait.unit}, {"value", trait.value}});
    }
    instances.push_back({{"instance", instance.id}, {"traits", traits}});
  }
  Json root = Json::object();
  root["instances"] = instances;
  std::vector<const TruthImages*> all;
  for (const TruthImages& image : images) all.push_back(&image);
  if (all.empty() || all.front()->leaf_areas.empty()) return to_text(root);
  root["views"] = leaf_areas_json(all);
  for (std::size_t i = 0; i < images.size(); ++i)
    root["frames"][std::to_string(views[i].frame)] = leaf_areas_json({all[i]});
  return to_text(root);
}

void true_traits_from_json(std::string_view text, const std::string& name, Scene& scene) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"instances"}, {"views", "frames"});
  std::map<int, Instance*> by_id;
  for (Instance& instance : scene.instances) by_id[instance.id] = &instance;
  for (const JsonNode& node : root["instances"].elements(kMaxInstances)) {
    node.expect_keys({"instance", "traits"});
    const auto found = by_id.find(static_cast<int>(node["instance"].integer(0, kMaxId)));
    if (found == by_id.end()) node["instance"].fail("is not an instance of the scene");
    if (!found->second->traits.empty()) node["instance"].fail("is an instance that occurs twice");
    for (const JsonNode& entry : node["traits"].elements(1000)) {
      entry.expect_keys({"name", "unit", "value"});
      found->second->traits.push_back(
          {entry["name"].text(), entry["unit"].text(), entry["value"].number()});
    }
  }
}

// ---- scene_gt.json, scene_gt_info.json ----------------------------------------------------------

std::string scene_gt_to_json(const Scene& scene, const std::vector<TrueView>& views) {
  const std::vector<const Instance*> order = specimens_of(scene);
  Json root = Json::object();
  for (const TrueView& view : views) {
    Json entries = Json::array();
    for (const Instance* instance : order) {
      const Pose camera_from_object =
          view.camera_from_world * world_from_object(*instance, view.time_s);
      entries.push_back({{"cam_R_m2c", to_json(camera_from_object.rotation.toRotationMatrix())},
                         {"cam_t_m2c", to_json(1000 * camera_from_object.translation_m)},
                         {"obj_id", instance->model + 1},
                         {"instance_id", instance->id}});
    }
    root[std::to_string(view.frame)] = entries;
  }
  return to_text(root);
}

std::string scene_gt_info_to_json(const std::vector<TrueView>& views,
                                  const std::vector<TruthImages>& images) {
  Json root = Json::object();
  for (std::size_t i = 0; i < views.size(); ++i) {
    Json entries = Json::array();
    for (const InstanceVisibility& v : images[i].visibility) {
      Json seen = {v.seen_x, v.seen_y, v.seen_width, v.seen_height};
      if (v.seen_width == 0) seen = {-1, -1, -1, -1};  // BOP's way
      entries.push_back({{"bbox_obj", {v.box_x, v.box_y, v.box_width, v.box_height}},
                         {"bbox_visib", seen},
                         {"px_count_all", v.pixels_full},
                         {"px_count_visib", v.pixels_visible},
                         {"visib_fract", v.visible_fraction},
                         {"instance_id", v.instance}});
    }
    root[std::to_string(views[i].frame)] = entries;
  }
  return to_text(root);
}

void scene_gt_info_from_json(std::string_view text, const std::string& name,
                             const std::vector<TrueView>& views, std::vector<TruthImages>& images) {
  const JsonDocument document(text, name);
  const std::vector<JsonNode> nodes = by_view(document.root(), views);
  constexpr std::int64_t kMaxPixels = std::int64_t{1} << 40;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const JsonNode& node : nodes[i].elements(kMaxInstances)) {
      node.expect_keys({"bbox_obj", "px_count_all", "px_count_visib", "visib_fract", "instance_id"},
                       {"bbox_visib"});
      InstanceVisibility v;
      const auto box = [&](const char* key, int& x, int& y, int& width, int& height) {
        if (node[key].size(4) != 4) node[key].fail("does not have 4 integers");
        std::size_t at = 0;
        for (int* value : {&x, &y, &width, &height})
          *value = static_cast<int>(node[key][at++].integer(-kMaxId, kMaxId));
      };
      box("bbox_obj", v.box_x, v.box_y, v.box_width, v.box_height);
      if (node.has("bbox_visib"))
        box("bbox_visib", v.seen_x, v.seen_y, v.seen_width, v.seen_height);
      if (v.seen_width < 0) v.seen_x = v.seen_y = v.seen_width = v.seen_height = 0;
      v.pixels_full = node["px_count_all"].integer(0, kMaxPixels);
      v.pixels_visible = node["px_count_visib"].integer(0, kMaxPixels);
      v.visible_fraction = node["visib_fract"].number(0, 1);
      v.instance = static_cast<int>(node["instance_id"].integer(0, kMaxId));
      images[i].visibility.push_back(v);
    }
  }
}

}  // namespace cousin
