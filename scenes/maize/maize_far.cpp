#include "scenes/maize/maize_far.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/geometry/gradient_noise.h"
#include "sim/geometry/lattice.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr int kStrips = 4;  // different ones
constexpr int kPlants = 6;  // a strip

void append(ObjectModel& strip, const PlantModel& plant, const Pose& strip_from_plant) {
  const ObjectModel& from = plant.model;
  const auto first = static_cast<std::uint32_t>(strip.mesh.vertices_m.size());
  for (const Vector3d& p : from.mesh.vertices_m)
    strip.mesh.vertices_m.emplace_back(strip_from_plant * p);
  for (const Eigen::Vector3f& n : from.vertex_normals)
    strip.vertex_normals.emplace_back((strip_from_plant.rotation * n.cast<double>()).cast<float>());
  strip.vertex_albedo.insert(strip.vertex_albedo.end(), from.vertex_albedo.begin(),
                             from.vertex_albedo.end());
  for (std::size_t i = 0; i < from.mesh.triangles.size(); ++i) {
    const auto& t = from.mesh.triangles[i];
    strip.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    strip.triangle_part.push_back(
        static_cast<std::uint16_t>(plant.part_looks[from.triangle_part[i]]));
  }
}

/// Some plants of a row, along +x from the origin, in few triangles; its parts are the looks.
ObjectModel strip_model(const MaizeSceneConfig& config, const Rng& rng) {
  MaizeConfig coarse = config.plant;
  coarse.surface.detail_m = std::max(0.06, coarse.surface.detail_m);
  coarse.surface.columns = 4;
  coarse.surface.sides = 5;
  const double stage = maize_stage(config.stage, coarse.plant.leaves);
  ObjectModel strip;
  strip.name = "maize far away";
  strip.part_names = {"stalks", "leaves", "flowers"};
  for (int i = 0; i < kPlants; ++i) {
    const Rng own = rng.fork(static_cast<std::uint64_t>(i));
    Rng place = own.fork("place");
    const auto& field = coarse.field;
    Pose pose;
    pose.translation_m = {
        (i + 0.5) * field.plant_m + truncated_normal(place, 0, field.scatter_m, 2),
        0.4 * truncated_normal(place, 0, field.scatter_m, 2), 0};
    pose.rotation = Eigen::AngleAxisd(uniform(place, 0, 2 * kPi), Vector3d::UnitZ());
    append(strip, plant_model(grow_maize(coarse, stage, own.fork("plant")).plant), pose);
  }
  return strip;
}

/// Distance of a point from a piece of a line.
double distance_m(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d ab = b - a;
  const double square = ab.squaredNorm();
  const double t = square > 0 ? std::clamp((p - a).dot(ab) / square, 0.0, 1.0) : 0;
  return (a + t * ab - p).norm();
}

/// Whether a strip about `middle` leaves the specimens and the cameras' sight of them free.
bool is_clear(const Scene& scene, const MaizeSceneConfig& config, const Vector2d& middle_m,
              double half_m) {
  const auto& field = config.plant.field;
  const double along_m = 0.5 * config.plants * field.plant_m + half_m,
               across_m = 0.5 * config.rows * field.row_m;
  if (std::abs(middle_m.x()) < along_m && std::abs(middle_m.y()) < across_m) return false;
  const Vector2d end(half_m, 0);
  return std::none_of(scene.views.begin(), scene.views.end(), [&](const View& view) {
    const Vector2d eye = inverse(view.rig_from_world).translation_m.head<2>(),
                   target = view.focus_in_world_m.head<2>();
    const double nearest =
        std::min({distance_m(middle_m, eye, target), distance_m(middle_m + end, eye, target),
                  distance_m(middle_m - end, eye, target)});
    return nearest < field.clear_m;
  });
}

}  // namespace

void add_far_rows(Scene& scene, const MaizeSceneConfig& config, int first_material,
                  const Rng& rng) {
  const auto& field = config.plant.field;
  const double strip_m = kPlants * field.plant_m;
  const int across = static_cast<int>(field.far_m / field.row_m),
            along = static_cast<int>(field.far_m / strip_m);
  if (across == 0 || along == 0) return;
  std::vector<ObjectModel> strips(kStrips);
  tbb::parallel_for(std::size_t{0}, strips.size(),
                    [&](std::size_t i) { strips[i] = strip_model(config, rng.fork(i)); });
  const int first_model = static_cast<int>(scene.models.size());
  for (ObjectModel& strip : strips) scene.models.push_back(std::move(strip));
  int id = 0;
  for (const Instance& other : scene.instances) id = std::max(id, other.id + 1);
  for (int row = -across; row <= across; ++row) {
    for (int k = -along; k < along; ++k) {
      Rng own = rng.fork("place").fork(
          static_cast<std::uint64_t>((row + across) * 2 * along + k + along));
      const Vector2d middle_m((k + 0.5) * strip_m, row * field.row_m);
      if (!is_clear(scene, config, middle_m, 0.5 * strip_m)) continue;
      Instance strip;
      strip.id = id++;
      strip.name = strip.category = "maize far away";
      strip.model = first_model + static_cast<int>(uniform_index(own, kStrips));
      strip.material = first_material + kBladeLook;
      for (const int look : {kStalkLook, kBladeLook, kFlowerLook})
        strip.part_materials.push_back(first_material + look);
      // Every other strip the other way about: few meshes look like many.
      const bool is_turned = uniform(own) < 0.5;
      strip.world_from_object.translation_m = {middle_m.x() + (is_turned ? 0.5 : -0.5) * strip_m,
                                               middle_m.y(), 0};
      if (is_turned) strip.world_from_object.rotation = Eigen::AngleAxisd(kPi, Vector3d::UnitZ());
      scene.instances.push_back(std::move(strip));
    }
  }
}

void add_hedge(Scene& scene, const MaizeConfig::Field& field, const Rng& rng) {
  if (!(field.hedge_m > 0)) return;
  constexpr int kAround = 900, kUp = 14;
  const std::uint64_t key = rng.fork("hedge")();
  const double radius_m = 0.9 * field.half_m;
  ObjectModel model;
  model.name = "line of trees";
  for (int j = 0; j <= kUp; ++j) {
    for (int i = 0; i <= kAround; ++i) {
      const double a = 2 * kPi * (i % kAround) / kAround, up = static_cast<double>(j) / kUp;
      const Vector3d on(std::cos(a), std::sin(a), 0);
      const double tall = 1 + 0.35 * noise3(6 * on, key) + 0.22 * noise3(22 * on, key + 1) +
                          0.07 * noise3(60 * on, key + 4);
      const double crowns =
          fractal_noise3(Vector3d(30 * on + 5 * up * Vector3d::UnitZ()), 4, key + 2);
      const double bulge = 0.06 * std::sin(kPi * std::min(1.0, 0.15 + up)) + 0.05 * crowns;
      model.mesh.vertices_m.emplace_back((1 - bulge) * radius_m * on +
                                         (up * tall * field.hedge_m - 0.3) * Vector3d::UnitZ());
      const auto tone = static_cast<float>(std::clamp(0.72 + 0.5 * crowns, 0.3, 1.0));
      model.vertex_albedo.push_back({tone, tone, tone});
    }
  }
  add_lattice_triangles(model.mesh, 0, kAround, kUp);
  model.vertex_normals = smooth_normals(model.mesh);
  Material leaves;
  leaves.name = "trees far away";
  leaves.kind = SurfaceKind::leaf;  // seen from within as well
  leaves.albedo = to_rgb(color_vector(field.hedge_albedo));
  leaves.ior = 1;
  leaves.roughness = 1;
  leaves.infrared_albedo = 0.4F;
  Instance instance;
  for (const Instance& other : scene.instances) instance.id = std::max(instance.id, other.id + 1);
  instance.name = instance.category = "line of trees";
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(leaves));
  scene.instances.push_back(std::move(instance));
}

}  // namespace cousin
