#include "scenes/seeds/seeds_scene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "scenes/seeds/cultivar.h"
#include "scenes/seeds/setting.h"
#include "scenes/seeds/specimen.h"
#include "sim/geometry/measure.h"
#include "sim/physics/settle.h"

namespace cousin {
namespace {

struct Specimen {
  SeedModel seed;
  Material material;
  std::string category;
  double radius_m = 0;  ///< of the sphere around its centroid
  ConvexParts parts;    ///< what collides
};

double radius_m(const Mesh& mesh) {
  double radius = 0;
  for (const Eigen::Vector3d& v : mesh.vertices_m) radius = std::max(radius, v.norm());
  return radius;
}

Specimen grown(const std::string& name, const SeedsSceneConfig& scene, Rng rng) {
  const CultivarConfig config = varied(cultivar(name), scene.vary);
  Specimen specimen{make_seed(name, scene.spread, rng, scene.vary), {}, name};
  specimen.material.name = name;
  specimen.material.albedo = {1, 1, 1};  // the vertices carry the colour
  specimen.material.roughness = config.roughness;
  specimen.material.ior = config.ior;
  return specimen;
}

Specimen reference_sphere(const SettingConfig& setting, Rng rng) {
  Specimen sphere{make_sphere(setting, rng), {}, "sphere"};
  // Free: painted matt, so that nothing is mirrored and the estimator alone is tested.
  sphere.material = {.name = "matt sphere", .albedo = {1, 1, 1}, .ior = 1, .roughness = 1};
  return sphere;
}

Specimen users(const SettingConfig& setting, const std::string& name, const Mesh& mesh, Rng rng) {
  Specimen specimen{make_specimen(name, mesh, setting.specimen_density_kg_m3), {}, "specimen"};
  specimen.seed.model.vertex_albedo =
      mottle(specimen.seed.model.mesh, setting.specimen_albedo, setting.specimen_mottle,
             setting.specimen_mottle_scale_m, rng);
  // Free: as waxy as the grains of cultivars.toml, since nothing is known of a user's specimen.
  specimen.material = {.name = "specimen", .albedo = {1, 1, 1}, .ior = 1.47, .roughness = 0.5};
  return specimen;
}

std::vector<Specimen> make_specimens(const SeedsSceneConfig& config, const SettingConfig& setting,
                                     Rng rng, const std::optional<Mesh>& user_mesh) {
  const std::vector<std::string> names = cultivar_names();
  const auto make = [&](std::size_t i) {
    if (config.sphere) return reference_sphere(setting, rng.fork("sphere"));
    if (user_mesh) return users(setting, config.specimen, *user_mesh, rng.fork(i));
    const std::string& name =
        config.cultivar == "mixed" ? names[i % names.size()] : config.cultivar;
    return grown(name, config, rng.fork(i));
  };
  std::vector<Specimen> specimens(config.sphere ? 1 : static_cast<std::size_t>(config.seeds));
  tbb::parallel_for(std::size_t{0}, specimens.size(), [&](std::size_t i) {
    specimens[i] = make(i);
    if (!config.gloss) specimens[i].material.ior = 1;  // nothing is mirrored
    specimens[i].radius_m = radius_m(specimens[i].seed.model.mesh);
    specimens[i].parts = convex_parts(specimens[i].seed.model.mesh);
  });
  return specimens;
}

Eigen::Quaterniond random_rotation(Rng& rng) {  // uniform [Shoemake 1992]
  const double u = uniform(rng);
  const double a = 2 * std::numbers::pi * uniform(rng);
  const double b = 2 * std::numbers::pi * uniform(rng);
  return {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
          std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)};
}

/// Release spots whose bounding spheres keep the gap, drawn one after the other; nothing if 2000
/// darts in a row miss.
std::optional<std::vector<Pose>> draw_spots(const std::vector<Specimen>& specimens,
                                            const SettingConfig& setting, Rng rng) {
  std::vector<Pose> poses;
  for (const Specimen& specimen : specimens) {
    const double reach_m = std::min(setting.spot_radius_m, setting.reach_m - specimen.radius_m);
    bool placed = false;
    for (int dart = 0; dart < 2000 && !placed; ++dart) {
      const double r = std::max(0.0, reach_m) * std::sqrt(uniform(rng));
      const double angle = 2 * std::numbers::pi * uniform(rng);
      const Eigen::Vector3d spot(r * std::cos(angle), r * std::sin(angle), 0);
      placed = true;
      for (std::size_t j = 0; j < poses.size() && placed; ++j) {
        const double apart_m = (poses[j].translation_m - spot).norm();
        placed = apart_m >= specimen.radius_m + specimens[j].radius_m + setting.spot_gap_m;
      }
      if (placed) poses.push_back({random_rotation(rng), spot});
    }
    if (!placed) return {};
  }
  return poses;
}

/// The outline seen from above, as the convex hull's corners at many directions: enough for gaps of
/// a millimetre.
std::vector<Eigen::Vector2d> outline(const Mesh& mesh, const Pose& world_from_body) {
  constexpr int kDirections = 64;
  std::vector<Eigen::Vector2d> corners(kDirections);
  std::vector<double> most(kDirections, -1e9);
  std::vector<Eigen::Vector2d> sides;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    sides.emplace_back(std::cos(angle), std::sin(angle));
  }
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    const Eigen::Vector2d p = (world_from_body * vertex).head<2>();
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double d = sides[k].dot(p);
      if (d > most[k]) {
        most[k] = d;
        corners[k] = p;
      }
    }
  }
  return corners;
}

/// Gap between two convex outlines along the best of the directions that separate them; negative
/// where they overlap.
double gap_m(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  double widest = -1e9;
  constexpr int kDirections = 128;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    const Eigen::Vector2d side(std::cos(angle), std::sin(angle));
    double a_most = -1e9;
    double b_least = 1e9;
    for (const Eigen::Vector2d& p : a) a_most = std::max(a_most, side.dot(p));
    for (const Eigen::Vector2d& p : b) b_least = std::min(b_least, side.dot(p));
    widest = std::max(widest, b_least - a_most);
  }
  return widest;
}

/// Moves specimens that rest too near another, or too far out, to spots of their own. The board is
/// a plane: a body at rest that touches no other is at rest anywhere on it. Returns why that is not
/// possible; empty if it is done.
std::string slide_apart(const std::vector<Specimen>& specimens, const SettingConfig& setting,
                        Rng rng, std::vector<Pose>& poses) {
  constexpr double kLeaning_m = 2e-4;  // nearer than this, one may lean on the other
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    outlines.push_back(outline(specimens[i].seed.model.mesh, poses[i]));
    for (std::size_t j = 0; j < i; ++j) {
      if (gap_m(outlines[i], outlines[j]) < kLeaning_m) return "two specimens touch";
    }
  }
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    const auto fits = [&](const std::vector<Eigen::Vector2d>& shape) {
      for (const Eigen::Vector2d& p : shape) {
        if (p.norm() > setting.reach_m) return false;
      }
      for (std::size_t j = 0; j < i; ++j) {
        if (gap_m(shape, outlines[j]) < setting.rest_gap_m) return false;
      }
      return true;
    };
    bool placed = fits(outlines[i]);
    Rng darts = rng.fork(i);
    for (int dart = 0; dart < 2000 && !placed; ++dart) {
      const double r = setting.spot_radius_m * std::sqrt(uniform(darts));
      const double angle = 2 * std::numbers::pi * uniform(darts);
      const Eigen::Vector2d move = Eigen::Vector2d(r * std::cos(angle), r * std::sin(angle)) -
                                   Eigen::Vector2d(poses[i].translation_m.head<2>());
      std::vector<Eigen::Vector2d> moved = outlines[i];
      for (Eigen::Vector2d& p : moved) p += move;
      placed = fits(moved);
      if (!placed) continue;
      outlines[i] = std::move(moved);
      poses[i].translation_m.head<2>() += move;
    }
    if (!placed) return "no spot is left at placing.rest_gap_m from the others";
  }
  return {};
}

/// Drops the specimens; new spots are drawn where they do not come to rest apart from each other.
std::vector<Pose> drop(const std::vector<Specimen>& specimens, const SettingConfig& setting,
                       Rng rng) {
  SettleConfig settle_config;
  settle_config.drop_height_m = setting.drop_height_m;
  std::string problem =
      "no room for " + std::to_string(specimens.size()) + " specimens on the board";
  for (int attempt = 0; attempt < setting.attempts; ++attempt) {
    const auto spots =
        draw_spots(specimens, setting, rng.fork(static_cast<std::uint64_t>(attempt)));
    if (!spots) continue;
    std::vector<SettleBody> bodies;
    for (std::size_t i = 0; i < specimens.size(); ++i) {
      bodies.push_back({&specimens[i].seed.model.mesh, specimens[i].seed.mass_kg, (*spots)[i],
                        &specimens[i].parts});
    }
    SettleResult rest = settle(bodies, settle_config);
    if (rest.status == SettleStatus::not_built) {
      throw std::runtime_error(
          "seeds: MuJoCo is not built in (WITH_MUJOCO=OFF), so nothing can be dropped");
    }
    if (rest.status == SettleStatus::engine_warning) {
      throw std::runtime_error("seeds: the physics engine gave " + std::to_string(rest.warnings) +
                               " warnings; the first: " + rest.first_warning);
    }
    if (rest.status == SettleStatus::ok) {
      const Rng slide = rng.fork("slide").fork(static_cast<std::uint64_t>(attempt));
      problem = slide_apart(specimens, setting, slide, rest.world_from_body);
      if (problem.empty()) return rest.world_from_body;
    } else {
      problem = "they did not settle: " + std::string(to_string(rest.status));
    }
  }
  double largest_m = 0;
  for (const Specimen& specimen : specimens) largest_m = std::max(largest_m, specimen.radius_m);
  if (largest_m > setting.reach_m) {
    problem += "; a specimen is " + std::to_string(2 * largest_m) + " m across and " +
               std::to_string(2 * setting.reach_m) + " m have room (see specimen_scale)";
  }
  throw std::runtime_error("seeds: " + std::to_string(setting.attempts) +
                           " attempts to drop the specimens failed; the last: " + problem);
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
             {"specimen", &c.specimen, "\"\" = grown; mesh:FILE = a closed mesh (PLY, OBJ, STL)"},
             {"specimen_scale", &c.specimen_scale, "metres per unit of that mesh", 1e-9, 1e6},
             {"markers", &c.markers, "false: the paper's plain board"},
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
  Scene scene;
  add_lights(scene, config.light);  // throws, naming those that exist
}

Scene build_seeds_scene(const SeedsSceneConfig& config, Rng rng,
                        const std::optional<Mesh>& user_mesh,
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
  add_board(scene, setting, board);
  add_screen(scene, setting);
  if (environment) {
    scene.lights.emplace_back(*environment);
  } else {
    add_lights(scene, config.light);
    vary_lights(scene.lights, config.vary);
  }

  std::vector<Specimen> specimens =
      make_specimens(config, setting, rng.fork("specimens"), user_mesh);
  const std::vector<Pose> poses = drop(specimens, setting, rng.fork("drop"));
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    Specimen& specimen = specimens[i];
    Instance instance;
    instance.id = static_cast<int>(scene.instances.size());
    instance.name = specimen.category + " " + std::to_string(i);
    instance.category = specimen.category;
    instance.is_specimen = true;
    instance.model = static_cast<int>(scene.models.size());
    instance.material = static_cast<int>(scene.materials.size());
    instance.world_from_object = poses[i];
    instance.mass_kg = specimen.seed.mass_kg;
    instance.traits = specimen.seed.traits;
    specimen.seed.model.name = instance.name;
    scene.models.push_back(std::move(specimen.seed.model));
    scene.materials.push_back(std::move(specimen.material));
    scene.instances.push_back(std::move(instance));
  }
  scene.views = camera_path(config, rng.fork("views"));
  validate(scene);
  return scene;
}

}  // namespace cousin
