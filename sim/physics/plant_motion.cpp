#include "sim/physics/plant_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/physics/penetration.h"
#include "sim/physics/plant_model.h"
#include "sim/physics/sway_forces.h"

namespace cousin {
namespace {

constexpr double kPlantHold_s = 0.2;  // rest must last as long
constexpr double kSurelyBroken = 2;   // times the strength: no overshoot of the slow loading
constexpr double kSoft_s = 1;         // contacts harden for as long
constexpr double kSoftest_s = 0.2;    // time constant of the softest

/// How far bodies have strayed from where they were when it was last set.
class Anchor {
 public:
  void set(const mjModel& model, const mjData& data) {
    kept_m_.assign(data.xpos, data.xpos + 3 * static_cast<std::ptrdiff_t>(model.nbody));
  }
  double strayed_m(const mjData& data) const {
    double farthest = 0;
    for (std::size_t i = 0; i < kept_m_.size(); ++i)
      farthest = std::max(farthest, std::abs(data.xpos[i] - kept_m_[i]));
    return farthest;
  }

 private:
  std::vector<double> kept_m_;
};

/// The convex bodies of a load, and where they are.
struct LoadShape {
  std::vector<ConvexBody> bodies;
  const BendingLoad* given = nullptr;
  Pose world_from_hulls;
};

std::vector<LoadShape> load_shapes(const BendingPlant& plant, const BentPlant& bent) {
  std::vector<LoadShape> shapes;
  for (const BendingLoad& load : plant.loads) {
    LoadShape shape;
    shape.given = &load;
    for (const Mesh& hull : load.hulls) shape.bodies.emplace_back(hull);
    shape.world_from_hulls = bent_from_unbent(plant, bent, load.stem, load.share) *
                             Pose{load.world_from_hulls, load.centroid_m};
    shapes.push_back(std::move(shape));
  }
  return shapes;
}

double depth_in_shape_m(const LoadShape& shape, const Eigen::Vector3d& in_world_m) {
  const Eigen::Vector3d in_hulls_m = inverse(shape.world_from_hulls) * in_world_m;
  double deepest = -std::numeric_limits<double>::infinity();
  for (const ConvexBody& body : shape.bodies) deepest = std::max(deepest, body.depth_m(in_hulls_m));
  return deepest;
}

/// Deepest overlap of loads with loads and boxes, by their corners, and of stems, by points along
/// them, with loads (their own end left out, as in the contacts) and boxes.
double max_penetration_m(const BendingPlant& plant, const BentPlant& bent) {
  const std::vector<LoadShape> shapes = load_shapes(plant, bent);
  double deepest = 0;
  for (const LoadShape& shape : shapes) {
    for (const Mesh& hull : shape.given->hulls) {
      for (const Eigen::Vector3d& v : hull.vertices_m) {
        const Eigen::Vector3d at = shape.world_from_hulls * v;
        for (const LoadShape& other : shapes) {
          if (&other != &shape) deepest = std::max(deepest, depth_in_shape_m(other, at));
        }
        for (const BendingObstacle& box : plant.obstacles)
          deepest = std::max(deepest, depth_m(box, at));
      }
    }
  }
  constexpr int kPlaces = 4;  // a segment
  for (std::size_t s = 0; s < plant.stems.size(); ++s) {
    const BendingStem& stem = plant.stems[s];
    // The section held by the world may begin in the ground.
    for (int i = kPlaces; i <= kPlaces * stem.segments; ++i) {
      const double share = static_cast<double>(i) / (kPlaces * stem.segments);
      const Eigen::Vector3d at =
          bent_from_unbent(plant, bent, static_cast<int>(s), share) * point_at_m(stem, share);
      const double radius_m = radius_at_m(stem, share);
      for (const BendingObstacle& box : plant.obstacles) {
        deepest = std::max(deepest, std::min(depth_m(box, at) + radius_m, 2 * radius_m));
      }
      for (const LoadShape& shape : shapes) {
        if (shape.given->stem == static_cast<int>(s)) continue;
        deepest = std::max(deepest, depth_in_shape_m(shape, at) + radius_m);
      }
    }
  }
  return deepest;
}

}  // namespace

namespace {

/// Contacts as soft as `timeconst_s`.
void set_softness(mjModel& model, double timeconst_s) {
  for (int i = 0; i < model.ngeom; ++i) model.geom_solref[mjNREF * i] = timeconst_s;
}

PlantStatus status_of_sag(const SagResult& result, bool at_rest, const SagConfig& config) {
  if (result.warnings > 0) return PlantStatus::engine_warning;
  if (result.strain.ratio > 1) return PlantStatus::broke;
  if (!at_rest) return PlantStatus::not_at_rest;
  if (result.max_penetration_m > config.max_penetration_m) return PlantStatus::penetrates;
  return PlantStatus::ok;
}

}  // namespace

SagResult sag(const BendingPlant& plant, const SagConfig& config) {
  validate(config);
  SagResult result;
  const EngineWatch watch;
  const HingedPlant engine = make_plant_model(plant, {.step_s = config.step_s,
                                                      .gravity_m_s2 = config.gravity_m_s2,
                                                      .friction = config.friction,
                                                      .inertia_time_s = config.inertia_time_s,
                                                      .least_damping_s = config.step_s});
  const EngineData data = make_data(*engine.model);
  const auto steps = static_cast<long>(config.max_time_s / config.step_s);
  const auto hold = static_cast<long>(std::ceil(kPlantHold_s / config.step_s));
  const auto look = static_cast<long>(std::ceil(0.02 / config.step_s));
  mj_forward(engine.model.get(), data.get());
  Anchor anchor;
  anchor.set(*engine.model, *data);
  // Weight comes slowly: falling and spinning fruits drive the engine's explicit terms. Unloaded,
  // fruits may overlap: contacts that part them at once would fling them away.
  const double hard_s = 2 * config.step_s;
  const auto soft = plant.loads.size() > 1 ? static_cast<long>(kSoft_s / config.step_s) : 0;
  long quiet = 0;
  for (long step = 0; step < steps && quiet < hold && watch.warnings(*data) == 0; ++step) {
    if (step <= soft && soft > 0) {
      const double share = static_cast<double>(step) / static_cast<double>(soft);
      engine.model->opt.gravity[2] = -config.gravity_m_s2 * share;
      set_softness(*engine.model, hard_s * std::pow(kSoftest_s / hard_s, 1 - share));
      quiet = 0;
    }
    mj_mulM(engine.model.get(), data.get(), data->qfrc_applied, data->qvel);
    mju_scl(data->qfrc_applied, data->qfrc_applied, -config.damping_per_s, engine.model->nv);
    mj_step(engine.model.get(), data.get());
    // A stalk far beyond its strength need not come to rest to be called broken.
    if (step % look == 0 && largest_stress(plant, engine, *data).ratio > kSurelyBroken) break;
    const double strayed_m = anchor.strayed_m(*data);
    result.moved_m = std::max(quiet > 0 ? result.moved_m : 0, strayed_m);
    ++quiet;
    if (strayed_m <= config.rest_m) continue;
    anchor.set(*engine.model, *data);
    quiet = 0;
  }
  mj_kinematics(engine.model.get(), data.get());
  result.bent = bent_plant(plant, engine, *data);
  result.bent.time_s = 0;
  result.time_s = data->time;
  result.warnings = watch.warnings(*data);
  result.first_warning = watch.first_warning();
  result.strain = strain_of(largest_stress(plant, engine, *data));
  result.max_penetration_m = max_penetration_m(plant, result.bent);
  result.status = status_of_sag(result, quiet >= hold || plant.stems.empty(), config);
  return result;
}

SwayResult sway(const BendingPlant& plant, const BentPlant& from,
                const std::vector<HandPush>& pushes, const SwayConfig& config, Rng rng) {
  check_sway(plant, pushes, config);
  const bool touches =
      config.contacts && (!plant.obstacles.empty() ||
                          std::any_of(plant.loads.begin(), plant.loads.end(),
                                      [](const BendingLoad& load) { return !load.hulls.empty(); }));
  SwayResult result;
  const EngineWatch watch;
  const HingedPlant engine =
      make_plant_model(plant, {.step_s = config.step_s,
                               .gravity_m_s2 = config.gravity_m_s2,
                               .contacts = touches,
                               .inertia_time_s = touches ? 2 * config.step_s : 0});
  const EngineData data = make_data(*engine.model);
  set_bent(engine, from, *data);
  mj_forward(engine.model.get(), data.get());
  SwayForces forces(plant, engine, config, pushes, make_wind(config.wind, rng));
  const long hold = forces.hold_steps();
  const long sample = std::lround(config.sample_s / config.step_s);
  const long steps = std::lround(config.duration_s / config.step_s);
  result.frames.push_back(bent_plant(plant, engine, *data));
  result.strain = strain_of(largest_stress(plant, engine, *data));
  result.status = PlantStatus::ok;
  for (long step = 0; step < steps && result.status == PlantStatus::ok; ++step) {
    if (step % hold == 0) forces.apply(*data);
    mj_step(engine.model.get(), data.get());
    const PlantStress stress = largest_stress(plant, engine, *data);
    if (stress.ratio > result.strain.ratio) result.strain = strain_of(stress);
    if (watch.warnings(*data) > 0) {
      result.status = PlantStatus::engine_warning;
    } else if (stress.ratio > 1) {
      result.status = PlantStatus::broke;
    } else if ((step + 1) % sample == 0) {
      mj_kinematics(engine.model.get(), data.get());
      result.frames.push_back(bent_plant(plant, engine, *data));
    }
  }
  result.warnings = watch.warnings(*data);
  result.first_warning = watch.first_warning();
  return result;
}

}  // namespace cousin
