#include "scenes/apples/tree_wind.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>

#include "scenes/apples/orchard_ground.h"
#include "sim/plant/organ_surface.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kSample_s = 0.02;
constexpr double kBefore_s = 0.06, kAfter_s = 0.20;  // about a view: exposures and readouts

/// A section of a stem of a branch.
using Section = std::tuple<int, int, int>;

Section section_of(const AppleTree& tree, const BranchPlace& place) {
  if (place.branch < 0) return {-1, 0, 0};
  const BendingPlant& plant = tree.branches[static_cast<std::size_t>(place.branch)].plant;
  const int segments = plant.stems[static_cast<std::size_t>(place.stem)].segments;
  return {place.branch, place.stem, static_cast<int>(place.share * segments + 0.5)};
}

/// Share of a line's length at its point nearest to `p`.
double nearest_share(const CentreLine& line, const Vector3d& p) {
  double best = 1e9, share_m = 0, along_m = 0;
  for (std::size_t i = 1; i < line.points_m.size(); ++i) {
    const Vector3d &a = line.points_m[i - 1], ab = line.points_m[i] - a;
    const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
    if (const double off = (a + t * ab - p).norm(); off < best) {
      best = off;
      share_m = along_m + t * ab.norm();
    }
    along_m += ab.norm();
  }
  return share_m / along_m;
}

/// What carries a triangle of the wood's mesh.
BranchPlace place_of_triangle(const AppleTree& tree, int axis, const Vector3d& middle_m) {
  const WoodAxis& wood = tree.wood[static_cast<std::size_t>(axis)];
  const bool is_branch = wood.kind == WoodKind::branch;
  return place_on_branch(tree, axis, is_branch ? nearest_share(wood.line, middle_m) : 0.5);
}

/// The triangles of a mesh that are listed, with the vertices and parts that they use.
WoodPiece piece_of(const ObjectModel& wood, const std::vector<std::size_t>& triangles,
                   const std::vector<int>& part_materials) {
  WoodPiece piece;
  ObjectModel& model = piece.model;
  model.name = wood.name;
  std::map<std::uint32_t, std::uint32_t> vertices;
  std::map<std::uint16_t, std::uint16_t> parts;
  for (const std::size_t t : triangles) {
    std::array<std::uint32_t, 3> own{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = wood.mesh.triangles[t][k];
      const auto [at, is_new] =
          vertices.emplace(v, static_cast<std::uint32_t>(model.mesh.vertices_m.size()));
      if (is_new) {
        model.mesh.vertices_m.push_back(wood.mesh.vertices_m[v]);
        model.vertex_normals.push_back(wood.vertex_normals[v]);
        model.vertex_albedo.push_back(wood.vertex_albedo[v]);
      }
      own[k] = at->second;
    }
    model.mesh.triangles.push_back({own[0], own[1], own[2]});
    const std::uint16_t part = wood.triangle_part[t];
    const auto [at, is_new] =
        parts.emplace(part, static_cast<std::uint16_t>(model.part_names.size()));
    if (is_new) {
      model.part_names.push_back(wood.part_names[part]);
      piece.part_materials.push_back(part_materials[part]);
    }
    model.triangle_part.push_back(at->second);
  }
  return piece;
}

/// Times of a view's frames: the motion begins `start_s`, and is looked at from `from_s` on.
struct ViewSpan {
  double start_s = 0, from_s = 0, seconds = 0;
};
ViewSpan span_of(const View& view, double lead_s) {
  const double from_s = view.time_s - kBefore_s;
  return {from_s - lead_s, from_s, lead_s + kBefore_s + kAfter_s};
}

/// A branch with its leaves and fruits in the air. The leaves' weight is in the shape at rest.
BendingPlant in_the_air(const GrownTree& grown, int branch, const OrchardConfig::Sway& c) {
  BendingPlant plant = grown.tree.branches[static_cast<std::size_t>(branch)].plant;
  for (BendingLoad& load : plant.loads) {
    double radius_m = 0;
    for (const Vector3d& p : load.hulls.at(0).vertices_m) radius_m = std::max(radius_m, p.norm());
    load.drag_area_m2 = c.fruit_drag * std::numbers::pi * radius_m * radius_m;
  }
  const BendingStem& stem = plant.stems.front();
  std::vector<double> area_m2(static_cast<std::size_t>(stem.segments) + 1, 0);
  for (const LeafPlace& leaf : grown.tree.leaves) {
    const BranchPlace at = place_on_branch(grown.tree, leaf.axis, leaf.share);
    if (at.branch != branch) continue;
    const double share =
        at.stem == 0 ? at.share : plant.stems[static_cast<std::size_t>(at.stem)].parent_share;
    area_m2[static_cast<std::size_t>(share * stem.segments + 0.5)] +=
        surface_area_m2(grown.leaves[static_cast<std::size_t>(leaf.variant)].model.mesh);
  }
  constexpr double kNone_kg = 1e-6;
  for (std::size_t i = 1; i < area_m2.size(); ++i) {
    if (!(area_m2[i] > 0)) continue;
    BendingLoad leaves;
    leaves.share = static_cast<double>(i) / stem.segments;
    leaves.mass_kg = kNone_kg;
    leaves.centroid_m = point_at_m(stem, leaves.share);
    leaves.drag_area_m2 = c.leaf_drag * area_m2[i];
    plant.loads.push_back(std::move(leaves));
  }
  return plant;
}

HandPush hand_of(const ApplesSceneConfig& config, double begin_s) {
  const BranchPush& p = config.push;
  HandPush hand;
  hand.share = p.share;
  hand.force_n = p.force_n * Vector3d(std::cos(p.elevation_rad) * std::cos(p.azimuth_rad),
                                      std::cos(p.elevation_rad) * std::sin(p.azimuth_rad),
                                      std::sin(p.elevation_rad));
  hand.seconds = p.seconds;
  hand.begin_s = begin_s;
  return hand;
}

[[noreturn]] void refuse(const HangingBranch& branch, int number, const ApplesSceneConfig& config,
                         const SwayResult& result) {
  const std::string what = "apples: branch " + std::to_string(number) + " of " +
                           std::to_string(branch.fruits.size()) + " fruits in a wind of " +
                           std::to_string(config.wind.mean_speed_m_s) + " m/s, pushed with " +
                           std::to_string(number == config.push.branch ? config.push.force_n : 0) +
                           " N: " + std::string(to_string(result.status)) + ", stress " +
                           std::to_string(result.strain.ratio) +
                           " times orchard.branch.strength_pa " + result.first_warning;
  if (result.status == PlantStatus::broke) throw std::invalid_argument(what);
  throw std::runtime_error(what);
}

/// How a branch is bent at the times of all views.
std::vector<BentPlant> frames_of(const Scene& scene, const ApplesSceneConfig& config,
                                 const GrownTree& grown, int number, const Rng& rng) {
  const OrchardConfig::Sway& c = config.orchard.sway;
  const HangingBranch& branch = grown.tree.branches[static_cast<std::size_t>(number)];
  const BendingPlant plant = in_the_air(grown, number, c);
  std::vector<BentPlant> frames;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const ViewSpan span = span_of(scene.views[v], c.lead_s);
    std::vector<HandPush> hands;
    if (config.push.force_n > 0 && number == config.push.branch &&
        static_cast<int>(v) == config.push.view)
      hands.push_back(
          hand_of(config, scene.views[v].time_s - span.start_s - 0.5 * config.push.seconds));
    SwayConfig sway_config;
    sway_config.step_s = c.step_s;
    sway_config.sample_s = kSample_s;
    sway_config.duration_s = span.seconds;
    sway_config.wind = config.wind;
    // The gusts of a view are the same for all branches.
    const SwayResult result = sway(plant, branch.rest, hands, sway_config, rng.fork(v));
    if (result.status != PlantStatus::ok) refuse(branch, number, config, result);
    for (const BentPlant& frame : result.frames) {
      if (frame.time_s < span.from_s - span.start_s - 0.5 * kSample_s) continue;
      frames.push_back(frame);
      frames.back().time_s += span.start_s;
    }
  }
  return frames;
}

/// Motions of the sections of all branches, relative to how they hang at rest.
class SectionMotions {
 public:
  SectionMotions(const AppleTree& tree, std::vector<std::vector<BentPlant>> frames)
      : tree_(tree), frames_(std::move(frames)) {}

  std::vector<TimedPose> of(const BranchPlace& place, const Pose& at_rest) {
    if (place.branch < 0) return {};
    std::vector<TimedPose> motion = from_rest(place);
    for (TimedPose& step : motion) step.world_from_object = step.world_from_object * at_rest;
    return motion;
  }

 private:
  const std::vector<TimedPose>& from_rest(const BranchPlace& place) {
    std::vector<TimedPose>& motion = known_[section_of(tree_, place)];
    if (!motion.empty()) return motion;
    const HangingBranch& branch = tree_.branches[static_cast<std::size_t>(place.branch)];
    const Pose unbent_from_rest =
        inverse(bent_from_unbent(branch.plant, branch.rest, place.stem, place.share));
    motion = motion_of(branch.plant, frames_[static_cast<std::size_t>(place.branch)], place.stem,
                       place.share, unbent_from_rest);
    return motion;
  }

  const AppleTree& tree_;
  std::vector<std::vector<BentPlant>> frames_;  ///< of each branch; none where nothing moves it
  std::map<Section, std::vector<TimedPose>> known_;
};

void check_hand(const ApplesSceneConfig& config, const AppleTree& tree) {
  if (tree.branches.empty() || !tree.rest.is_bent) {
    throw std::invalid_argument(
        "apples: wind and push move branches that hang by physics: sag must be true, and the "
        "program built with MuJoCo (WITH_MUJOCO)");
  }
  if (!(config.push.force_n > 0)) return;
  const auto require = [](const char* key, int value, std::size_t count) {
    if (value < static_cast<int>(count)) return;
    throw std::invalid_argument("apples: " + std::string(key) + " is " + std::to_string(value) +
                                "; there are " + std::to_string(count) + ", from 0");
  };
  require("push.branch", config.push.branch, tree.branches.size());
  require("push.view", config.push.view, static_cast<std::size_t>(config.views));
}

}  // namespace

std::vector<WoodPiece> cut_wood(const AppleTree& tree, const ObjectModel& wood,
                                const std::vector<int>& part_materials) {
  std::map<Section, std::vector<std::size_t>> triangles;
  std::map<Section, BranchPlace> places;
  triangles[{-1, 0, 0}];
  for (std::size_t t = 0; t < wood.mesh.triangles.size(); ++t) {
    const auto& corners = wood.mesh.triangles[t];
    Vector3d middle_m = Vector3d::Zero();
    for (const std::uint32_t v : corners) middle_m += wood.mesh.vertices_m[v] / 3;
    const BranchPlace place = place_of_triangle(tree, wood.triangle_part[t], middle_m);
    const Section section = section_of(tree, place);
    triangles[section].push_back(t);
    places.emplace(section, place);
  }
  std::vector<WoodPiece> pieces;
  for (const auto& [section, list] : triangles) {
    pieces.push_back(piece_of(wood, list, part_materials));
    pieces.back().place = places[section];
  }
  return pieces;
}

void sway_tree(Scene& scene, const ApplesSceneConfig& config, const GrownTree& grown,
               const TreeInstances& where, const Rng& rng) {
  const bool blows = config.wind.mean_speed_m_s > 0;
  if (!blows && !(config.push.force_n > 0)) return;
  const AppleTree& tree = grown.tree;
  check_hand(config, tree);
  std::vector<std::vector<BentPlant>> frames(tree.branches.size());
  tbb::parallel_for(std::size_t{0}, frames.size(), [&](std::size_t i) {
    const int number = static_cast<int>(i);
    if (blows || number == config.push.branch)
      frames[i] = frames_of(scene, config, grown, number, rng);
  });
  SectionMotions motions(tree, std::move(frames));
  for (std::size_t i = 0; i < tree.leaves.size(); ++i) {
    const LeafPlace& leaf = tree.leaves[i];
    Instance& instance = scene.instances[where.first_leaf + i];
    instance.motion =
        motions.of(place_on_branch(tree, leaf.axis, leaf.share), instance.world_from_object);
  }
  for (std::size_t i = 0; i < tree.fruits.size(); ++i) {
    const BranchPlace place = place_on_branch(tree, tree.fruits[i]);
    for (std::size_t part = 0; part < 3; ++part) {  // flesh, calyx, stalk
      Instance& instance = scene.instances[where.fruits[i] + part];
      instance.motion = motions.of(place, instance.world_from_object);
    }
  }
  // The trunk's piece stays where the wood was, with all that is said of it.
  const Instance wood = scene.instances[where.wood];
  std::vector<WoodPiece> pieces =
      cut_wood(tree, scene.models[static_cast<std::size_t>(wood.model)], wood.part_materials);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    WoodPiece& piece = pieces[i];
    if (i == 0) {
      scene.models[static_cast<std::size_t>(wood.model)] = std::move(piece.model);
      scene.instances[where.wood].part_materials = std::move(piece.part_materials);
      continue;
    }
    const std::string name = piece.model.part_names.front() + " piece " + std::to_string(i);
    scene.models.push_back(std::move(piece.model));
    Instance& instance =
        add_instance(scene, name, "tree", static_cast<int>(scene.models.size()) - 1, kAppleBarkLook,
                     wood.world_from_object);
    instance.part_materials = std::move(piece.part_materials);
    instance.motion = motions.of(piece.place, wood.world_from_object);
  }
}

}  // namespace cousin
