#include "scenes/maize/maize_plant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <numbers>
#include <stdexcept>

#include "scenes/maize/maize_grower.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/plant/growth.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

Vector3d vec(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }
Rgbf rgb(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

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
    leaf.size = truncated_normal(leaf_rng, 1, 0.05, 2.5);
    leaf.angle = truncated_normal(leaf_rng, 1, 0.14, 2.5);
    leaf.droop = truncated_normal(leaf_rng, 1, 0.15, 2.5);
    leaf.phase_rad = uniform(leaf_rng, 0, 2 * kPi);
    leaf.twist_rad = truncated_normal(leaf_rng, 0, c.blade.twist_rad, 2);
    own.leaves.push_back(leaf);
  }
  return own;
}

/// Radius of the full stalk at a leaf's node.
double full_radius_m(const MaizeConfig& c, int rank) {
  const double up = std::clamp((rank - 6.0) / std::max(1, c.plant.leaves - 6), 0.0, 1.0);
  return c.stalk.radius_m + up * (c.stalk.radius_tip_m - c.stalk.radius_m);
}

MaizeStalk grow_stalk(const MaizeConfig& c, const MaizeIndividual& own, double stage) {
  MaizeStalk stalk;
  stalk.youth =
      c.stalk.young_share + (1 - c.stalk.young_share) * std::clamp((stage - 3) / 8, 0.0, 1.0);
  const Vector3d lean(std::cos(own.lean_azimuth_rad), std::sin(own.lean_azimuth_rad), 0);
  Vector3d heading = (Vector3d::UnitZ() + std::tan(own.lean_rad) * lean).normalized();
  Vector3d point(0, 0, -c.stalk.depth_m);
  stalk.line.points_m.push_back(point);
  stalk.line.radii_m.push_back(0.8 * stalk.youth * full_radius_m(c, 1));
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
    const double radius_m = stalk.youth * full_radius_m(c, rank);
    const double before_m = stalk.line.radii_m.back();
    for (int i = 1; i <= steps; ++i) {
      point += length_m / steps * heading;
      stalk.line.points_m.push_back(point);
      stalk.line.radii_m.push_back(before_m + (radius_m - before_m) * i / steps);
    }
    along_m += length_m;
    stalk.nodes_m.push_back(along_m);
    // The stalk gives way to the leaf a little, and rights itself.
    heading =
        (heading - std::tan(c.plant.zigzag_rad) * side + 0.15 * Vector3d::UnitZ()).normalized();
  }
  stalk.surface_m = c.stalk.depth_m / std::max(0.5, std::cos(own.lean_rad));
  return stalk;
}

/// Makes the leaves of a draft whose stalk has grown.
class LeafMaker {
 public:
  LeafMaker(MaizeDraft& draft, const LineWalk& axis) : d_(draft), c_(draft.config), axis_(axis) {
    for (int rank = 1; rank <= c_.plant.leaves; ++rank) {
      if (rank <= d_.stage) top_collar_m_ = std::max(top_collar_m_, collar_m(rank));
    }
  }

  /// Sheath, ligule and blade on the internode `parent`.
  void add(int rank, int parent) {
    const std::string number = std::to_string(rank);
    const int sheath = add_organ(d_.plant, OrganKind::sheath, "sheath " + number, parent, rank).id;
    grow_sheath(d_.plant.organs.back());
    add_organ(d_.plant, OrganKind::ligule, "ligule " + number, sheath, rank);
    grow_ligule(d_.plant.organs.back());
    add_organ(d_.plant, OrganKind::blade, "leaf " + number, sheath, rank);
    grow_blade(d_.plant.organs.back());
  }

  bool has_collar(int rank) const { return rank <= d_.stage && !has_fallen(rank); }

 private:
  double sheath_share(int rank) const { return grown_share(d_.stage, rank - 1.6, rank); }
  double sheath_m(int rank) const {
    return d_.own.vigour * sheath_share(rank) *
           c_.sheath.length_m[static_cast<std::size_t>(rank - 1)];
  }
  double node_m(int rank) const { return d_.stalk.nodes_m[static_cast<std::size_t>(rank - 1)]; }
  /// Along the axis.
  double collar_m(int rank) const { return node_m(rank) + sheath_m(rank); }
  double dryness(int rank) const {
    if (rank > c_.blade.last_to_fall) return 0;
    return logistic(d_.stage, rank + c_.blade.dry_after, 0.5);
  }
  bool has_fallen(int rank) const {
    return rank <= c_.blade.last_to_fall && d_.stage > rank + c_.blade.fall_after;
  }

  /// What the sheath of `rank` wraps at a place along the axis: stalk, or the whorl above it, and
  /// younger sheaths; and itself.
  double wrapped_m(int rank, double along_m) const {
    double radius = axis_.at_m(along_m).radius_m;
    if (along_m > axis_.length_m()) {
      const double above = (along_m - axis_.length_m()) / 0.15;
      radius = std::max(radius, d_.stalk.youth * 0.6 * c_.stalk.radius_m) *
               (1 - 0.25 * std::min(1.0, above));
    }
    double swelling = 0;
    for (int other = rank; other <= c_.plant.leaves; ++other) {
      swelling = std::max(swelling, std::exp(-std::pow((along_m - node_m(other)) / 0.007, 2)));
      if (along_m >= node_m(other) && along_m <= collar_m(other) + 1e-9)
        radius += c_.sheath.thickness_m;
    }
    return radius * (1 + c_.stalk.swelling * swelling);
  }

  CentreLine along_axis(int rank, double from_m, double to_m, int steps, double wider_m) const {
    CentreLine line;
    for (int i = 0; i <= steps; ++i) {
      const double along_m = from_m + (to_m - from_m) * i / steps;
      line.points_m.push_back(axis_.at_m(along_m).point_m);
      line.radii_m.push_back(wrapped_m(rank, along_m) + wider_m);
    }
    return line;
  }

  void grow_sheath(Organ& organ) const {
    organ.look = kStalkLook;
    organ.age_days = d_.stage - organ.rank;
    const double length_m = sheath_m(organ.rank);
    if (length_m < 2e-3) return;
    const double base_m = node_m(organ.rank);
    organ.line = along_axis(organ.rank, base_m, base_m + length_m, 12, 0);
    organ.surface = tube_surface(organ.line, c_.surface.sides);
    const double low = std::clamp(1.3 - organ.rank / 5.0, 0.0, 1.0), dry = dryness(organ.rank);
    Vector3d colour = (1 - low) * vec(c_.sheath.albedo) + low * vec(c_.sheath.albedo_low);
    colour = (1 - dry) * colour + dry * vec(c_.blade.albedo_dry);
    for (const Eigen::Vector2d& place : organ.surface.place) {
      const double streak =
          1 + 0.25 * noise3(Vector3d(3 * place.x(), 40 * place.y(), organ.rank), d_.own.colour_key);
      organ.albedo.push_back(rgb((streak * colour)
                                     .cwiseQuotient(maize_base(c_, kStalkLook))
                                     .cwiseMin(1.0)
                                     .cwiseMax(0.02)));
    }
  }

  void grow_ligule(Organ& organ) const {
    organ.look = kStalkLook;
    organ.age_days = d_.stage - organ.rank;
    if (!has_collar(organ.rank)) return;
    const double top_m = collar_m(organ.rank);
    organ.line = along_axis(organ.rank, top_m - c_.sheath.ligule_m, top_m, 3, 3e-4);
    finish_tube(c_, organ, c_.surface.sides, c_.sheath.ligule_albedo);
    d_.plant.keypoints.push_back(
        {"collar " + std::to_string(organ.rank), axis_.at_m(top_m).point_m});
  }

  BladeShape shape_of(int rank, double out, double length_share) const {
    const auto r = static_cast<std::size_t>(rank - 1);
    const auto& b = c_.blade;
    const MaizeIndividual::Leaf& own = d_.own.leaves[r];
    const double widest_m = *std::max_element(b.width_m.begin(), b.width_m.end());
    BladeShape shape;
    shape.width_m = d_.own.vigour * own.size * b.width_m[r] * (0.35 + 0.65 * length_share);
    shape.envelope_base = b.outline[0];
    shape.envelope_peak = b.outline[1];
    shape.envelope_rise = b.outline[2];
    shape.envelope_fall = b.outline[3];
    shape.envelope_tip = b.outline[4];
    shape.fold_rad = (1 - out) * 1.25 + out * b.fold_rad;
    shape.camber = -b.camber * out;
    shape.wave_m = b.wave_m * out * shape.width_m / widest_m;
    shape.wave_count = b.wave_count * std::max(0.3, length_share);
    shape.wave_phase_rad = own.phase_rad;
    shape.twist_rad = out * own.twist_rad;
    return shape;
  }

  void grow_blade(Organ& organ) const {
    const int rank = organ.rank;
    const auto r = static_cast<std::size_t>(rank - 1);
    const auto& b = c_.blade;
    const MaizeIndividual::Leaf& own = d_.own.leaves[r];
    organ.look = kBladeLook;
    organ.age_days = d_.stage - rank + b.tips_ahead;
    const double share = grown_share(d_.stage, rank - b.tips_ahead - 1, rank);
    if (share < 0.03 || has_fallen(rank)) return;
    // Out of the whorl, and leaned out to its final angle.
    const double out = grown_share(d_.stage, rank - 1.8, rank + 0.8), dry = dryness(rank);
    const double base_m = std::max(collar_m(rank), top_collar_m_ * (rank > d_.stage) - 0.02);
    const LinePoint base = axis_.at_m(base_m);
    const Vector3d side =
        (Vector3d(std::cos(own.azimuth_rad), std::sin(own.azimuth_rad), 0) -
         base.axes.col(0) * base.axes.col(0).dot(
                                Vector3d(std::cos(own.azimuth_rad), std::sin(own.azimuth_rad), 0)))
            .normalized();
    const double up = (rank - 1.0) / (c_.plant.leaves - 1);
    const double angle = (0.06 + 0.94 * out) * own.angle *
                             (b.angle_low_rad + up * (b.angle_high_rad - b.angle_low_rad)) +
                         0.8 * dry;
    AxisGrowth growth;
    growth.start_m = base.point_m + (0.15 + 0.75 * out) * wrapped_m(rank, base_m) * side;
    growth.heading = (std::cos(angle) * base.axes.col(0) + std::sin(angle) * side).normalized();
    growth.length_m = std::max(4e-3, d_.own.vigour * own.size * share * b.length_m[r]);
    growth.radius_base_m = 0.0032 * std::sqrt(b.length_m[r] / 0.8);
    growth.radius_tip_m = 0.0004;
    growth.segments = 40;
    // Long leaves hang over; what still stands in the whorl is stiff.
    const double droop =
        b.droop_rad * own.droop * std::min(1.1, growth.length_m / 0.7) * (0.12 + 0.88 * out) +
        1.5 * dry;
    growth.tropisms.push_back({-Vector3d::UnitZ(), droop, b.droop_begin});
    organ.line = grow_axis(growth);
    const BladeShape shape = shape_of(rank, out, share);
    const Vector3d upper = std::sin(angle) * base.axes.col(0) - std::cos(angle) * side;
    const int rows = std::clamp(static_cast<int>(growth.length_m / c_.surface.detail_m), 10, 120);
    organ.surface = blade_surface(LineWalk(organ.line, upper), shape, rows, c_.surface.columns);
    colour_blade(organ, out, dry);
    d_.plant.keypoints.push_back({"tip " + std::to_string(rank), organ.line.points_m.back()});
  }

  void colour_blade(Organ& organ, double out, double dry) const {
    const auto& b = c_.blade;
    const Vector3d base = maize_base(c_, kBladeLook);
    for (const Eigen::Vector2d& place : organ.surface.place) {
      const double s = place.x(), t = std::abs(place.y());
      const double rib = 1 - smoothstep(0.6, 1.4, t / (b.midrib_share * (1.15 - s) + 1e-3));
      // Young and rolled: paler towards the base.
      const double young = (1 - out) * (0.45 + 0.55 * (1 - s));
      Vector3d colour = (1 - young) * vec(b.albedo) + young * vec(b.albedo_young);
      // Dries from the tip and the margins.
      const double dead = std::clamp(
          dry * 1.5 +
              0.5 * noise3(Vector3d(4 * s, 2 * place.y(), organ.rank), d_.own.colour_key) * dry,
          0.0, 1.0);
      const double streak = 1 + 0.22 * noise3(Vector3d(2 * s, 12 * place.y(), 3.0 * organ.rank),
                                              d_.own.colour_key + 1);
      colour = (1 - rib) * streak * colour + rib * vec(b.albedo_midrib);
      colour = (1 - dead) * colour + dead * vec(b.albedo_dry);
      organ.albedo.push_back(rgb(colour.cwiseQuotient(base).cwiseMin(1.0).cwiseMax(0.02)));
    }
  }

  MaizeDraft& d_;
  const MaizeConfig& c_;
  const LineWalk& axis_;
  double top_collar_m_ = 0;  ///< of the highest collar, along the axis
};

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
    const Vector3d colour =
        (1 - node) * vec(draft.config.stalk.albedo) + node * vec(draft.config.stalk.albedo_node);
    organ.albedo.push_back(rgb(colour.cwiseQuotient(base)));
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
      {"stalk_diameter", "m", 2 * axis.at_m(draft.stalk.surface_m + 0.02).radius_m}};
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
    for (const std::vector<double>* colour : colours) most = most.cwiseMax(vec(*colour));
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
  organ.albedo.assign(organ.surface.mesh.vertices_m.size(), rgb(vec(albedo).cwiseQuotient(base)));
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
  stalk.albedo = rgb(maize_base(config, kStalkLook));
  stalk.roughness = s.stem_roughness;
  Material blade;
  blade.name = "maize leaf";
  blade.kind = SurfaceKind::leaf;
  blade.albedo = rgb(maize_base(config, kBladeLook));
  blade.back_albedo = rgb(vec(config.blade.albedo_back).cwiseMax(maize_base(config, kBladeLook)));
  blade.transmittance = rgb(vec(config.blade.transmittance));
  blade.roughness = s.leaf_roughness;
  blade.infrared_transmittance = static_cast<float>(s.infrared_transmittance);
  Material flower;
  flower.name = "maize tassel";
  flower.albedo = rgb(maize_base(config, kFlowerLook));
  flower.roughness = 0.8;
  std::vector<Material> materials = {stalk, blade, flower};
  for (Material& m : materials) {
    m.ior = s.ior;
    m.infrared_albedo = static_cast<float>(s.infrared_albedo);
  }
  return materials;
}

}  // namespace cousin
