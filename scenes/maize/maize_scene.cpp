#include "scenes/maize/maize_scene.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/maize/maize_far.h"
#include "scenes/maize/maize_soil.h"
#include "sim/config/limits.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

void add_light(Scene& scene, const MaizeConfig::Field& c, const std::string& light) {
  if (light == "sun") {
    ClearSky sky;
    const double e = c.sun_elevation_rad, a = c.sun_azimuth_rad;
    sky.to_sun = {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
    sky.turbidity = c.turbidity;
    sky.scale = 0.02;
    sky.ground_albedo = to_rgb(color_vector(c.albedo));
    scene.lights.emplace_back(sky);
  } else if (light == "overcast") {
    const Vector3d zenith = color_vector(c.overcast);
    scene.lights.emplace_back(
        Sky{to_rgb(zenith), to_rgb(Vector3d(zenith / 3)), to_rgb(Vector3d(0.1 * zenith))});
  } else {
    throw std::invalid_argument("light \"" + light + "\" is not one of sun, overcast");
  }
}

/// A plant that may stand in several places.
struct Variant {
  Plant plant;
  PlantModel model;
  std::vector<TrueTrait> traits;
};

double trait_of(const Variant& variant, const std::string& name) {
  for (const TrueTrait& trait : variant.traits) {
    if (trait.name == name) return trait.value;
  }
  throw std::logic_error("maize has no trait " + name);
}

std::vector<Variant> grow_variants(const MaizeSceneConfig& config, int count, const Rng& rng) {
  const double stage = maize_stage(config.stage, config.plant.plant.leaves);
  std::vector<Variant> variants(static_cast<std::size_t>(count));
  tbb::parallel_for(std::size_t{0}, variants.size(), [&](std::size_t i) {
    MaizePlant made = grow_maize(config.plant, stage, rng.fork("plant").fork(i));
    PlantModel model = plant_model(made.plant);
    variants[i] = {std::move(made.plant), std::move(model), std::move(made.traits)};
  });
  return variants;
}

void add_plants(Scene& scene, const MaizeSceneConfig& config, const std::vector<Variant>& variants,
                const Rng& rng) {
  const int first_model = static_cast<int>(scene.models.size());
  const int first_material = static_cast<int>(scene.materials.size());
  for (Material& material : maize_materials(config.plant))
    scene.materials.push_back(std::move(material));
  for (const Variant& variant : variants) scene.models.push_back(variant.model.model);
  const auto& field = config.plant.field;
  const int middle = config.rows / 2 * config.plants + config.plants / 2;
  for (int k = 0; k < config.rows * config.plants; ++k) {
    Rng own = rng.fork("place").fork(static_cast<std::uint64_t>(k));
    // The middle plant is the first variant, and stands where it grew.
    const int index = k == middle ? 0 : k < middle ? k + 1 : k;
    const auto v = static_cast<std::size_t>(index) % variants.size();
    Instance instance;
    instance.id = 1 + k;
    instance.name = "maize " + std::to_string(k);
    instance.category = "maize";
    instance.is_specimen = true;
    instance.model = first_model + static_cast<int>(v);
    instance.material = first_material + kBladeLook;
    for (const int look : variants[v].model.part_looks)
      instance.part_materials.push_back(first_material + look);
    instance.traits = variants[v].traits;
    if (k != middle) {
      const double x = (k % config.plants - config.plants / 2) * field.plant_m +
                       truncated_normal(own, 0, field.scatter_m, 2);
      const double y = (k / config.plants - config.rows / 2) * field.row_m +
                       0.4 * truncated_normal(own, 0, field.scatter_m, 2);
      instance.world_from_object.translation_m = {x, y, 0};
      instance.world_from_object.rotation =
          Eigen::AngleAxisd(uniform(own, 0, 2 * kPi), Vector3d::UnitZ());
    }
    scene.instances.push_back(std::move(instance));
  }
}

/// Which specimens show which variant: models are in the variants' order.
std::vector<PlantKind> kinds_of(const Scene& scene, const std::vector<Variant>& variants) {
  std::vector<PlantKind> kinds;
  int first_model = -1;
  for (const Variant& variant : variants) kinds.push_back({&variant.plant, &variant.model, {}});
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.is_specimen && (first_model < 0 || instance.model < first_model))
      first_model = instance.model;
  }
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.is_specimen)
      kinds[static_cast<std::size_t>(instance.model - first_model)].specimens.push_back(i);
  }
  return kinds;
}

}  // namespace

Fields fields(MaizeSceneConfig& c) {
  constexpr double kFar_m = 20;
  return Fields{{"stage", &c.stage, "V3 .. V18 by the leaves with a collar, or VT: tassel out"},
                {"rows", &c.rows, "of the field", 1, 100},
                {"plants", &c.plants, "a row", 1, 1000},
                {"light", &c.light, "sun or overcast"},
                {"views", &c.views, "of the middle plant", 1, 10000},
                {"distance_min_m", &c.distance_min_m, "nearest", 0.2, kFar_m},
                {"distance_max_m", &c.distance_max_m, "farthest", 0.2, kFar_m},
                {"height_min", &c.height_min, "lowest point looked at, over the height", 0, 1.5},
                {"height_max", &c.height_max, "highest point looked at", 0, 1.5},
                {"pitch_min_rad", &c.pitch_min_rad, "looking down", -1.4, 1.4},
                {"pitch_max_rad", &c.pitch_max_rad, "looking down", -1.4, 1.4},
                {"azimuth_spread_rad", &c.azimuth_spread_rad,
                 "views within this of the direction across the rows", 0, 3.1416},
                {"rig", &c.rig, "sensor preset"}} +
         fields(c.motion) + nested("maize", fields(c.plant));
}

void validate(const MaizeSceneConfig& config) {
  MaizeSceneConfig copy = config;
  check_limits(fields(copy), "maize");
  validate(config.plant);
  validate(config.motion);
  maize_stage(config.stage, config.plant.plant.leaves);
  const auto ordered = [](const char* low_key, double low, const char* high_key, double high) {
    if (low <= high) return;
    throw std::invalid_argument(std::string(low_key) + " " + std::to_string(low) + " is above " +
                                high_key + " " + std::to_string(high));
  };
  ordered("distance_min_m", config.distance_min_m, "distance_max_m", config.distance_max_m);
  ordered("height_min", config.height_min, "height_max", config.height_max);
  ordered("pitch_min_rad", config.pitch_min_rad, "pitch_max_rad", config.pitch_max_rad);
  Scene scene;
  add_light(scene, config.plant.field, config.light);  // throws, naming those that exist
}

std::vector<View> maize_views(const MaizeSceneConfig& config, double height_m, Rng rng) {
  std::vector<View> views;
  for (int i = 0; i < config.views; ++i) {
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    const double turn = 2 * (i + uniform(own)) / config.views - 1;
    const double azimuth = -0.5 * kPi + config.azimuth_spread_rad * turn;
    const double distance_m = uniform(own, config.distance_min_m, config.distance_max_m);
    const double pitch = uniform(own, config.pitch_min_rad, config.pitch_max_rad);
    const Vector3d aim_m(0, 0, height_m * uniform(own, config.height_min, config.height_max));
    Vector3d eye_m =
        aim_m + distance_m * Vector3d(std::cos(pitch) * std::cos(azimuth),
                                      std::cos(pitch) * std::sin(azimuth), std::sin(pitch));
    eye_m.z() = std::max(eye_m.z(), 0.1);  // never in the soil
    View view;
    view.time_s = i;
    view.rig_from_world = look_at(eye_m, aim_m);
    view.rig_from_world_end = view.rig_from_world;
    view.focus_in_world_m = aim_m;
    views.push_back(view);
  }
  return views;
}

Scene build_maize_scene(const MaizeSceneConfig& config, Rng rng) {
  validate(config);
  Scene scene;
  scene.name = "maize";
  scene.rig = config.rig;
  add_light(scene, config.plant.field, config.light);
  add_soil(scene, config.plant.field, rng.fork("soil"));
  const int count = std::min(config.rows * config.plants, config.plant.field.variants);
  const std::vector<Variant> variants = grow_variants(config, count, rng.fork("plants"));
  add_plants(scene, config, variants, rng.fork("field"));
  add_clods(scene, config.plant.field, rng.fork("soil"));
  add_residues(scene, config.plant.field, rng.fork("soil"));
  scene.views = maize_views(config, trait_of(variants.front(), "height"), rng.fork("views"));
  add_far_rows(scene, config, 1, rng.fork("far"));
  add_hedge(scene, config.plant.field, rng.fork("far"));
  constexpr double kFelt = 0.6;  // of the height: where most of the leaf area is
  move_plants(scene, kinds_of(scene, variants), config.motion, config.plant.limbs,
              config.plant.sway, kFelt, rng.fork("sway"));
  validate(scene);
  return scene;
}

}  // namespace cousin
