#include "scenes/seedlings/seedlings_scene.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include "sim/config/limits.h"
#include "sim/plant/growth.h"

namespace cousin {
namespace {

/// One cell: what was sown in it and what came of it.
struct Cell {
  bool is_sown = true;
  Seedling seedling;
  PlantModel model;  ///< if it has emerged
  double turn_rad = 0;
};

Cell grow_cell(const SeedlingsSceneConfig& config, Rng rng) {
  Cell cell;
  Rng own = rng.fork("cell");
  cell.is_sown = uniform(own) >= config.setting.tray.empty_share;
  cell.turn_rad = 2 * std::numbers::pi * uniform(own);
  SeedlingPlace place;
  place.leaves = config.leaves;
  // The plant is turned in its cell; the light is not.
  place.to_light = Eigen::AngleAxisd(-cell.turn_rad, Eigen::Vector3d::UnitZ()) *
                   to_light(config.setting, config.light);
  cell.seedling = grow_watermelon(config.plant, place, config.day, rng.fork("plant"));
  if (!cell.is_sown) cell.seedling.has_emerged = false;
  if (cell.seedling.has_emerged) cell.model = plant_model(cell.seedling.plant);
  return cell;
}

std::vector<TrueTrait> cell_traits(const Cell& cell) {
  std::vector<TrueTrait> traits = {{"sown", "1", cell.is_sown ? 1.0 : 0.0}};
  for (TrueTrait trait : cell.seedling.traits) {
    if (!cell.seedling.has_emerged) trait.value = 0;
    traits.push_back(std::move(trait));
  }
  return traits;
}

}  // namespace

Fields fields(SeedlingsSceneConfig& c) {
  constexpr double kFar_m = 5;
  return Fields{{"day", &c.day, "since sowing", 0, kLastSeedlingDay},
                {"day_step", &c.day_step,
                 "scene i shows day + i * day_step of one tray; 0: each scene its own tray", 0,
                 kLastSeedlingDay},
                {"leaves", &c.leaves, "true leaves that a plant may ever have", 0,
                 static_cast<double>(kSeedlingLeaves)},
                {"light", &c.light, "D1 strong sun, D2 overcast, D3 violet LED"},
                {"views", &c.views, "photographs by hand", 1, 10000},
                {"distance_min_m", &c.distance_min_m, "nearest", 0.05, kFar_m},
                {"distance_max_m", &c.distance_max_m, "farthest", 0.05, kFar_m},
                {"tilt_min_rad", &c.tilt_min_rad, "flattest view; pi / 2 = straight down", 0.05,
                 1.5708},
                {"tilt_max_rad", &c.tilt_max_rad, "steepest view", 0.05, 1.5708},
                {"coverage", &c.coverage,
                 "share of the azimuths and of the tray that views are spread over", 0, 1},
                {"rig", &c.rig, "sensor preset"}} +
         fields(c.motion) + nested("watermelon", fields(c.plant)) + fields(c.setting);
}

void validate(const SeedlingsSceneConfig& config) {
  SeedlingsSceneConfig copy = config;
  check_limits(fields(copy), "seedlings");
  validate(config.plant);
  validate(config.setting);
  validate(config.motion);
  const auto ordered = [](const char* low_key, double low, const char* high_key, double high) {
    if (low <= high) return;
    throw std::invalid_argument(std::string(low_key) + " " + std::to_string(low) + " is above " +
                                high_key + " " + std::to_string(high));
  };
  ordered("distance_min_m", config.distance_min_m, "distance_max_m", config.distance_max_m);
  ordered("tilt_min_rad", config.tilt_min_rad, "tilt_max_rad", config.tilt_max_rad);
  Scene scene;
  add_seedling_light(scene, config.setting, config.light);  // throws, naming those that exist
}

Scene build_seedlings_scene(const SeedlingsSceneConfig& config, Rng rng) {
  validate(config);
  Scene scene;
  scene.name = "seedlings";
  scene.rig = config.rig;
  add_seedling_light(scene, config.setting, config.light);
  const int first_cell = add_tray(scene, config.setting, rng.fork("tray"));
  const int first_material = static_cast<int>(scene.materials.size());
  for (Material& material : watermelon_materials(config.plant))
    scene.materials.push_back(std::move(material));

  std::vector<Cell> cells(
      static_cast<std::size_t>(config.setting.tray.columns * config.setting.tray.rows));
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t i) {
    cells[i] = grow_cell(config, rng.fork("plants").fork(i));
  });
  std::vector<PlantKind> kinds;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Cell& cell = cells[i];
    scene.instances[static_cast<std::size_t>(first_cell) + i].traits = cell_traits(cell);
    if (!cell.seedling.has_emerged) continue;
    Instance instance;
    // The cell's number gives the id, so that a plant keeps it over the days.
    instance.id = first_cell + static_cast<int>(cells.size() + i);
    char name[24];
    std::snprintf(name, sizeof name, "seedling %02d", static_cast<int>(i));
    instance.name = name;
    instance.category = "watermelon";
    instance.is_specimen = true;
    instance.model = static_cast<int>(scene.models.size());
    instance.material = first_material + kLeafLook;
    for (const int look : cell.model.part_looks)
      instance.part_materials.push_back(first_material + look);
    instance.world_from_object.rotation =
        Eigen::AngleAxisd(cell.turn_rad, Eigen::Vector3d::UnitZ());
    instance.world_from_object.translation_m = cell_in_world_m(config.setting, static_cast<int>(i));
    instance.traits = cell.seedling.traits;
    cell.model.model.name = instance.name;
    kinds.push_back({&cell.seedling.plant, &cell.model, {scene.instances.size()}});
    scene.models.push_back(cell.model.model);
    scene.instances.push_back(std::move(instance));
  }
  scene.views = seedling_views(config, rng.fork("views"));
  constexpr double kFelt = 0.8;  // of the height: the leaves
  move_plants(scene, kinds, config.motion, config.plant.limbs, config.plant.sway, kFelt,
              rng.fork("sway"));
  validate(scene);
  return scene;
}

}  // namespace cousin
