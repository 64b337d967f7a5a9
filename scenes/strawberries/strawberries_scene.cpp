#include "scenes/strawberries/strawberries_scene.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "sim/physics/penetration.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

std::string numbered(const char* kind, std::size_t number) {
  char name[40];
  std::snprintf(name, sizeof name, "%s %02d", kind, static_cast<int>(number));
  return name;
}

/// A hanging fruit as what plants keep off.
struct HangingFruit {
  ConvexBody hull;
  Pose fruit_from_world;
  Vector3d centre_m;
  double radius_m = 0;

  HangingFruit(const Mesh& mesh, const Pose& world_from_fruit)
      : hull(mesh),
        fruit_from_world(inverse(world_from_fruit)),
        centre_m(world_from_fruit.translation_m) {
    for (const Vector3d& p : mesh.vertices_m) radius_m = std::max(radius_m, p.norm());
  }
  /// Negative outside: at most the distance, or minus `far_m` beyond it.
  double depth_m(const Vector3d& in_world_m, double far_m) const {
    if ((in_world_m - centre_m).norm() > radius_m + far_m) return -far_m;
    return std::max(-far_m, hull.depth_m(fruit_from_world * in_world_m, -far_m));
  }
};

std::vector<HangingFruit> hanging_fruits(const std::vector<Truss>& trusses) {
  std::vector<HangingFruit> fruits;
  for (const Truss& truss : trusses) {
    for (std::size_t i = 0; i < truss.fruits.size(); ++i)
      fruits.emplace_back(truss.fruits[i].hull, truss.world_from_fruit[i]);
  }
  return fruits;
}

/// Whether no vertex of a part, moved by `at_m`, comes near a fruit or into the bed.
bool keeps_off(const Mesh& part, const Vector3d& at_m, const std::vector<HangingFruit>& fruits,
               const BendingObstacle& bed, double clear_m) {
  for (const Vector3d& vertex : part.vertices_m) {
    const Vector3d p = vertex + at_m;
    if (depth_m(bed, p) > 0) return false;
    for (const HangingFruit& fruit : fruits) {
      if (fruit.depth_m(p, 2 * clear_m) > -clear_m) return false;
    }
  }
  return true;
}

Instance plant_instance(const PlantModel& model, int model_index, int first_material,
                        const Vector3d& at_m) {
  Instance instance;
  instance.category = "strawberry plant";
  instance.model = model_index;
  instance.material = first_material + kBerryLeafletLook;
  for (const int look : model.part_looks) instance.part_materials.push_back(first_material + look);
  instance.world_from_object.translation_m = at_m;
  return instance;
}

void add_instance(Scene& scene, Instance instance, const std::string& name) {
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = name;
  scene.instances.push_back(std::move(instance));
}

/// Plants of the near row, each its own and off the fruits; then variants of them in the far row
/// and on the beds behind.
void add_plants(Scene& scene, const StrawberriesSceneConfig& config,
                const std::vector<HangingFruit>& fruits, const BendingObstacle& bed,
                const std::vector<Vector3d>& near_m, const std::vector<Vector3d>& far_m,
                const Rng& rng) {
  const int first_material = static_cast<int>(scene.materials.size());
  for (Material& material : strawberry_materials(config.plant))
    scene.materials.push_back(std::move(material));
  const std::size_t own = near_m.size();
  const auto variants = static_cast<std::size_t>(config.bed.row.variants);
  std::vector<PlantModel> models(own + variants);
  tbb::parallel_for(std::size_t{0}, models.size(), [&](std::size_t i) {
    const Vector3d at_m = i < own ? near_m[i] : far_m.front();
    const std::vector<HangingFruit> none;
    const IsFree is_free = [&](const Mesh& part) {
      return keeps_off(part, at_m, i < own ? fruits : none, bed, config.plant.surface.clear_m);
    };
    models[i] =
        plant_model(grow_strawberry_plant(config.plant, is_free, rng.fork("plant").fork(i)));
  });
  const int first_model = static_cast<int>(scene.models.size());
  const auto model_index = [&](std::size_t i) { return first_model + static_cast<int>(i); };
  for (const PlantModel& model : models) scene.models.push_back(model.model);
  for (std::size_t i = 0; i < own; ++i) {
    add_instance(scene, plant_instance(models[i], model_index(i), first_material, near_m[i]),
                 numbered("plant", i));
  }
  // Behind the path's side of their own bed they face its other side.
  std::size_t count = 0;
  const auto behind = [&](const Vector3d& at_m, bool turned) {
    const std::size_t v = own + count % variants;
    Instance instance = plant_instance(models[v], model_index(v), first_material, at_m);
    if (turned) {
      instance.world_from_object.rotation = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitZ());
    }
    add_instance(scene, std::move(instance), numbered("far plant", count++));
  };
  for (const Vector3d& at_m : far_m) behind(at_m, true);
  for (int b = 1; b <= config.bed.path.beds; ++b) {
    const Vector3d by_m(-b * config.bed.path.pitch_m, 0, 0);
    for (const Vector3d& at_m : near_m) behind(at_m + by_m, false);
    for (const Vector3d& at_m : far_m) behind(at_m + by_m, true);
  }
}

/// A truss's stalks as one plant: an organ a stalk, bent as they hang.
Plant stalks_of(const Truss& truss, int sides) {
  Plant plant;
  plant.name = "truss";
  const BendingPlant& bending = truss.plant;
  std::vector<bool> bears(bending.stems.size(), false);
  for (const BendingLoad& load : bending.loads) bears[static_cast<std::size_t>(load.stem)] = true;
  for (std::size_t s = 0; s < bending.stems.size(); ++s) {
    const BendingStem& stem = bending.stems[s];
    const char* kind = stem.parent < 0 ? "peduncle" : (bears[s] ? "pedicel" : "branch");
    Organ& organ = add_organ(plant, OrganKind::petiole, numbered(kind, s), stem.parent, 0);
    organ.look = kBerryStalkLook;
    const int steps = 4 * stem.segments;
    for (int i = 0; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      organ.line.points_m.push_back(
          bend_m(bending, truss.sag.bent, static_cast<int>(s), share, point_at_m(stem, share)));
      // Swollen where it forks.
      const double swell = bears[s] ? 0 : 0.35 * std::exp(-std::pow((1 - share) / 0.03, 2));
      organ.line.radii_m.push_back((1 + swell) * radius_at_m(stem, share));
    }
    organ.surface = tube_surface(organ.line, sides);
  }
  return plant;
}

void add_fruit(Scene& scene, const StrawberriesSceneConfig& config, const FruitModel& fruit,
               const Pose& at, std::size_t number) {
  Instance flesh;
  flesh.is_specimen = true;
  flesh.mass_kg = fruit.mass_kg;
  flesh.traits = fruit.traits;
  const int maturity = maturity_of(trait(fruit, "red_share"));
  flesh.traits.push_back({"maturity", "1", static_cast<double>(maturity)});
  const Vector3d axis = at.rotation * Vector3d::UnitZ();
  constexpr std::array<const char*, 3> kAxes = {"axis_x", "axis_y", "axis_z"};
  for (int k = 0; k < 3; ++k)
    flesh.traits.push_back({kAxes[static_cast<std::size_t>(k)], "1", axis[k]});
  constexpr std::array<const char*, 3> kMaturities = {"low", "medium", "high"};
  flesh.category = config.category == "maturity" ? kMaturities[static_cast<std::size_t>(maturity)]
                                                 : fruit.flesh.model.name;
  const auto add = [&](Instance instance, const FruitPart& part, const std::string& name) {
    instance.model = static_cast<int>(scene.models.size());
    instance.material = static_cast<int>(scene.materials.size());
    instance.world_from_object = at;
    scene.models.push_back(part.model);
    scene.materials.push_back(part.material);
    add_instance(scene, std::move(instance), name);
  };
  add(std::move(flesh), fruit.flesh, numbered("fruit", number));
  Instance calyx;
  calyx.category = "calyx";
  add(std::move(calyx), fruit.calyx, numbered("calyx", number));
}

void add_trusses(Scene& scene, const StrawberriesSceneConfig& config,
                 const std::vector<Truss>& trusses) {
  std::size_t number = 0;
  const auto stalk = static_cast<int>(scene.materials.size());
  Material green = strawberry_materials(config.plant)[kBerryStalkLook];
  green.albedo = to_rgb(color_vector(config.plant.leaf.petiole_albedo));  // no runner's red
  scene.materials.push_back(std::move(green));
  for (std::size_t t = 0; t < trusses.size(); ++t) {
    const PlantModel stalks = plant_model(stalks_of(trusses[t], config.plant.surface.sides + 2));
    Instance instance;
    instance.category = "truss";
    instance.model = static_cast<int>(scene.models.size());
    instance.material = stalk;
    scene.models.push_back(stalks.model);
    add_instance(scene, std::move(instance), numbered("truss", t));
    for (std::size_t i = 0; i < trusses[t].fruits.size(); ++i)
      add_fruit(scene, config, trusses[t].fruits[i], trusses[t].world_from_fruit[i], number++);
  }
}

/// @throws std::invalid_argument naming view and fruit.
void check_eyes(const std::vector<View>& views, const std::vector<HangingFruit>& fruits,
                const BendingObstacle& bed) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Vector3d eye_m = centre_in_world_m(views[v].rig_from_world);
    const std::string view = "strawberries: view " + std::to_string(v) + ": the camera is inside ";
    if (depth_m(bed, eye_m) > 0) throw std::invalid_argument(view + "the bed");
    for (std::size_t i = 0; i < fruits.size(); ++i) {
      if (fruits[i].depth_m(eye_m, 0.01) > -0.005)
        throw std::invalid_argument(view + "fruit " + std::to_string(i) +
                                    " or within 5 mm of it; raise distance_min_m");
    }
  }
}

}  // namespace

Scene build_strawberries_scene(const StrawberriesSceneConfig& config, const StandRest& rest,
                               const Rng& plant_rng, const Rng& rng) {
  validate(config);
  const Rng stand_rng = attempt_rng(plant_rng, rest.attempt);
  const Stand stand = draw_stand(config.stand, config.bed, stand_rng);
  std::optional<Ripening> ripening;
  if (config.ripens) ripening = Ripening{0, rng.fork("ripening")};
  std::vector<Truss> trusses = grow_trusses(stand, stand_rng, ripening);
  hang(trusses, rest.sag);
  const std::vector<HangingFruit> fruits = hanging_fruits(trusses);
  Vector3d middle_m = Vector3d::Zero();
  for (const HangingFruit& fruit : fruits)
    middle_m += fruit.centre_m / static_cast<double>(fruits.size());

  Scene scene;
  scene.name = "strawberries";
  scene.rig = config.rig;
  scene.views = strawberry_views(config, middle_m, rng.fork("views"));
  const BendingObstacle& bed = trusses.front().plant.obstacles.front();
  check_eyes(scene.views, fruits, bed);
  std::vector<Vector3d> near_m, far_m, crowns_m;
  for (int k = 0; k < config.bed.row.plants; ++k) {
    near_m.push_back(crown_in_world_m(config.bed, k, true, stand_rng));
    far_m.push_back(crown_in_world_m(config.bed, k, false, stand_rng));
  }
  crowns_m = near_m;
  crowns_m.insert(crowns_m.end(), far_m.begin(), far_m.end());
  add_strawberry_bed(scene, config.bed, crowns_m, plant_rng.fork("bed"));
  add_trusses(scene, config, trusses);
  add_plants(scene, config, fruits, bed, near_m, far_m, plant_rng.fork("plants"));
  std::string light = config.light;
  if (light == "drawn") {
    Rng draw = rng.fork("which light");
    const std::vector<std::string> lights = strawberry_lights();
    light = lights[uniform_index(draw, lights.size())];
  }
  const View& first = scene.views[scene.views.size() / 2];
  add_strawberry_light(scene, config.bed, light, centre_in_world_m(first.rig_from_world), middle_m,
                       rng.fork("light"));
  validate(scene);
  return scene;
}

double plants_in_fruits_m(const Scene& scene) {
  constexpr double kFar_m = 0.01;
  constexpr int kCells = 4;  // of a triangle's edge
  std::vector<HangingFruit> fruits;
  for (const Instance& instance : scene.instances) {
    if (!instance.is_specimen) continue;
    fruits.emplace_back(contact_hull(scene.models[static_cast<std::size_t>(instance.model)].mesh),
                        instance.world_from_object);
  }
  double deepest = -kFar_m;
  for (const Instance& instance : scene.instances) {
    if (instance.category != "strawberry plant") continue;
    const Mesh mesh = mesh_in_world(scene, instance);
    for (const auto& t : mesh.triangles) {
      const Vector3d& a = mesh.vertices_m[t[0]];
      const Vector3d u = mesh.vertices_m[t[1]] - a, v = mesh.vertices_m[t[2]] - a;
      const double reach_m = std::max(u.norm(), v.norm());
      for (const HangingFruit& fruit : fruits) {
        if ((a - fruit.centre_m).norm() > fruit.radius_m + reach_m + kFar_m) continue;
        for (int i = 0; i <= kCells; ++i) {
          for (int j = 0; i + j <= kCells; ++j) {
            const Vector3d p =
                a + (static_cast<double>(i) / kCells) * u + (static_cast<double>(j) / kCells) * v;
            deepest = std::max(deepest, fruit.depth_m(p, kFar_m));
          }
        }
      }
    }
  }
  return deepest;
}

}  // namespace cousin
