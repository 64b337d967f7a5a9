#include "scenes/strawberries/strawberry_bed.h"

#include <tbb/parallel_invoke.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/strawberries/bed_outline.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Instance& add(Scene& scene, ObjectModel model, Material material, const std::string& name) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size());
  instance.name = instance.category = name;
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(material));
  scene.instances.push_back(std::move(instance));
  return scene.instances.back();
}

/// Adds an instance of the same model and material elsewhere.
void repeat(Scene& scene, std::size_t of, const Vector3d& by_m) {
  Instance instance = scene.instances[of];
  instance.id = static_cast<int>(scene.instances.size());
  instance.world_from_object.translation_m += by_m;
  scene.instances.push_back(std::move(instance));
}

/// Cells of a height field or a sheet, counter-clockwise seen from its front.
void add_cells(Mesh& mesh, std::uint32_t rows, std::uint32_t columns) {
  for (std::uint32_t j = 0; j + 1 < rows; ++j) {
    for (std::uint32_t i = 0; i + 1 < columns; ++i) {
      const std::uint32_t a = j * columns + i;
      mesh.triangles.push_back({a, a + 1, a + columns + 1});
      mesh.triangles.push_back({a, a + columns + 1, a + columns});
    }
  }
}

/// Places along y, fine in the middle: cells grow with the distance from it.
std::vector<double> places(double half_m, double cell_m) {
  constexpr double kStretch = 3;
  const int n =
      std::clamp(static_cast<int>(2 * half_m / cell_m * kStretch / std::sinh(kStretch)), 16, 2000);
  std::vector<double> list;
  for (int i = 0; i <= n; ++i)
    list.push_back(half_m * std::sinh(kStretch * (2.0 * i / n - 1)) / std::sinh(kStretch));
  return list;
}

ObjectModel film_model(const StrawberryBedConfig& config, const TrussShape& shape,
                       std::uint64_t key) {
  const auto& f = config.film;
  const BedOutline outline = bed_outline(shape, f.cell_m);
  const std::vector<double> along = places(f.half_length_m, f.cell_m);
  ObjectModel model;
  model.name = "film";
  for (const double y : along) {
    double run_m = 0;
    for (std::size_t i = 0; i < outline.points_m.size(); ++i) {
      const Vector2d& p = outline.points_m[i];
      if (i > 0) run_m += (p - outline.points_m[i - 1]).norm();
      // Folds run down the sides and aslant, where the film is pulled, and every way on the top.
      const double side = std::abs(outline.normals[i].x());
      const double s = f.wrinkle_scale_m;
      const double slant = 0.8 * side * noise3({y / 0.3, run_m / 0.5, 0.2}, key + 3);
      const Vector3d place((y + slant * run_m) / s, run_m / (s * (1 + 4 * side)), 0.5);
      // Creases are sharp: the film stands out along them and is taut between; in places it is
      // smooth.
      const double taut = 0.55 + 0.9 * noise3({y / 0.12, run_m / 0.12, 0.7}, key + 4);
      const double folds =
          std::clamp(taut, 0.15, 1.0) *
          (1.5 * std::abs(noise3(place, key)) + 0.7 * std::abs(noise3(2.3 * place, key + 1)) +
           0.3 * std::abs(noise3(5.1 * place, key + 2)));
      const double in_m = f.wrinkle_m * std::min(1.0, folds);
      double rise_m = 0;
      if (outline.normals[i].y() > 0.999) {
        const double off = (p.x() + config.drip.under_m) / (2 * config.drip.radius_m);
        rise_m = config.drip.rise_m * std::exp(-off * off);
      }
      const Vector2d at = p + (rise_m - in_m) * outline.normals[i];
      model.mesh.vertices_m.emplace_back(at.x(), y, at.y());
    }
  }
  add_cells(model.mesh, static_cast<std::uint32_t>(along.size()),
            static_cast<std::uint32_t>(outline.points_m.size()));
  for (auto& t : model.mesh.triangles) std::swap(t[1], t[2]);  // seen from outside
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

/// Dust lies where it was splashed: more to the foot.
Material film_material(const StrawberryBedConfig& config) {
  Material film;
  film.name = "mulch film";
  film.albedo = to_rgb(color_vector(config.film.albedo));
  film.noise = NoiseTexture{to_rgb(color_vector(config.film.dust_albedo)), config.film.dust_m, 5};
  film.roughness = config.film.roughness;
  film.ior = config.film.ior;
  film.infrared_albedo = 0.05F;
  return film;
}

ObjectModel path_model(const StrawberryBedConfig& config, const TrussShape& shape,
                       std::uint64_t key) {
  const auto& c = config.path;
  const double far_m = config.film.half_length_m + 1.5;
  const std::vector<double> along = places(far_m, 0.010);
  const double z = -shape.bed_height_m;
  ObjectModel model;
  model.name = "path";
  constexpr int kAcross = 150;
  const double begin_m = -c.wall_m - 1, end_m = 3;
  const double foot_m = bed_outline(shape, 0.1).points_m.front().x();
  for (const double y : along) {
    for (int i = 0; i <= kAcross; ++i) {
      // Fine from the bed's foot on.
      const double t = static_cast<double>(i) / kAcross;
      const double x = t < 0.15
                           ? std::lerp(begin_m, foot_m - 0.02, t / 0.15)
                           : foot_m - 0.02 + (end_m - foot_m) * std::pow((t - 0.15) / 0.85, 2.2);
      const Vector3d p(x / c.wave_scale_m, y / c.wave_scale_m, 0.3);
      const double heap = std::exp(-std::abs(x - foot_m) / 0.05);
      const double clods = fractal_noise3(Vector3d(x, y, 0) / c.clod_scale_m, 3, key + 1);
      // Clods lie on the soil: round above, flat between.
      model.mesh.vertices_m.emplace_back(x, y,
                                         z + c.lift_m * heap * (1 + 0.5 * clods) +
                                             c.wave_m * fractal_noise3(p, 3, key) +
                                             c.clod_m * std::max(-0.2, 2 * clods));
    }
  }
  add_cells(model.mesh, static_cast<std::uint32_t>(along.size()), kAcross + 1);
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

Material matt(const char* name, const std::vector<double>& albedo, const std::vector<double>& other,
              double scale_m) {
  Material m;
  m.name = name;
  m.albedo = to_rgb(color_vector(albedo));
  m.noise = NoiseTexture{to_rgb(color_vector(other)), scale_m, 4};
  m.ior = 1;
  m.roughness = 1;
  m.infrared_albedo = 0.3F;
  return m;
}

/// The soil that a planting hole shows, a little heaped, its edge as the film was torn.
ObjectModel hole_model(const StrawberryBedConfig& config, std::uint64_t key) {
  constexpr int kRings = 6, kSides = 36;
  ObjectModel model;
  model.name = "hole";
  model.mesh.vertices_m.emplace_back(0, 0, 0.004);
  for (int ring = 1; ring <= kRings; ++ring) {
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2 * kPi * k / kSides;
      const Vector3d on(std::cos(angle), std::sin(angle), 0.3);
      const double r = config.row.hole_m * ring / kRings *
                       (1 + 0.25 * noise3(1.6 * on, key) + 0.1 * noise3(5 * on, key + 1));
      const double z =
          ring == kRings
              ? 0.0002
              : 0.0025 + 0.0022 * noise3(Vector3d(120 * r * on.x(), 120 * r * on.y(), 1), key + 2);
      model.mesh.vertices_m.emplace_back(r * on.x(), r * on.y(), z);
    }
  }
  for (std::uint32_t k = 0; k < kSides; ++k)
    model.mesh.triangles.push_back({0, 1 + k, 1 + (k + 1) % kSides});
  for (std::uint32_t ring = 0; ring + 1 < kRings; ++ring) {
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t a = 1 + ring * kSides + k, b = 1 + ring * kSides + (k + 1) % kSides;
      model.mesh.triangles.push_back({a, a + kSides, b + kSides});
      model.mesh.triangles.push_back({a, b + kSides, b});
    }
  }
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

ObjectModel drip_model(const StrawberryBedConfig& config, const TrussShape& shape,
                       std::uint64_t key) {
  std::vector<Vector3d> line;
  std::vector<double> radii_m;
  constexpr int kSteps = 80;
  for (int i = 0; i <= kSteps; ++i) {
    const double y = config.film.half_length_m * (2.0 * i / kSteps - 1);
    line.emplace_back(-shape.bed_half_width_m + 0.012 * noise3({2 * y, 0.4, 0.2}, key), y,
                      config.drip.radius_m);
    radii_m.push_back(config.drip.radius_m);
  }
  ObjectModel model;
  model.name = "drip tube";
  model.mesh = tube(line, radii_m, 16);
  model.vertex_normals = smooth_normals(model.mesh);
  return model;
}

ObjectModel wall_model(const StrawberryBedConfig& config, const TrussShape& shape) {
  constexpr double kHigh_m = 6;
  const double x = -config.path.wall_m, half_m = 25;
  const double low = -shape.bed_height_m;
  ObjectModel model;
  model.name = "wall";
  model.mesh.vertices_m = {
      {x, -half_m, low}, {x, half_m, low}, {x, half_m, kHigh_m}, {x, -half_m, kHigh_m}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return model;
}

}  // namespace

Vector3d crown_in_world_m(const StrawberryBedConfig& config, const TrussShape& shape, int k,
                          bool near, const Rng& rng) {
  Rng own = rng.fork(near ? "near row" : "far row").fork(static_cast<std::uint64_t>(k));
  // The far row stands in the gaps of the near one.
  const double y = (k - config.row.plants / 2 + (near ? 0 : 0.5)) * config.row.spacing_m;
  const double x = near ? -shape.crown_m : -2 * shape.bed_half_width_m + shape.crown_m;
  return {x, y + config.row.scatter_m * truncated_normal(own, 0, 1, 2), 0};
}

void add_strawberry_bed(Scene& scene, const StrawberryBedConfig& config, const TrussShape& shape,
                        const std::vector<Vector3d>& crowns_m, Rng rng) {
  const std::size_t first = scene.instances.size();
  ObjectModel film, path;
  tbb::parallel_invoke([&] { film = film_model(config, shape, rng.fork("film")()); },
                       [&] { path = path_model(config, shape, rng.fork("path")()); });
  add(scene, std::move(film), film_material(config), "bed");
  Material plastic;
  plastic.name = "drip tube";
  plastic.albedo = to_rgb(color_vector(config.drip.albedo));
  plastic.roughness = 0.4;
  add(scene, drip_model(config, shape, rng.fork("drip")()), plastic, "drip tube");
  for (int bed = 1; bed <= config.path.beds; ++bed) {
    for (std::size_t part = 0; part < 2; ++part)
      repeat(scene, first + part, {-bed * config.path.pitch_m, 0, 0});
  }
  add(scene, std::move(path),
      matt("furrow", config.path.albedo, config.path.other_albedo, config.path.weave_m), "path");
  Material white;
  white.name = "greenhouse film";
  white.albedo = to_rgb(color_vector(config.path.wall_albedo));
  add(scene, wall_model(config, shape), white, "wall");
  const std::size_t hole = scene.instances.size();
  for (std::size_t i = 0; i < crowns_m.size(); ++i) {
    if (i == 0) {
      add(scene, hole_model(config, rng.fork("hole")()),
          matt("soil", config.row.soil_albedo, config.row.soil_other_albedo, 0.01), "hole");
    } else {
      repeat(scene, hole, crowns_m[i] - crowns_m[0]);
      const double turn = 2.4 * static_cast<double>(i);
      scene.instances.back().world_from_object.rotation =
          Eigen::AngleAxisd(turn, Vector3d::UnitZ());
    }
    if (i == 0) scene.instances.back().world_from_object.translation_m = crowns_m[0];
  }
}

std::vector<std::string> strawberry_lights() { return {"morning", "overcast", "noon", "lamp"}; }

Vector3d to_strawberry_light(const StrawberryBedConfig& config, const std::string& light, Rng rng) {
  const auto& c = config.light;
  if (light != "morning" && light != "noon") return Vector3d::UnitZ();
  const double e = light == "morning" ? c.morning_elevation_rad : c.noon_elevation_rad;
  const double a = c.azimuth_spread_rad * uniform(rng, -1, 1);
  return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

void add_strawberry_light(Scene& scene, const StrawberryBedConfig& config, const std::string& light,
                          const Vector3d& eye_m, const Vector3d& aim_m, Rng rng) {
  const auto& c = config.light;
  const auto overcast = [&](double share) {
    const Vector3d zenith = share * color_vector(c.overcast);
    scene.lights.emplace_back(Sky{to_rgb(zenith), to_rgb(Vector3d(c.overcast_horizon * zenith)),
                                  to_rgb(Vector3d(0.1 * zenith))});
  };
  if (light == "morning" || light == "noon") {
    ClearSky sky;
    sky.to_sun = to_strawberry_light(config, light, rng);
    sky.turbidity = light == "noon" ? c.noon_turbidity : c.morning_turbidity;
    if (light == "morning") sky.angular_radius_rad = c.morning_haze_rad;
    sky.scale = 0.02;
    sky.ground_albedo = to_rgb(color_vector(config.path.albedo));
    scene.lights.emplace_back(sky);
  } else if (light == "overcast") {
    overcast(1);
  } else if (light == "lamp") {
    overcast(c.lamp_dim);
    // Over the camera, to its side; it shines along axis_u x axis_v, at what the camera looks at.
    const Vector3d centre_m = eye_m + Vector3d(0, 0.12, 0.10);
    const Vector3d along = (aim_m - centre_m).normalized();
    const Vector3d u = along.cross(Vector3d::UnitZ()).normalized();
    Lamp lamp;
    lamp.centre_in_world_m = centre_m;
    lamp.axis_u_m = c.lamp_half_m[0] * u;
    lamp.axis_v_m = c.lamp_half_m[1] * along.cross(u);
    const auto power = static_cast<float>(c.lamp_radiance);
    lamp.radiance = {power, power, power};
    scene.lights.emplace_back(lamp);
  } else {
    std::string names;
    for (const std::string& name : strawberry_lights()) names += (names.empty() ? "" : ", ") + name;
    throw std::invalid_argument("light \"" + light + "\" is not one of " + names);
  }
}

}  // namespace cousin
