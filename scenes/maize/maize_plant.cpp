#include "scenes/maize/maize_plant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <stdexcept>

#include "scenes/maize/maize_leaves.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/plant/color.h"
#include "sim/plant/growth.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

MaizeIndividual draw_individual(const MaizeConfig& c, Rng rng) {
  MaizeIndividual own;
  own.vigour = truncated_normal(rng, 1, c.plant.spread, 2.5);
  own.azimuth_rad = uniform(rng, 0, 2 * kPi);
  own.lean_rad = std::abs(truncated_normal(rng, 0, c.plant.lean_rad, 2.5));
  own.lean_azimuth_rad = uniform(rng, 0, 2 * kPi);
  own.colour_key = rng();
  const Phyllotaxis rows{own.azimuth_rad, c.plant.divergence_rad, c.plant.divergence_spread_rad};
  for (int rank = 0; rank < c.plant.leaves; ++rank) {
    Rng leaf_rng = rng.fork("leaf").fork(static_cast<std::uint64_t>(rank));
    MaizeIndividual::Leaf leaf;
    leaf.azimuth_rad = azimuth_rad(rows, rank, truncated_normal(leaf_rng, 0, 1, 2.5));
    leaf.size = truncated_normal(leaf_rng, 1, c.blade.size_spread, 2.5);
    leaf.angle = truncated_normal(leaf_rng, 1, c.blade.angle_spread, 2.5);
    leaf.droop = truncated_normal(leaf_rng, 1, c.blade.droop_spread, 2.5);
    leaf.phase_rad = uniform(leaf_rng, 0, 2 * kPi);
    leaf.twist_rad = truncated_normal(leaf_rng, 0, c.blade.twist_rad, 2);
    own.leaves.push_back(leaf);
  }
  return own;
}

/// Radius of the full stalk at a leaf's node.
double full_radius_m(const MaizeConfig& c, int rank) {
  const int lowest = c.stalk.long_rank;
  const double up = std::clamp(
      static_cast<double>(rank - lowest) / std::max(1, c.plant.leaves - lowest), 0.0, 1.0);
  return c.stalk.radius_m + up * (c.stalk.radius_tip_m - c.stalk.radius_m);
}

MaizeStalk grow_stalk(const MaizeConfig& c, const MaizeIndividual& own, double stage) {
  MaizeStalk stalk;
  stalk.youth =
      c.stalk.young_share +
      (1 - c.stalk.young_share) * std::clamp((stage - 3) / (c.stalk.thick_stage - 3), 0.0, 1.0);
  const Vector3d lean(std::cos(own.lean_azimuth_rad), std::sin(own.lean_azimuth_rad), 0);
  Vector3d heading = (Vector3d::UnitZ() + std::tan(own.lean_rad) * lean).normalized();
  Vector3d point(0, 0, -c.stalk.depth_m);
  stalk.line.points_m.push_back(point);
  stalk.line.radii_m.push_back(c.stalk.foot_share * own.vigour * stalk.youth * full_radius_m(c, 1));
  double along_m = 0;
  for (int rank = 1; rank <= c.plant.leaves; ++rank) {
    const auto r = static_cast<std::size_t>(rank - 1);
    // A thousandth at least: nodes are apart from the first.
    const double share =
        std::max(1e-3, grown_share(stage, rank - c.stalk.begin_before, rank + c.stalk.end_after));
    const double length_m = own.vigour * share * c.stalk.internode_m[r];
    const Vector3d side(std::cos(own.leaves[r].azimuth_rad), std::sin(own.leaves[r].azimuth_rad),
                        0);
    const int steps = std::clamp(static_cast<int>(length_m / 0.015), 1, 10);
    const double radius_m = own.vigour * stalk.youth * full_radius_m(c, rank);
    const double before_m = stalk.line.radii_m.back();
    for (int i = 1; i <= steps; ++i) {
      point += length_m / steps * heading;
      stalk.line.points_m.push_back(point);
      stalk.line.radii_m.push_back(before_m + (radius_m - before_m) * i / steps);
    }
    along_m += length_m;
    stalk.nodes_m.push_back(along_m);
    // The stalk gives way to the leaf a little, and rights itself.
    heading = (heading - std::tan(c.plant.zigzag_rad) * side + c.plant.righting * Vector3d::UnitZ())
                  .normalized();
  }
  stalk.surface_m = c.stalk.depth_m / std::max(0.5, std::cos(own.lean_rad));
  return stalk;
}

/// An internode as an organ of its own, from the one line. @return its id.
int add_internode(MaizeDraft& draft, int rank, int below, std::size_t& first_point) {
  Organ& organ =
      add_organ(draft.plant, OrganKind::stem, "internode " + std::to_string(rank), below, rank);
  organ.look = kStalkLook;
  organ.age_days = draft.stage - rank + draft.config.stalk.begin_before;
  const double end_m = draft.stalk.nodes_m[static_cast<std::size_t>(rank - 1)];
  const auto& line = draft.stalk.line;
  double along_m = rank == 1 ? 0 : draft.stalk.nodes_m[static_cast<std::size_t>(rank - 2)];
  std::size_t last = first_point;
  while (last + 1 < line.points_m.size() && along_m < end_m - 1e-9) {
    along_m += (line.points_m[last + 1] - line.points_m[last]).norm();
    ++last;
  }
  const auto at = [](auto& values, std::size_t i) {
    return values.begin() + static_cast<std::ptrdiff_t>(i);
  };
  organ.line.points_m.assign(at(line.points_m, first_point), at(line.points_m, last + 1));
  organ.line.radii_m.assign(at(line.radii_m, first_point), at(line.radii_m, last + 1));
  first_point = last;
  if (length_m(organ.line) < 1e-3) {
    // Nodes lie on each other still: the crown has a place and no stem between.
    organ.line = {};
    return organ.id;
  }
  organ.line.radii_m.back() *= 1 + draft.config.stalk.swelling;
  organ.surface = tube_surface(organ.line, draft.config.surface.sides);
  const Vector3d base = maize_base(draft.config, kStalkLook);
  for (const Eigen::Vector2d& place : organ.surface.place) {
    const double node = smoothstep(0.93, 1.0, place.x());
    const Vector3d colour = (1 - node) * color_vector(draft.config.stalk.albedo) +
                            node * color_vector(draft.config.stalk.albedo_node);
    organ.albedo.push_back(to_rgb(colour.cwiseQuotient(base)));
  }
  return organ.id;
}

void add_stalk_keypoints(MaizeDraft& draft, const LineWalk& axis) {
  draft.plant.keypoints.push_back({"root", axis.at_m(draft.stalk.surface_m).point_m});
  for (int rank = 1; rank <= draft.config.plant.leaves && rank <= draft.stage + 2; ++rank) {
    const Vector3d node =
        axis.at_m(draft.stalk.nodes_m[static_cast<std::size_t>(rank - 1)]).point_m;
    if (node.z() > 0) draft.plant.keypoints.push_back({"node " + std::to_string(rank), node});
  }
}

std::vector<TrueTrait> traits_of(const MaizeDraft& draft, const LeafMaker& leaves,
                                 const LineWalk& axis) {
  int collars = 0;
  for (int rank = 1; rank <= draft.config.plant.leaves; ++rank) collars += leaves.has_collar(rank);
  std::vector<TrueTrait> traits = {
      {"height", "m", height_m(draft.plant)},
      {"leaf_count", "1", static_cast<double>(collars)},
      {"visible_leaf_count", "1", static_cast<double>(leaf_count(draft.plant))},
      {"leaf_area", "m2", leaf_area_m2(draft.plant)},
      {"stalk_diameter", "m",
       2 * axis.at_m(draft.stalk.surface_m + draft.config.stalk.diameter_at_m).radius_m}};
  for (int rank = 2; rank <= draft.config.plant.leaves && rank <= draft.stage + 2; ++rank) {
    const double low_m = draft.stalk.nodes_m[static_cast<std::size_t>(rank - 2)];
    const double high_m = draft.stalk.nodes_m[static_cast<std::size_t>(rank - 1)];
    if (axis.at_m(low_m).point_m.z() <= 0) continue;
    char name[24];
    std::snprintf(name, sizeof name, "internode_%02d", rank);
    traits.push_back({name, "m", high_m - low_m});
  }
  for (const Organ& organ : draft.plant.organs) {
    if (organ.kind != OrganKind::blade || !leaves.has_collar(organ.rank)) continue;
    char name[24];
    std::snprintf(name, sizeof name, "leaf_angle_%02d", organ.rank);
    traits.push_back({name, "rad", insertion_angle_rad(draft.plant, organ)});
  }
  return traits;
}

}  // namespace

double grown_share(double stage, double begin, double end) {
  return size_at({1, end - begin, 0.5 * (end - begin)}, stage - begin);
}

Vector3d maize_base(const MaizeConfig& c, MaizeLook look) {
  const auto brightest = [](std::initializer_list<const std::vector<double>*> colours) {
    Vector3d most = Vector3d::Zero();
    for (const std::vector<double>* colour : colours) most = most.cwiseMax(color_vector(*colour));
    return most;
  };
  switch (look) {
    case kStalkLook:
      return brightest({&c.stalk.albedo, &c.stalk.albedo_node, &c.sheath.albedo,
                        &c.sheath.albedo_low, &c.sheath.ligule_albedo, &c.blade.albedo_dry,
                        &c.root.albedo, &c.flower.ear_albedo});
    case kBladeLook:
      return brightest(
          {&c.blade.albedo, &c.blade.albedo_midrib, &c.blade.albedo_young, &c.blade.albedo_dry});
    case kFlowerLook:
      return brightest({&c.flower.albedo, &c.flower.silk_albedo});
  }
  return Vector3d::Ones();
}

void finish_tube(const MaizeConfig& config, Organ& organ, int sides,
                 const std::vector<double>& albedo) {
  organ.surface = tube_surface(organ.line, sides);
  const Vector3d base = maize_base(config, static_cast<MaizeLook>(organ.look));
  organ.albedo.assign(organ.surface.mesh.vertices_m.size(),
                      to_rgb(color_vector(albedo).cwiseQuotient(base)));
}

MaizePlant grow_maize(const MaizeConfig& config, double stage, Rng rng) {
  validate(config);
  if (!(stage >= 3 && stage <= config.plant.leaves + 1)) {
    throw std::invalid_argument("stage = " + std::to_string(stage) + " is not in [3, " +
                                std::to_string(config.plant.leaves + 1) + "] (V3 .. VT)");
  }
  const MaizeIndividual own = draw_individual(config, rng);
  MaizeDraft draft{config, own, stage, grow_stalk(config, own, stage), {}};
  draft.plant.name = "maize";
  const LineWalk axis(draft.stalk.line, Vector3d::UnitX());
  add_stalk_keypoints(draft, axis);
  LeafMaker leaves(draft, axis);
  std::size_t point = 0;
  int below = -1;
  for (int rank = 1; rank <= config.plant.leaves; ++rank) {
    below = add_internode(draft, rank, below, point);
    leaves.add(rank, below);
  }
  add_prop_roots(draft, axis);
  add_tassel(draft);
  add_ear(draft, axis);
  MaizePlant result;
  result.traits = traits_of(draft, leaves, axis);
  result.plant = std::move(draft.plant);
  return result;
}

std::vector<Material> maize_materials(const MaizeConfig& config) {
  const auto& s = config.surface;
  Material stalk;
  stalk.name = "maize stalk";
  stalk.albedo = to_rgb(maize_base(config, kStalkLook));
  stalk.roughness = s.stem_roughness;
  Material blade;
  blade.name = "maize leaf";
  blade.kind = SurfaceKind::leaf;
  blade.albedo = to_rgb(maize_base(config, kBladeLook));
  blade.back_albedo =
      to_rgb(color_vector(config.blade.albedo_back).cwiseMax(maize_base(config, kBladeLook)));
  blade.transmittance = to_rgb(color_vector(config.blade.transmittance));
  blade.roughness = s.leaf_roughness;
  blade.infrared_transmittance = static_cast<float>(s.infrared_transmittance);
  Material flower;
  flower.name = "maize tassel";
  flower.albedo = to_rgb(maize_base(config, kFlowerLook));
  flower.roughness = 0.8;
  std::vector<Material> materials = {stalk, blade, flower};
  for (Material& m : materials) {
    m.ior = s.ior;
    m.infrared_albedo = static_cast<float>(s.infrared_albedo);
  }
  return materials;
}

}  // namespace cousin
