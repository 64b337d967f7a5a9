#include "scenes/apples/neighbours.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "scenes/apples/orchard_ground.h"
#include "sim/geometry/cube_sphere.h"
#include "sim/geometry/smooth_normals.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

void append(ObjectModel& into, const ObjectModel& from, const Pose& pose, std::uint16_t part) {
  const auto first = static_cast<std::uint32_t>(into.mesh.vertices_m.size());
  for (const Vector3d& p : from.mesh.vertices_m) into.mesh.vertices_m.emplace_back(pose * p);
  for (const Eigen::Vector3f& n : from.vertex_normals)
    into.vertex_normals.emplace_back((pose.rotation * n.cast<double>()).cast<float>());
  into.vertex_albedo.insert(into.vertex_albedo.end(), from.vertex_albedo.begin(),
                            from.vertex_albedo.end());
  for (std::size_t i = 0; i < from.mesh.triangles.size(); ++i) {
    const auto& t = from.mesh.triangles[i];
    into.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    into.triangle_part.push_back(part);
  }
}

/// Wood and leaves of a tree as one model whose parts are the looks.
ObjectModel coarse_tree(const AppleTree& tree, const OrchardConfig& config,
                        const std::vector<PlantModel>& leaves, Rng rng) {
  ObjectModel model;
  model.name = "neighbour";
  model.part_names = {"bark", "shoots", "petioles", "leaves"};
  const PlantModel wood = tree_wood(tree, config, 0, rng);
  append(model, wood.model, {}, kAppleBarkLook);
  for (std::size_t i = 0; i < wood.model.triangle_part.size(); ++i)
    model.triangle_part[i] =
        static_cast<std::uint16_t>(wood.part_looks[wood.model.triangle_part[i]]);
  for (const LeafPlace& leaf : tree.leaves) {
    const PlantModel& own = leaves[static_cast<std::size_t>(leaf.variant)];
    const std::size_t first = model.triangle_part.size();
    append(model, own.model, leaf.tree_from_leaf, kAppleBladeLook);
    for (std::size_t i = 0; i < own.model.triangle_part.size(); ++i)
      model.triangle_part[first + i] =
          static_cast<std::uint16_t>(own.part_looks[own.model.triangle_part[i]]);
  }
  return model;
}

/// A fruit of few triangles: the vertices of the fine one that lie nearest to their directions.
ObjectModel coarse_fruit(const ObjectModel& fine) {
  ObjectModel coarse;
  coarse.mesh = cube_sphere(5);
  constexpr std::size_t kEvery = 5;
  std::vector<Vector3d> directions;
  for (std::size_t i = 0; i < fine.mesh.vertices_m.size(); i += kEvery)
    directions.push_back(fine.mesh.vertices_m[i].normalized());
  for (Vector3d& p : coarse.mesh.vertices_m) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < directions.size(); ++i) {
      if (directions[i].dot(p) > directions[nearest].dot(p)) nearest = i;
    }
    p = fine.mesh.vertices_m[nearest * kEvery];
    coarse.vertex_albedo.push_back(fine.vertex_albedo[nearest * kEvery]);
  }
  coarse.vertex_normals = smooth_normals(coarse.mesh);
  return coarse;
}

/// All fruits of a tree that is far away.
ObjectModel coarse_fruits(const AppleTree& tree, const std::vector<ObjectModel>& coarse) {
  ObjectModel model;
  model.name = "neighbour fruits";
  model.part_names = {"fruits"};
  for (const FruitPlace& place : tree.fruits)
    append(model, coarse[static_cast<std::size_t>(place.variant)], place.tree_from_fruit, 0);
  return model;
}

std::vector<PlantModel> coarse_leaves(const OrchardConfig& config, const Rng& rng) {
  std::vector<PlantModel> leaves;
  for (int i = 0; i < std::min(8, config.leaf.variants); ++i)
    leaves.push_back(apple_leaf(config, 0, rng.fork(static_cast<std::uint64_t>(i))));
  return leaves;
}

std::vector<TrueTrait> traits_of(const FruitModel& fruit, double mass_kg, const Pose& pose) {
  std::vector<TrueTrait> traits = fruit.traits;
  for (TrueTrait& trait : traits) {
    if (trait.name == "mass") trait.value = mass_kg;
  }
  const Vector3d axis = pose.rotation * Vector3d::UnitZ();
  traits.push_back({"axis_x", "1", axis.x()});
  traits.push_back({"axis_y", "1", axis.y()});
  traits.push_back({"axis_z", "1", axis.z()});
  return traits;
}

}  // namespace

FruitModels add_fruit_models(Scene& scene, const std::vector<FruitModel>& fruits) {
  const FruitModels first = {static_cast<int>(scene.models.size()),
                             static_cast<int>(scene.materials.size())};
  for (const FruitModel& fruit : fruits) {
    for (const FruitPart* part : {&fruit.flesh, &fruit.calyx, &fruit.stalk}) {
      scene.models.push_back(part->model);
      scene.materials.push_back(part->material);
    }
  }
  return first;
}

std::vector<std::size_t> add_fruits(Scene& scene, const std::string& prefix, const AppleTree& tree,
                                    const Pose& world_from_tree, const AppleCultivar& cultivar,
                                    const std::vector<FruitModel>& fruits,
                                    const FruitModels& models) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < tree.fruits.size(); ++i) {
    const FruitPlace& fruit = tree.fruits[i];
    const FruitModel& model = fruits[static_cast<std::size_t>(fruit.variant)];
    const Pose pose = world_from_tree * fruit.tree_from_fruit;
    char number[16];
    std::snprintf(number, sizeof number, " %03d", static_cast<int>(i));
    const int offset = 3 * fruit.variant;
    const auto add = [&](const char* name, int part) -> Instance& {
      return add_instance(scene, prefix + name + number, name, models.first_model + offset + part,
                          models.first_material + offset + part, pose);
    };
    Instance& flesh = add("apple", 0);
    flesh.is_specimen = true;
    set_labels(
        flesh, model.flesh.model.name,
        maturity_of(trait(model, "red_share"), cultivar.maturity_medium, cultivar.maturity_high));
    flesh.mass_kg = fruit.mass_kg;
    flesh.traits = traits_of(model, fruit.mass_kg, pose);
    places.push_back(scene.instances.size() - 1);
    add("calyx", 1);
    add("stalk", 2);
  }
  return places;
}

void add_neighbours(Scene& scene, const ApplesSceneConfig& config,
                    const std::vector<FruitModel>& fruits, const FruitModels& models,
                    int first_material, const Rng& rng) {
  const OrchardConfig& c = config.orchard;
  if (config.trees * config.rows <= 1) return;
  const std::vector<PlantModel> leaves = coarse_leaves(c, rng.fork("leaves"));
  std::vector<ObjectModel> coarse(fruits.size());
  tbb::parallel_for(std::size_t{0}, fruits.size(),
                    [&](std::size_t i) { coarse[i] = coarse_fruit(fruits[i].flesh.model); });
  struct Neighbour {
    AppleTree tree;
    ObjectModel whole, fruits;
  };
  std::vector<Neighbour> kinds(static_cast<std::size_t>(c.tree.variants));
  tbb::parallel_for(std::size_t{0}, kinds.size(), [&](std::size_t i) {
    const Rng own = rng.fork("tree").fork(i);
    Neighbour& one = kinds[i];
    one.tree = grow_apple_tree(c, static_cast<int>(leaves.size()), own.fork("wood"));
    bear_at_most(one.tree, c, fruits, config.fruits, 1, own.fork("fruits"));
    clear_leaves(one.tree, fruits, leaves);
    one.whole = coarse_tree(one.tree, c, leaves, own.fork("mesh"));
    one.fruits = coarse_fruits(one.tree, coarse);
  });
  const int first_model = static_cast<int>(scene.models.size());
  for (Neighbour& one : kinds) {
    scene.models.push_back(std::move(one.whole));
    scene.models.push_back(std::move(one.fruits));
  }
  Material skin;
  skin.name = "apples far away";
  skin.albedo = {1, 1, 1};
  skin.roughness = 0.4;
  scene.materials.push_back(skin);
  const int skin_material = static_cast<int>(scene.materials.size()) - 1;
  for (int row = 0; row < config.rows; ++row) {
    for (int k = 0; k < config.trees; ++k) {
      const int place = k - config.trees / 2, across = row - config.rows / 2;
      if (place == 0 && across == 0) continue;
      Rng own = rng.fork("place").fork(static_cast<std::uint64_t>(row * config.trees + k));
      const auto kind = static_cast<std::size_t>(uniform_index(own, kinds.size()));
      Pose pose;
      pose.translation_m = {place * c.tree.spacing_m + 0.03 * normal(own),
                            across * c.tree.row_m + 0.02 * normal(own), 0};
      pose.rotation = Eigen::AngleAxisd(uniform(own, 0, 2 * std::numbers::pi), Vector3d::UnitZ());
      const std::string name = "tree " + std::to_string(row * config.trees + k + 1);
      const int model = first_model + 2 * static_cast<int>(kind);
      std::vector<int> looks;
      for (int look = 0; look < 4; ++look) looks.push_back(first_material + look);
      add_instance(scene, name, "tree", model, first_material + kAppleBladeLook, pose)
          .part_materials = looks;
      const bool is_near = across == 0 && std::abs(place) <= (config.neighbours + 1) / 2;
      if (is_near) {
        add_fruits(scene, name + " ", kinds[kind].tree, pose, config.fuji, fruits, models);
      } else if (config.fruits > 0) {
        add_instance(scene, name + " fruits", "tree", model + 1, skin_material, pose);
      }
    }
  }
}

}  // namespace cousin
