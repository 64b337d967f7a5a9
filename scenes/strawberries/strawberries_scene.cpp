#include "scenes/strawberries/strawberries_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "scenes/strawberries/bed_outline.h"
#include "scenes/strawberries/leaf_room.h"
#include "scenes/strawberries/plant_rows.h"
#include "scenes/strawberries/stand_motion.h"
#include "scenes/strawberries/target_views.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kSepalClear_m = 3e-4;  // off the hulls of fruits beside them

std::string part_name(const char* kind, std::size_t number) {
  char name[40];
  std::snprintf(name, sizeof name, "%s %02d", kind, static_cast<int>(number));
  return name;
}

void add_instance(Scene& scene, Instance instance, const std::string& name) {
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = name;
  scene.instances.push_back(std::move(instance));
}

void add_fruit(Scene& scene, const StrawberriesSceneConfig& config, const FruitModel& fruit,
               const Pose& at, std::vector<TimedPose> motion, std::size_t number) {
  Instance flesh;
  flesh.is_specimen = true;
  flesh.mass_kg = fruit.mass_kg;
  flesh.traits = fruit.traits;
  const TrussShape& shape = config.stand.truss;
  const int maturity =
      maturity_of(trait(fruit, "red_share"), shape.maturity_medium, shape.maturity_high);
  flesh.traits.push_back({"maturity", "1", static_cast<double>(maturity)});
  const Vector3d axis = at.rotation * Vector3d::UnitZ();
  constexpr std::array<const char*, 3> kAxes = {"axis_x", "axis_y", "axis_z"};
  for (int k = 0; k < 3; ++k)
    flesh.traits.push_back({kAxes[static_cast<std::size_t>(k)], "1", axis[k]});
  set_labels(flesh, fruit.flesh.model.name, maturity);
  if (config.category == "variety") flesh.category = fruit.flesh.model.name;
  const auto add = [&](Instance instance, const FruitPart& part, const std::string& name) {
    instance.model = static_cast<int>(scene.models.size());
    instance.material = static_cast<int>(scene.materials.size());
    instance.world_from_object = at;
    instance.motion = motion;
    scene.models.push_back(part.model);
    scene.materials.push_back(part.material);
    add_instance(scene, std::move(instance), name);
  };
  add(std::move(flesh), fruit.flesh, part_name("fruit", number));
  Instance calyx;
  calyx.category = "calyx";
  add(std::move(calyx), fruit.calyx, part_name("calyx", number));
}

/// Where the fruits of all trusses are among the instances, in their order.
std::vector<std::size_t> add_trusses(Scene& scene, const StrawberriesSceneConfig& config,
                                     const std::vector<Truss>& trusses,
                                     const std::vector<BentPlant>& frames) {
  std::vector<std::size_t> fruits;
  const auto stalk = static_cast<int>(scene.materials.size());
  Material green = strawberry_materials(config.plant)[kBerryStalkLook];
  green.albedo = to_rgb(color_vector(config.plant.leaf.petiole_albedo));  // no runner's red
  scene.materials.push_back(std::move(green));
  std::size_t first_stem = 0;
  for (std::size_t t = 0; t < trusses.size(); ++t) {
    const Truss& truss = trusses[t];
    const std::vector<BentPlant> own =
        frames_of(frames, first_stem, first_stem + truss.plant.stems.size());
    first_stem += truss.plant.stems.size();
    for (StalkPart& part : stalk_parts(truss, own, config.plant.surface.sides + 2)) {
      Instance instance;
      instance.category = "truss";
      instance.model = static_cast<int>(scene.models.size());
      instance.material = stalk;
      instance.motion = std::move(part.motion);
      scene.models.push_back(std::move(part.model));
      add_instance(scene, std::move(instance), part_name("truss", t) + part.name);
    }
    for (std::size_t i = 0; i < truss.fruits.size(); ++i) {
      const std::size_t number = fruits.size();
      fruits.push_back(scene.instances.size());
      add_fruit(
          scene, config, truss.fruits[i], truss.world_from_fruit[i],
          motion_of(truss.plant, own, truss.plant.loads[i].stem, 1, truss.unbent_from_fruit[i]),
          number);
    }
  }
  return fruits;
}

/// @throws std::invalid_argument naming view and fruit.
void check_eyes(const std::vector<View>& views, const std::vector<HangingFruit>& fruits,
                const std::vector<BendingObstacle>& bed) {
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
  lay_sepals(trusses, kSepalClear_m);
  const std::vector<BendingObstacle>& bed = trusses.front().plant.obstacles;
  const TrussLeafRoom room{hanging_fruits(trusses), bed, config.plant.surface.clear_m};
  Vector3d middle_m = Vector3d::Zero();
  for (const HangingFruit& fruit : room.fruits)
    middle_m += fruit.centre_m / static_cast<double>(room.fruits.size());

  Scene scene;
  scene.name = "strawberries";
  scene.rig = config.rig;
  const bool has_targets = config.occlusion >= 0;
  // Views of targets are sought when all that hides them stands.
  scene.views = strawberry_views(config, middle_m, rng.fork("views"));
  if (!has_targets) check_eyes(scene.views, room.fruits, bed);
  std::vector<double> times_s;
  for (const View& view : scene.views) times_s.push_back(view.time_s);
  const std::vector<BentPlant> frames =
      sway_trusses(trusses, rest.sag.bent, config.motion, times_s, rng.fork("sway"));
  RowPlaces rows;
  for (int k = 0; k < config.bed.row.plants; ++k) {
    rows.near_m.push_back(crown_in_world_m(config.bed, config.stand.truss, k, true, stand_rng));
    rows.far_m.push_back(crown_in_world_m(config.bed, config.stand.truss, k, false, stand_rng));
  }
  std::vector<Vector3d> crowns_m = rows.near_m;
  crowns_m.insert(crowns_m.end(), rows.far_m.begin(), rows.far_m.end());
  add_strawberry_bed(scene, config.bed, config.stand.truss, crowns_m, plant_rng.fork("bed"));
  const std::vector<std::size_t> fruits = add_trusses(scene, config, trusses, frames);
  const bool apart = has_targets || config.motion.wind.mean_speed_m_s > 0;
  SwingingLeaves leaves{room,
                        add_strawberry_plants(scene, config.plant, config.bed, room, rows, apart,
                                              plant_rng.fork("plants")),
                        {}};
  if (has_targets) add_target_views(scene, config, fruits, leaves, rng.fork("targets"));
  sway_leaves(scene, leaves.all, config.motion, config.plant.sway, times_s, rng.fork("leaves"));
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

}  // namespace cousin
