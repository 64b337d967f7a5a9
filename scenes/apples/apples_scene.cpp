#include "scenes/apples/apples_scene.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "scenes/apples/apple.h"
#include "scenes/apples/apple_views.h"
#include "scenes/apples/neighbours.h"
#include "scenes/apples/orchard_ground.h"
#include "scenes/apples/tree_wind.h"
#include "sim/config/limits.h"
#include "sim/physics/rigid_sway.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
constexpr double kNearest_m = 0.07;  // no fruit is larger from its centre

void add_light(Scene& scene, const OrchardConfig& c, const std::string& light) {
  ClearSky sky;
  // The photographer stands on the side of -y.
  double azimuth = 0;
  if (light == "front") {
    azimuth = -0.5 * kPi + 0.45;
  } else if (light == "back") {
    azimuth = 0.5 * kPi - 0.45;
  } else if (light == "side" || light == "shade") {
    azimuth = 0.1;
  } else {
    throw std::invalid_argument("light \"" + light + "\" is not one of front, back, side, shade");
  }
  const double e = c.light.elevation_rad;
  sky.to_sun = {std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e)};
  sky.turbidity = c.light.turbidity;
  sky.scale = c.light.scale;
  sky.has_sun = light != "shade";
  sky.ground_albedo =
      to_rgb(Vector3d(0.5 * (color_vector(c.ground.soil) + color_vector(c.ground.grass))));
  scene.lights.emplace_back(sky);
}

double leaf_area_of(const PlantModel& leaf) {
  double sum = 0;
  const Mesh& mesh = leaf.model.mesh;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (leaf.part_looks[leaf.model.triangle_part[i]] != kAppleBladeLook) continue;
    const auto& t = mesh.triangles[i];
    const Vector3d& a = mesh.vertices_m[t[0]];
    sum += 0.5 * (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm();
  }
  return sum;
}

std::vector<TrueTrait> tree_traits(const GrownTree& grown, const OrchardConfig& c) {
  const TreeRest& rest = grown.tree.rest;
  double area_m2 = 0, mass_kg = 0;
  for (const LeafPlace& leaf : grown.tree.leaves)
    area_m2 += leaf_area_of(grown.leaves[static_cast<std::size_t>(leaf.variant)]);
  for (const FruitPlace& fruit : grown.tree.fruits) mass_kg += fruit.mass_kg;
  return {{"height", "m", height_m(grown.tree)},
          {"leaf_count", "1", static_cast<double>(grown.tree.leaves.size())},
          {"leaf_area", "m2", area_m2},
          {"fruit_count", "1", static_cast<double>(grown.tree.fruits.size())},
          {"fruit_mass", "kg", mass_kg},
          {"place_along", "m", c.tree.spacing_m},
          {"place_across", "m", c.tree.row_m},
          {"fruits_thinned", "1", static_cast<double>(rest.thinned)},
          {"is_bent", "1", rest.is_bent ? 1.0 : 0.0},
          {"branches_not_at_rest", "1", static_cast<double>(rest.not_at_rest)},
          {"branch_sag", "m", rest.sag_m}};
}

/// Fruits of neighbours are specimens where a view may show them: the truth of hundreds that none
/// does would be files without a pixel.
void forget_unseen(Scene& scene, const ApplesSceneConfig& config,
                   const std::vector<std::size_t>& own) {
  const Camera& camera = config.eye.camera;
  const double reach = std::hypot(camera.width_px / camera.fx_px, camera.height_px / camera.fy_px);
  for (std::size_t i = own.empty() ? 0 : own.back() + 1; i < scene.instances.size(); ++i) {
    Instance& instance = scene.instances[i];
    if (!instance.is_specimen) continue;
    instance.is_specimen =
        std::any_of(scene.views.begin(), scene.views.end(), [&](const View& view) {
          const Vector3d at = config.eye.eye_from_rig * view.rig_from_world *
                              instance.world_from_object.translation_m;
          // Half the image's diagonal, a third more for lenses that see wider, and the fruit's
          // radius.
          return at.z() > -0.1 && at.head<2>().norm() < 0.67 * reach * std::max(at.z(), 0.0) + 0.1;
        });
  }
}

Fields fields(BranchPush& c) {
  return {{"force_n", &c.force_n, "a hand's largest push of a branch; 0: none", 0, 200},
          {"branch", &c.branch, "that it pushes, from the lowest, 0", 0, 1000},
          {"share", &c.share, "where, of its length", 0.1, 1},
          {"azimuth_rad", &c.azimuth_rad, "where it pushes to, from +x to +y", -7, 7},
          {"elevation_rad", &c.elevation_rad, "and up", -1.5708, 1.5708},
          {"view", &c.view, "at whose time it pushes most", 0, 9999},
          {"seconds", &c.seconds, "from touch to letting go", 0.05, 10}};
}

}  // namespace

Fields fields(ApplesSceneConfig& c) {
  constexpr double kFar_m = 5;
  return Fields{{"fruits", &c.fruits, "on the tree", 1, 2000},
                {"heavier", &c.heavier, "times the fruits' masses: what stalks hold", 0.01, 1000},
                {"family", &c.family, "of the fruits' shapes: botanical or harmonics"},
                {"elongation", &c.elongation, "times the ratio of the fruits' length to width", 0.4,
                 2.5},
                {"sag", &c.sag, "branches bend under their fruits"},
                {"neighbours", &c.neighbours, "trees of the row whose fruits are specimens too", 0,
                 20},
                {"trees", &c.trees, "a row", 1, 101},
                {"rows", &c.rows, "of the orchard", 1, 25},
                {"light", &c.light, "sun at the front, back or side, or shade"},
                {"views", &c.views, "each of a fruit of its own, or of the tree", 1, 10000},
                {"look", &c.look, "up, level, down or any at a fruit; tree: at the whole tree"},
                {"distance_min_m", &c.distance_min_m, "of the camera from the fruit's centre", 0,
                 kFar_m},
                {"distance_max_m", &c.distance_max_m, "of the camera from the fruit's centre", 0,
                 kFar_m},
                {"occlusion", &c.occlusion, "hidden share of the target; negative: as it comes", -1,
                 1},
                {"turns_leaves", &c.turns_leaves, "where no camera meets it, leaves are turned"},
                {"unmet", &c.unmet, "what becomes of a view that misses it: state or refuse"},
                {"rig", &c.rig, "sensor preset"}} +
         scene_wind_fields(c.wind) + nested("push", fields(c.push)) +
         nested("orchard", fields(c.orchard)) + nested("fuji", fields(c.fuji));
}

void validate(const ApplesSceneConfig& config) {
  ApplesSceneConfig copy = config;
  if (config.distance_min_m < kNearest_m) {
    throw std::invalid_argument("apples: distance_min_m " + std::to_string(config.distance_min_m) +
                                " puts the camera inside a fruit; it must be at least " +
                                std::to_string(kNearest_m));
  }
  check_limits(fields(copy), "apples");
  validate(config.orchard);
  validate(config.fuji);
  validate(config.wind);
  fruit_family(config.family);
  if (config.distance_min_m > config.distance_max_m) {
    throw std::invalid_argument("distance_min_m " + std::to_string(config.distance_min_m) +
                                " is above distance_max_m " +
                                std::to_string(config.distance_max_m));
  }
  const auto one_of = [](const char* key, const std::string& value,
                         const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names) {
      if (name == value) return;
      list += (list.empty() ? "" : ", ") + name;
    }
    throw std::invalid_argument(std::string(key) + " \"" + value + "\" is not one of " + list);
  };
  one_of("look", config.look, {"up", "level", "down", "any", "tree"});
  if (config.look == "tree" && config.occlusion >= 0)
    throw std::invalid_argument("occlusion " + std::to_string(config.occlusion) +
                                " is of a view's target, and with look = tree there is none");
  one_of("unmet", config.unmet, {"state", "refuse"});
  Scene scene;
  add_light(scene, config.orchard, config.light);  // throws, naming those that exist
}

GrownTree grow_scene_tree(const ApplesSceneConfig& config, const Rng& rng,
                          const BranchSettler& settle) {
  const OrchardConfig& c = config.orchard;
  GrownTree grown;
  grown.leaves.resize(static_cast<std::size_t>(c.leaf.variants));
  grown.fruits.resize(static_cast<std::size_t>(std::min(c.fruit.variants, config.fruits)));
  tbb::parallel_for(std::size_t{0}, grown.leaves.size(), [&](std::size_t i) {
    grown.leaves[i] = apple_leaf(c, 1, rng.fork("leaf").fork(i));
  });
  tbb::parallel_for(std::size_t{0}, grown.fruits.size(), [&](std::size_t i) {
    AppleConfig fruit;
    fruit.grid = c.fruit.grid;
    fruit.family = fruit_family(config.family);
    fruit.elongation = config.elongation;
    grown.fruits[i] = make_apple(fruit, config.fuji, rng.fork("fruit").fork(i));
  });
  grown.tree = grow_apple_tree(c, c.leaf.variants, rng.fork("tree"));
  bear_fruits(grown.tree, c, grown.fruits, config.fruits, config.heavier, rng.fork("bear"));
  hang_fruits(grown.tree, c, grown.fruits, config.sag, settle);
  clear_leaves(grown.tree, grown.fruits, grown.leaves);
  std::vector<PlantModel> coarse(grown.leaves.size());
  tbb::parallel_for(std::size_t{0}, coarse.size(),
                    [&](std::size_t i) { coarse[i] = apple_leaf(c, 0, rng.fork("leaf").fork(i)); });
  part_leaves(grown.tree, grown.fruits, grown.leaves, coarse);
  return grown;
}

Scene build_apples_scene(const ApplesSceneConfig& config, Rng rng, const BranchSettler& settle) {
  validate(config);
  const OrchardConfig& c = config.orchard;
  Scene scene;
  scene.name = "apples";
  scene.rig = config.rig;
  add_light(scene, c, config.light);
  for (Material& material : orchard_materials(c)) scene.materials.push_back(std::move(material));
  GrownTree grown = grow_scene_tree(config, rng.fork("tree"), settle);
  PlantModel wood = tree_wood(grown.tree, c, 1, rng.fork("bark"));
  scene.models.push_back(std::move(wood.model));
  Instance& tree = add_instance(scene, "tree", "tree", 0, kAppleBarkLook, {});
  tree.part_materials = wood.part_looks;
  tree.traits = tree_traits(grown, c);
  const FruitModels models = add_fruit_models(scene, grown.fruits);
  const std::vector<std::size_t> apples =
      add_fruits(scene, "", grown.tree, {}, config.fuji, grown.fruits, models);
  std::vector<int> leaf_models;
  for (PlantModel& leaf : grown.leaves) {
    leaf_models.push_back(static_cast<int>(scene.models.size()));
    scene.models.push_back(leaf.model);
  }
  const std::vector<int> leaf_parts = grown.leaves.front().part_looks;
  const std::size_t first_leaf = scene.instances.size();
  for (std::size_t i = 0; i < grown.tree.leaves.size(); ++i) {
    const LeafPlace& leaf = grown.tree.leaves[i];
    char name[24];
    std::snprintf(name, sizeof name, "leaf %04d", static_cast<int>(i));
    add_instance(scene, name, "leaf", leaf_models[static_cast<std::size_t>(leaf.variant)],
                 kAppleBladeLook, leaf.tree_from_leaf)
        .part_materials = leaf_parts;
  }
  add_orchard_ground(scene, c, leaf_models, leaf_parts, rng.fork("ground"));
  add_neighbours(scene, config, grown.fruits, models, 0, rng.fork("neighbours"));
  TurnableLeaves turnable{grown, first_leaf, LeafRoom(grown.tree, grown.fruits), {}};
  if (config.look == "tree")
    add_tree_views(scene, config, rng.fork("views"));
  else
    add_apple_views(scene, config, apples, turnable, 0, rng.fork("views"));
  forget_unseen(scene, config, apples);
  sway_tree(scene, config, grown, {0, apples, first_leaf}, rng.fork("sway"));
  validate(scene);
  return scene;
}

}  // namespace cousin
