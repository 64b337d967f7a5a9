#include "scenes/seeds/heap.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "sim/physics/penetration.h"
#include "sim/physics/settle.h"
#include "sim/render/truth_pass.h"
#include "sim/types/not_built.h"

namespace cousin {
namespace {

constexpr double kTouch_m = 1e-4;  ///< nearer than this they touch: contacts rest to 20 um
constexpr double kGood = 0.02, kFar = 0.03;  ///< from the fraction asked for
constexpr std::size_t kViews = 20;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Release spots anywhere in the disc: settle() releases those that meet above one another.
std::vector<Pose> spots_in(double radius_m, std::size_t count, Rng rng) {
  std::vector<Pose> spots;
  for (std::size_t i = 0; i < count; ++i) {
    Rng own = rng.fork(i);
    const double r = radius_m * std::sqrt(uniform(own));
    const double angle = 2 * std::numbers::pi * uniform(own);
    const Eigen::Quaterniond rotation = random_rotation(own);
    spots.push_back({rotation, {r * std::cos(angle), r * std::sin(angle), 0}});
  }
  return spots;
}

SettleConfig pouring(const SettingConfig& setting) {
  SettleConfig config;
  config.drop_height_m = setting.drop_height_m;
  config.friction = setting.heap_friction;
  config.rolling_friction_m = setting.heap_rolling_friction_m;
  config.drag_per_s = setting.heap_drag_per_s;
  config.max_time_s = setting.heap_time_s;
  config.rest_energy_j = setting.heap_rest_energy_j;
  config.max_penetration_m = setting.heap_penetration_m;
  config.contacts_per_body = 60;
  return config;
}

bool touches(const BoardSpecimen& a, const Pose& world_from_a, const BoardSpecimen& b,
             const Pose& world_from_b) {
  const double apart_m = (world_from_a.translation_m - world_from_b.translation_m).norm();
  if (apart_m > a.radius_m + b.radius_m + kTouch_m) return false;
  const Pose b_from_a = inverse(world_from_b) * world_from_a;
  for (const Mesh& hull : b.parts.hulls) {
    const ConvexBody body(hull);
    for (const Eigen::Vector3d& vertex : a.seed.model.mesh.vertices_m) {
      if (body.depth_m(b_from_a * vertex, -kTouch_m) > -kTouch_m) return true;
    }
  }
  return false;
}

std::vector<int> touching_counts(const std::vector<BoardSpecimen>& specimens,
                                 const std::vector<Pose>& poses) {
  std::vector<int> counts(specimens.size(), 0);
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!touches(specimens[i], poses[i], specimens[j], poses[j]) &&
          !touches(specimens[j], poses[j], specimens[i], poses[i]))
        continue;
      ++counts[i];
      ++counts[j];
    }
  }
  return counts;
}

/// The specimens alone, of which the poses change from one drop to the next.
Scene scene_of(const std::vector<BoardSpecimen>& specimens) {
  Scene scene;
  scene.name = "heap";
  scene.materials.emplace_back();
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    ObjectModel model;
    model.name = specimens[i].category;
    model.mesh = specimens[i].seed.model.mesh;
    scene.models.push_back(std::move(model));
    Instance instance;
    instance.id = instance.model = static_cast<int>(i);
    instance.name = instance.category = specimens[i].category;
    instance.is_specimen = true;
    scene.instances.push_back(std::move(instance));
  }
  return scene;
}

bool is_within(const std::vector<BoardSpecimen>& specimens, const std::vector<Pose>& poses,
               double reach_m) {
  for (std::size_t i = 0; i < specimens.size(); ++i) {
    if (poses[i].translation_m.head<2>().norm() + specimens[i].radius_m > reach_m) return false;
  }
  return true;
}

/// One pouring; nothing if it does not come to rest on the board.
std::optional<Heap> pour(const std::vector<BoardSpecimen>& specimens, const SettingConfig& setting,
                         const std::vector<Pose>& spots, std::string& problem) {
  std::vector<SettleBody> bodies;
  for (std::size_t i = 0; i < specimens.size(); ++i)
    bodies.push_back(
        {&specimens[i].seed.model.mesh, specimens[i].seed.mass_kg, spots[i], &specimens[i].parts});
  SettleResult rest = settle(bodies, pouring(setting));
  if (rest.status == SettleStatus::not_built) {
    throw NotBuilt("seeds: MuJoCo is not built in (WITH_MUJOCO=OFF), so nothing can be dropped");
  }
  if (rest.status != SettleStatus::ok) {
    problem = std::string("did not settle: ") + std::string(to_string(rest.status)) +
              (rest.warnings > 0 ? ": " + rest.first_warning : "");
    return std::nullopt;
  }
  if (!is_within(specimens, rest.world_from_body, setting.reach_m)) {
    problem = "rolled out of placing.reach_m";
    return std::nullopt;
  }
  return Heap{std::move(rest.world_from_body), {}, {}};
}

}  // namespace

std::vector<double> visible_fractions(const Scene& scene, const std::vector<View>& views) {
  const RayScene rays(scene);
  std::vector<double> sums(scene.instances.size(), 0);
  std::vector<int> counts(scene.instances.size(), 0);
  const std::size_t used = std::min(kViews, views.size());
  constexpr int kSize_px = 360;
  constexpr double kHalf_m = 0.045;  ///< of the board in the image
  for (std::size_t k = 0; k < used; ++k) {
    const View& view = views[k * views.size() / used];
    TrueView camera;
    camera.camera_from_world = camera.camera_from_world_end = view.rig_from_world;
    camera.camera.width_px = camera.camera.height_px = kSize_px;
    camera.camera.cx_px = camera.camera.cy_px = 0.5 * (kSize_px - 1);
    const double distance_m = centre_in_world_m(view.rig_from_world).norm();
    camera.camera.fx_px = camera.camera.fy_px = 0.5 * kSize_px * distance_m / kHalf_m;
    for (const InstanceVisibility& v :
         render_truth(rays, scene, camera, {.visibility = true}).visibility) {
      if (v.pixels_full == 0) continue;
      sums[static_cast<std::size_t>(v.instance)] += v.visible_fraction;
      ++counts[static_cast<std::size_t>(v.instance)];
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = counts[i] > 0 ? sums[i] / counts[i] : 0;
  return sums;
}

Heap drop_heap(const std::vector<BoardSpecimen>& specimens, const SettingConfig& setting,
               const std::vector<View>& views, double visible_fraction, Rng rng) {
  Scene scene = scene_of(specimens);
  Heap best;
  double least = 1, most = 0, nearest = 1;
  std::string problem = "nothing was dropped";
  double low_m = 0, high_m = setting.spot_radius_m;
  constexpr int kHalvings = 6;
  const int drops = kHalvings * std::max(1, setting.attempts / kHalvings);
  for (int drop = 0; drop < drops && nearest > kGood; ++drop) {
    if (drop % kHalvings == 0) {  // other spots, other seeds on top
      low_m = 0;
      high_m = setting.spot_radius_m;
    }
    // The whole disc first: what asks for more than it shows cannot be met.
    const double radius_m = drop % kHalvings == 0 ? high_m : 0.5 * (low_m + high_m);
    const Rng own = rng.fork(static_cast<std::uint64_t>(drop / kHalvings));
    std::optional<Heap> heap =
        pour(specimens, setting, spots_in(radius_m, specimens.size(), own), problem);
    if (!heap) {
      high_m = radius_m > 0.5 * setting.spot_radius_m ? 0.9 * radius_m : high_m;
      low_m = radius_m > 0.5 * setting.spot_radius_m ? low_m : radius_m;
      continue;
    }
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
      scene.instances[i].world_from_object = heap->world_from_specimen[i];
    heap->visible = visible_fractions(scene, views);
    const double reached = mean_of(heap->visible);
    least = std::min(least, reached);
    most = std::max(most, reached);
    (reached < visible_fraction ? low_m : high_m) = radius_m;
    if (std::abs(reached - visible_fraction) >= nearest) continue;
    nearest = std::abs(reached - visible_fraction);
    best = std::move(*heap);
  }
  if (nearest > kFar) {
    throw std::runtime_error(
        "seeds: visible_fraction = " + std::to_string(visible_fraction) + " was not met in " +
        std::to_string(drops) + " drops" +
        (most > 0 ? ": they reach " + std::to_string(least) + " to " + std::to_string(most)
                  : "; the last: " + problem));
  }
  best.touching = touching_counts(specimens, best.world_from_specimen);
  return best;
}

}  // namespace cousin
