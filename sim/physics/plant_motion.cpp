#include "sim/physics/plant_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/physics/penetration.h"
#include "sim/physics/plant_model.h"

namespace cousin {
namespace {

constexpr double kHold_s = 0.2;      // rest must last as long
constexpr double kSurelyBroken = 2;  // times the strength: no overshoot of the slow loading
constexpr double kSoft_s = 1;        // contacts harden for as long
constexpr double kSoftest_s = 0.2;   // time constant of the softest
constexpr double kGust_s = 0.002;    // wind is held for about as long: gusts are slower

StemStrain strain_of(const PlantStress& stress) {
  return {stress.stress_pa, stress.ratio, stress.stem, stress.share};
}

Eigen::Vector3d vector_at(const mjtNum* values, int body) {
  return Eigen::Map<const Eigen::Vector3d>(values + 3 * static_cast<std::ptrdiff_t>(body));
}

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

}  // namespace

SagResult sag(const BendingPlant& plant, const SagConfig& config) {
  validate(config);
  SagResult result;
  const EngineWatch watch;
  const PlantModel engine = make_plant_model(plant, {.step_s = config.step_s,
                                                     .gravity_m_s2 = config.gravity_m_s2,
                                                     .friction = config.friction,
                                                     .inertia_time_s = config.inertia_time_s,
                                                     .least_damping_s = config.step_s});
  const EngineData data = make_data(*engine.model);
  const auto steps = static_cast<long>(config.max_time_s / config.step_s);
  const auto hold = static_cast<long>(std::ceil(kHold_s / config.step_s));
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
  if (result.warnings > 0) {
    result.status = PlantStatus::engine_warning;
  } else if (result.strain.ratio > 1) {
    result.status = PlantStatus::broke;
  } else if (quiet < hold && !plant.stems.empty()) {
    result.status = PlantStatus::not_at_rest;
  } else if (result.max_penetration_m > config.max_penetration_m) {
    result.status = PlantStatus::penetrates;
  } else {
    result.status = PlantStatus::ok;
  }
  return result;
}

namespace {

/// Forces of the air and of hands on one motion's bodies.
class Forces {
 public:
  Forces(const BendingPlant& plant, const PlantModel& engine, const SwayConfig& config,
         const std::vector<HandPush>& pushes, Rng rng)
      : plant_(plant),
        engine_(engine),
        config_(config),
        pushes_(pushes),
        wind_(make_wind(config.wind, rng)) {}

  void apply(mjData& data) const {
    mju_zero(data.xfrc_applied, 6 * engine_.model->nbody);
    if (config_.air_density_kg_m3 > 0) {
      for (const PlantHinge& hinge : engine_.hinges) push_stem(data, hinge);
      for (std::size_t i = 0; i < plant_.loads.size(); ++i) push_load(data, i);
    }
    for (const HandPush& push : pushes_) push_by_hand(data, push);
  }

 private:
  /// 1/2 rho A |v| v of the air past a body's centre of mass.
  Eigen::Vector3d drag_n(const mjData& data, int body, const Eigen::Vector3d& along,
                         double drag_area_m2) const {
    const Eigen::Vector3d at = vector_at(data.xipos, body);
    mjtNum moving[6];  // rotation, then translation, at the centre of mass
    mj_objectVelocity(engine_.model.get(), &data, mjOBJ_BODY, body, moving, 0);
    Eigen::Vector3d past = wind_m_s(wind_, at, data.time) -
                           Eigen::Map<const Eigen::Vector3d>(static_cast<mjtNum*>(moving) + 3);
    past -= past.dot(along) * along;  // a stem feels what comes across it
    return 0.5 * config_.air_density_kg_m3 * drag_area_m2 * past.norm() * past;
  }

  static void add(mjData& data, int body, const Eigen::Vector3d& force_n,
                  const Eigen::Vector3d& lever_m) {
    Eigen::Map<Eigen::Vector3d> force(data.xfrc_applied + 6 * static_cast<std::ptrdiff_t>(body));
    Eigen::Map<Eigen::Vector3d> torque(data.xfrc_applied + 6 * static_cast<std::ptrdiff_t>(body) +
                                       3);
    force += force_n;
    torque += lever_m.cross(force_n);
  }

  void push_stem(mjData& data, const PlantHinge& hinge) const {
    const BendingStem& stem = plant_.stems[hinge.stem];
    const double span_m = length_m(stem) / stem.segments * (hinge.node == stem.segments ? 0.5 : 1);
    const mjtNum* q = data.xquat + 4 * static_cast<std::ptrdiff_t>(hinge.body);
    const Eigen::Vector3d along = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * hinge.along;
    add(data, hinge.body,
        drag_n(data, hinge.body, along, config_.drag_coefficient * 2 * hinge.radius_m * span_m),
        Eigen::Vector3d::Zero());
  }

  void push_load(mjData& data, std::size_t i) const {
    if (!(plant_.loads[i].drag_area_m2 > 0)) return;
    const int body = engine_.load_body[i];
    add(data, body, drag_n(data, body, Eigen::Vector3d::Zero(), plant_.loads[i].drag_area_m2),
        Eigen::Vector3d::Zero());
  }

  void push_by_hand(mjData& data, const HandPush& push) const {
    const double phase = (data.time - push.begin_s) / push.seconds;
    if (phase <= 0 || phase >= 1) return;
    const auto s = static_cast<std::size_t>(push.stem);
    const BendingStem& stem = plant_.stems[s];
    const int node = static_cast<int>(push.share * stem.segments + 0.5);
    if (node == 0) return;  // held by what carries it
    const PlantHinge& hinge =
        engine_.hinges[engine_.first_hinge[s] + static_cast<std::size_t>(node - 1)];
    const mjtNum* q = data.xquat + 4 * static_cast<std::ptrdiff_t>(hinge.body);
    const Eigen::Vector3d at =
        vector_at(data.xpos, hinge.body) +
        Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * (point_at_m(stem, push.share) - hinge.at_m);
    add(data, hinge.body, std::sin(std::numbers::pi * phase) * push.force_n,
        at - vector_at(data.xipos, hinge.body));
  }

  const BendingPlant& plant_;
  const PlantModel& engine_;
  const SwayConfig& config_;
  const std::vector<HandPush>& pushes_;
  WindField wind_;
};

void check(const BendingPlant& plant, const std::vector<HandPush>& pushes,
           const SwayConfig& config) {
  validate(config);
  validate(plant);
  for (std::size_t s = 0; s < plant.stems.size(); ++s) {
    if (plant.stems[s].damping_time_s >= config.step_s) continue;
    throw std::invalid_argument("sway: stem " + std::to_string(s) + ": damping_time_s is " +
                                std::to_string(plant.stems[s].damping_time_s) +
                                "; it must be at least the step, " + std::to_string(config.step_s));
  }
  for (const HandPush& push : pushes) {
    const bool sound = push.stem >= 0 && push.stem < static_cast<int>(plant.stems.size()) &&
                       push.share >= 0 && push.share <= 1 && push.seconds > 0 &&
                       push.force_n.allFinite() && push.force_n.norm() <= 1000;
    if (!sound) {
      throw std::invalid_argument(
          "sway: a push needs a stem that exists, a share in [0, 1], a positive time and at most "
          "1000 N; it is of stem " +
          std::to_string(push.stem) + " at " + std::to_string(push.share) + " for " +
          std::to_string(push.seconds) + " s");
    }
  }
}

}  // namespace

SwayResult sway(const BendingPlant& plant, const BentPlant& from,
                const std::vector<HandPush>& pushes, const SwayConfig& config, Rng rng) {
  check(plant, pushes, config);
  const bool touches =
      config.contacts && (!plant.obstacles.empty() ||
                          std::any_of(plant.loads.begin(), plant.loads.end(),
                                      [](const BendingLoad& load) { return !load.hulls.empty(); }));
  SwayResult result;
  const EngineWatch watch;
  const PlantModel engine =
      make_plant_model(plant, {.step_s = config.step_s,
                               .gravity_m_s2 = config.gravity_m_s2,
                               .contacts = touches,
                               .inertia_time_s = touches ? 2 * config.step_s : 0});
  const EngineData data = make_data(*engine.model);
  set_bent(engine, from, *data);
  mj_forward(engine.model.get(), data.get());
  const Forces forces(plant, engine, config, pushes, rng);
  const long hold = std::max(1L, std::lround(kGust_s / config.step_s));
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
