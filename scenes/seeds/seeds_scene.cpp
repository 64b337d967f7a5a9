#include "scenes/seeds/seeds_scene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "scenes/seeds/cultivar.h"
#include "scenes/seeds/heap.h"
#include "scenes/seeds/mesh_variation.h"
#include "scenes/seeds/placing.h"
#include "scenes/seeds/setting.h"
#include "scenes/seeds/specimen.h"

namespace cousin {
namespace {

double radius_m(const Mesh& mesh) {
  double radius = 0;
  for (const Eigen::Vector3d& v : mesh.vertices_m) radius = std::max(radius, v.norm());
  return radius;
}

BoardSpecimen grown(const std::string& name, const SeedsSceneConfig& scene, Rng rng) {
  const CultivarConfig config = varied(cultivar(name), scene.vary);
  BoardSpecimen specimen{make_seed(name, scene.spread, rng, scene.vary), {}, name};
  specimen.material.name = name;
  specimen.material.albedo = {1, 1, 1};  // the vertices carry the colour
  specimen.material.roughness = config.roughness;
  specimen.material.ior = config.ior;
  return specimen;
}

BoardSpecimen reference_sphere(const SettingConfig& setting, Rng rng) {
  BoardSpecimen sphere{make_sphere(setting, rng), {}, "sphere"};
  // Free: painted matt, so that nothing is mirrored and the estimator alone is tested.
  sphere.material = {.name = "matt sphere", .albedo = {1, 1, 1}, .ior = 1, .roughness = 1};
  return sphere;
}

BoardSpecimen users(const SettingConfig& setting, const SeedsSceneConfig& config,
                    const UserMesh& user, Rng rng) {
  const Mesh mesh = varied_mesh(user.mesh, config.specimen_variation, rng.fork("shape"));
  BoardSpecimen specimen{
      make_specimen(config.specimen, mesh, setting.specimen_density_kg_m3), {}, "specimen"};
  specimen.seed.model.vertex_albedo =
      user.vertex_albedo.empty()
          ? mottle(specimen.seed.model.mesh, setting.specimen_albedo, setting.specimen_mottle,
                   setting.specimen_mottle_scale_m, rng)
          : user.vertex_albedo;
  // Free: as waxy as the grains of cultivars.toml, since nothing is known of a user's specimen.
  specimen.material = {.name = "specimen", .albedo = {1, 1, 1}, .ior = 1.47, .roughness = 0.5};
  return specimen;
}

std::vector<BoardSpecimen> make_specimens(const SeedsSceneConfig& config,
                                          const SettingConfig& setting, Rng rng,
                                          const std::optional<UserMesh>& user_mesh) {
  const std::vector<std::string> names = cultivar_names();
  const auto make = [&](std::size_t i) {
    if (config.sphere) return reference_sphere(setting, rng.fork("sphere"));
    if (user_mesh) return users(setting, config, *user_mesh, rng.fork(i));
    const std::string& name =
        config.cultivar == "mixed" ? names[i % names.size()] : config.cultivar;
    return grown(name, config, rng.fork(i));
  };
  std::vector<BoardSpecimen> specimens(config.sphere ? 1 : static_cast<std::size_t>(config.seeds));
  tbb::parallel_for(std::size_t{0}, specimens.size(), [&](std::size_t i) {
    specimens[i] = make(i);
    if (!config.gloss) specimens[i].material.ior = 1;  // nothing is mirrored
    specimens[i].radius_m = radius_m(specimens[i].seed.model.mesh);
    specimens[i].parts = convex_parts(specimens[i].seed.model.mesh);
  });
  return specimens;
}

SizeSpread spread_from_string(const std::string& text) {
  if (text == "literature") return SizeSpread::literature;
  if (text == "paper") return SizeSpread::paper;
  throw std::invalid_argument("spread \"" + text + "\" is not one of literature, paper");
}

}  // namespace

Fields fields(SeedsSceneConfig& c) {
  const TextField spread{
      [&c] { return std::string(c.spread == SizeSpread::paper ? "paper" : "literature"); },
      [&c](const std::string& text) { c.spread = spread_from_string(text); }};
  return Fields{
             {"cultivar", &c.cultivar,
              "zhengdan958, tianguinuo932, jimai22, aikang58, suijing18, xiangyaxiangzhan or "
              "mixed"},
             {"seeds", &c.seeds, "on the board", 0, 40},
             {"spread", spread, "of sizes: literature, or paper (what its R^2 and RMSE imply)"},
             {"specimen", &c.specimen,
              "\"\" = grown; mesh:FILE = a closed mesh (PLY, OBJ, STL, glTF)"},
             {"specimen_scale", &c.specimen_scale, "metres per unit of that mesh", 1e-9, 1e6},
             {"specimen_variation", &c.specimen_variation,
              "how much each differs from that mesh in size and shape; 0 = all alike", 0, 0.3},
             {"placing", &c.placing,
              "apart: none touches another; heap: poured on one another, as visible_fraction asks"},
             {"visible_fraction", &c.visible_fraction,
              "of a heap: share of a seed's image that others leave free, mean over seeds and "
              "views",
              0.05, 1},
             {"markers", &c.markers, "false: the paper's plain board"},
             {"print_scale", &c.print_scale, "of the print over what it should be", 0.5, 2},
             {"sheet_sag_m", &c.sheet_sag_m,
              "how much deeper the middle of the sheet lies than its left and right edges", -0.002,
              0.002},
             {"background", &c.background, "what the board lies on: green, white, black or wood"},
             {"gloss", &c.gloss, "false: seeds without a coat, that mirror nothing"},
             {"sphere", &c.sphere, "a 22 mm matt speckled sphere instead of the seeds"},
             {"views", &c.views, "photographs, spread over the rings", 1, 10000},
             {"ring_elevations_rad", &c.ring_elevations_rad, "one a ring", 0.1, 1.5},
             {"ring_distances_m", &c.ring_distances_m, "mean camera distance of each ring", 0.05,
              10},
             {"distance_min_m", &c.distance_min_m, "nearest hand-held distance", 0.05, 10},
             {"distance_max_m", &c.distance_max_m, "farthest hand-held distance", 0.05, 10},
             {"view_jitter", &c.view_jitter,
              "hand-held wander: of angles in radians, of distance and aim relative", 0, 0.5},
             {"light", &c.light, "window, lamps or sun"},
             {"environment", &c.environment,
              "\"\" = light; FILE.exr = an equirectangular OpenEXR in its place"},
             {"environment_scale", &c.environment_scale,
              "scene's radiance per unit of that picture", 0, 1e12},
             {"rig", &c.rig, "sensor preset"},
         } +
         nested("vary", fields(c.vary));
}

void validate(const SeedsSceneConfig& config) {
  const std::vector<std::string> names = cultivar_names();
  if (config.cultivar != "mixed" &&
      std::find(names.begin(), names.end(), config.cultivar) == names.end()) {
    cultivar(config.cultivar);  // throws, naming those that exist
  }
  if (config.placing != "apart" && config.placing != "heap") {
    throw std::invalid_argument("placing \"" + config.placing + "\" is not one of apart, heap");
  }
  if (config.placing == "heap" && (config.seeds < 2 || config.sphere)) {
    throw std::invalid_argument("placing = heap needs 2 seeds or more, and no sphere; seeds = " +
                                std::to_string(config.seeds));
  }
  if (config.ring_elevations_rad.empty() ||
      config.ring_elevations_rad.size() != config.ring_distances_m.size()) {
    throw std::invalid_argument(
        "ring_elevations_rad has " + std::to_string(config.ring_elevations_rad.size()) +
        " numbers and ring_distances_m " + std::to_string(config.ring_distances_m.size()) +
        "; they need the same number, at least 1");
  }
  if (config.distance_min_m > config.distance_max_m) {
    throw std::invalid_argument("distance_min_m " + std::to_string(config.distance_min_m) +
                                " is above distance_max_m " +
                                std::to_string(config.distance_max_m));
  }
  if (config.distance_max_m > 0.95 * seeds_setting().screen_radius_m) {
    throw std::invalid_argument("distance_max_m " + std::to_string(config.distance_max_m) +
                                " leaves the green screen of radius " +
                                std::to_string(seeds_setting().screen_radius_m) + " m");
  }
  if (config.views < 1)
    throw std::invalid_argument("views is " + std::to_string(config.views) +
                                "; it must be at least 1");
  (void)background_albedo(seeds_setting(), config.background);  // throws
  Scene scene;
  add_lights(scene, config.light);  // throws, naming those that exist
}

Scene build_seeds_scene(const SeedsSceneConfig& config, Rng rng,
                        const std::optional<UserMesh>& user_mesh,
                        const std::optional<Environment>& environment) {
  validate(config);
  if (!config.specimen.empty() && !user_mesh) {
    throw std::invalid_argument("specimen \"" + config.specimen +
                                "\" is set, but no mesh was given");
  }
  if (!config.environment.empty() && !environment) {
    throw std::invalid_argument("environment \"" + config.environment +
                                "\" is set, but no picture was given");
  }
  const SettingConfig& setting = seeds_setting();
  Scene scene;
  scene.name = "seeds";
  scene.rig = config.rig;
  scene.board = config.markers ? "markers" : "plain";
  SeedBoard board;
  board.has_markers = config.markers;
  board.plate_m *= config.print_scale;
  board.square_m *= config.print_scale;
  board.marker_m *= config.print_scale;
  const SheetShape sheet{config.sheet_sag_m, 0.5 * board.plate_m};
  add_board(scene, setting, board, sheet);
  add_screen(scene, setting, config.background);
  if (environment) {
    scene.lights.emplace_back(*environment);
  } else {
    add_lights(scene, config.light);
    vary_lights(scene.lights, config.vary);
  }

  std::vector<BoardSpecimen> specimens =
      make_specimens(config, setting, rng.fork("specimens"), user_mesh);
  const std::vector<View> views = camera_path(config, rng.fork("views"));
  const bool is_heap = config.placing == "heap";
  const Heap heap =
      is_heap ? drop_heap(specimens, setting, views, config.visible_fraction, rng.fork("drop"))
              : Heap{drop_apart(specimens, setting, rng.fork("drop")), {}, {}};
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    BoardSpecimen& specimen = specimens[i];
    Instance instance;
    instance.id = static_cast<int>(scene.instances.size());
    instance.name = specimen.category + " " + std::to_string(i);
    instance.category = specimen.category;
    instance.is_specimen = true;
    instance.model = static_cast<int>(scene.models.size());
    instance.material = static_cast<int>(scene.materials.size());
    instance.world_from_object = heap.world_from_specimen[i];
    Eigen::Vector3d& place_m = instance.world_from_object.translation_m;
    if (config.sheet_sag_m != 0)
      place_m.z() += sheet.height_m(place_m.x());  // it lies on the sheet
    instance.mass_kg = specimen.seed.mass_kg;
    instance.traits = specimen.seed.traits;
    if (is_heap) {
      instance.traits.push_back({"visible_fraction", "1", heap.visible[i]});
      instance.traits.push_back({"touching", "1", static_cast<double>(heap.touching[i])});
    }
    specimen.seed.model.name = instance.name;
    scene.models.push_back(std::move(specimen.seed.model));
    scene.materials.push_back(std::move(specimen.material));
    scene.instances.push_back(std::move(instance));
  }
  scene.views = views;
  validate(scene);
  return scene;
}

}  // namespace cousin
