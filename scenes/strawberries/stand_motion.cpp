#include "scenes/strawberries/stand_motion.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "scenes/strawberries/strawberry_plant.h"
#include "sim/geometry/smooth_normals.h"
#include "sim/types/not_built.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kLead_s = 1.5;  // of wind before a view: some periods of a truss
constexpr double kBefore_s = 0.05, kAfter_s = 0.2;

/// The stem of all trusses that a hand pushes: the peduncle of its truss.
int pushed_stem(const std::vector<Truss>& trusses, const TrussPush& push, std::size_t views) {
  const auto refuse = [](const std::string& key, int value, std::size_t count) {
    throw std::invalid_argument("strawberries: push." + key + " = " + std::to_string(value) +
                                ": there are " + std::to_string(count));
  };
  const auto t = static_cast<std::size_t>(push.truss);
  if (t >= trusses.size()) refuse("truss", push.truss, trusses.size());
  if (static_cast<std::size_t>(push.view) >= views) refuse("view", push.view, views);
  std::size_t stem = 0;
  for (std::size_t i = 0; i < t; ++i) stem += trusses[i].plant.stems.size();
  return static_cast<int>(stem);
}

[[noreturn]] void fail(const SwayResult& result, const StandWind& config) {
  if (result.status == PlantStatus::not_built)
    throw NotBuilt("strawberries: MuJoCo is not built in (WITH_MUJOCO=OFF), so no truss can sway");
  char text[200];
  std::snprintf(
      text, sizeof text,
      "strawberries: trusses do not stand wind = %.3g m/s and push.force_n = %.3g: status "
      "%s, stalk %d is strained %.3g times its strength",
      config.wind.mean_speed_m_s, config.push.force_n,
      std::string(to_string(result.status)).c_str(), result.strain.stem, result.strain.ratio);
  throw std::runtime_error(std::string(text) + (result.first_warning.empty()
                                                    ? ""
                                                    : "; the engine: " + result.first_warning));
}

/// Nodes of a stalk's line and its radii between two shares of its length, as it hangs.
CentreLine hanging_line(const Truss& truss, std::size_t s, double from, double to, int steps,
                        double swell) {
  const BendingStem& stem = truss.plant.stems[s];
  CentreLine line;
  for (int i = 0; i <= steps; ++i) {
    const double share = std::lerp(from, to, static_cast<double>(i) / steps);
    line.points_m.push_back(
        bend_m(truss.plant, truss.sag.bent, static_cast<int>(s), share, point_at_m(stem, share)));
    // Swollen where it forks.
    const double more = swell * std::exp(-std::pow((1 - share) / 0.03, 2));
    line.radii_m.push_back((1 + more) * radius_at_m(stem, share));
  }
  return line;
}

struct MovingStalk {
  std::string name;
  double swell = 0;
};

MovingStalk stalk_of(const Truss& truss, std::size_t s) {
  const auto& loads = truss.plant.loads;
  const bool bears = std::any_of(loads.begin(), loads.end(), [&](const BendingLoad& load) {
    return load.stem == static_cast<int>(s);
  });
  const char* kind = truss.plant.stems[s].parent < 0 ? "peduncle" : (bears ? "pedicel" : "branch");
  char name[40];
  std::snprintf(name, sizeof name, "%s %02d", kind, static_cast<int>(s));
  return {name, bears ? 0 : 0.35};
}

/// A truss's stalks as one plant: an organ a stalk.
ObjectModel whole_stalks(const Truss& truss, int sides) {
  Plant plant;
  plant.name = "truss";
  for (std::size_t s = 0; s < truss.plant.stems.size(); ++s) {
    const BendingStem& stem = truss.plant.stems[s];
    const MovingStalk stalk = stalk_of(truss, s);
    Organ& organ = add_organ(plant, OrganKind::petiole, stalk.name, stem.parent, 0);
    organ.look = kBerryStalkLook;
    organ.line = hanging_line(truss, s, 0, 1, 4 * stem.segments, stalk.swell);
    organ.surface = tube_surface(organ.line, sides);
  }
  return plant_model(plant).model;
}

}  // namespace

Fields fields(StandWind& c) {
  constexpr double kTurn = 6.2832, kUp = 1.5708;
  TrussPush& p = c.push;
  return scene_wind_fields(c.wind) +
         nested("push",
                {{"force_n", &p.force_n, "largest force of a hand on a truss; 0 = none", 0, 20},
                 {"truss", &p.truss, "number in its name", 0, 1000},
                 {"azimuth_rad", &p.azimuth_rad, "pushes towards, from +x to +y", -kTurn, kTurn},
                 {"elevation_rad", &p.elevation_rad, "pushes towards, upwards", -kUp, kUp},
                 {"view", &p.view, "whose time is the middle of the push", 0, 1000000},
                 {"seconds", &p.seconds, "from touch to release", 0.02, 2}});
}

std::vector<BentPlant> sway_trusses(const std::vector<Truss>& trusses, const BentPlant& rest,
                                    const StandWind& config, const std::vector<double>& times_s,
                                    const Rng& rng) {
  if (is_still(config)) return {};
  const bool has_hand = config.push.force_n > 0;
  const int stem = has_hand ? pushed_stem(trusses, config.push, times_s.size()) : 0;
  const BendingPlant plant = bending_plant(trusses);
  SwayConfig sway_config;
  sway_config.wind = config.wind;
  sway_config.duration_s = kLead_s + kAfter_s;
  std::vector<SwayResult> views(times_s.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t v) {
    std::vector<HandPush> pushes;
    if (has_hand && v == static_cast<std::size_t>(config.push.view)) {
      const TrussPush& p = config.push;
      const double c = std::cos(p.elevation_rad);
      const Vector3d to(c * std::cos(p.azimuth_rad), c * std::sin(p.azimuth_rad),
                        std::sin(p.elevation_rad));
      pushes.push_back({stem, 1, p.force_n * to, kLead_s - 0.5 * p.seconds, p.seconds});
    }
    views[v] = sway(plant, rest, pushes, sway_config, rng.fork(v));
  });
  std::vector<BentPlant> frames;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (views[v].status != PlantStatus::ok) fail(views[v], config);
    for (BentPlant& frame : views[v].frames) {
      if (frame.time_s < kLead_s - kBefore_s - 1e-9) continue;
      frame.time_s += times_s[v] - kLead_s;
      frames.push_back(std::move(frame));
    }
  }
  return frames;
}

std::vector<BentPlant> frames_of(const std::vector<BentPlant>& frames, std::size_t first_stem,
                                 std::size_t end_stem) {
  const auto first = static_cast<std::ptrdiff_t>(first_stem);
  const auto end = static_cast<std::ptrdiff_t>(end_stem);
  std::vector<BentPlant> own;
  for (const BentPlant& frame : frames) {
    BentPlant part;
    part.time_s = frame.time_s;
    part.sections.assign(frame.sections.begin() + first, frame.sections.begin() + end);
    part.joints_rad.assign(frame.joints_rad.begin() + first, frame.joints_rad.begin() + end);
    own.push_back(std::move(part));
  }
  return own;
}

std::vector<StalkPart> stalk_parts(const Truss& truss, const std::vector<BentPlant>& frames,
                                   int sides) {
  if (frames.empty()) return {{"", whole_stalks(truss, sides), {}}};
  std::vector<StalkPart> parts;
  for (std::size_t s = 0; s < truss.plant.stems.size(); ++s) {
    const int segments = truss.plant.stems[s].segments;
    const MovingStalk stalk = stalk_of(truss, s);
    for (int node = 0; node <= segments; ++node) {
      StalkPart part;
      char name[40];
      std::snprintf(name, sizeof name, " stalk %02d piece %d", static_cast<int>(s), node);
      part.name = name;
      part.model.name = stalk.name;
      // From hinge to hinge, a little into its neighbours.
      const double from = std::max(0.0, (node - 0.55) / segments);
      const double to = std::min(1.0, (node + 0.55) / segments);
      const CentreLine line = hanging_line(truss, s, from, to, 5, stalk.swell);
      part.model.mesh = tube_surface(line, sides).mesh;
      part.model.vertex_normals = smooth_normals(part.model.mesh);
      const Pose unbent_from_world =
          inverse(truss.sag.bent.sections[s][static_cast<std::size_t>(node)]);
      for (const BentPlant& frame : frames)
        part.motion.push_back(
            {frame.time_s, frame.sections[s][static_cast<std::size_t>(node)] * unbent_from_world});
      parts.push_back(std::move(part));
    }
  }
  return parts;
}

void sway_leaves(Scene& scene, const std::vector<LoneLeaf>& leaves, const StandWind& config,
                 const RigidSwayConfig& sway, const std::vector<double>& times_s, const Rng& rng) {
  if (!(config.wind.mean_speed_m_s > 0)) return;
  const WindField wind = make_wind(config.wind, rng.fork("wind"));
  tbb::parallel_for(std::size_t{0}, leaves.size(), [&](std::size_t i) {
    Instance& instance = scene.instances[leaves[i].place];
    instance.motion = rigid_sway(sway, wind, instance.world_from_object, leaves[i].blade_m, times_s,
                                 rng.fork("leaf").fork(i));
    std::erase_if(instance.motion, [&](const TimedPose& pose) {
      return std::none_of(times_s.begin(), times_s.end(), [&](double time_s) {
        return pose.time_s > time_s - kBefore_s - 1e-9 && pose.time_s < time_s + kAfter_s + 1e-9;
      });
    });
  });
}

}  // namespace cousin
