#include "scenes/strawberries/strawberry_plant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/strawberries/leaf_crowd.h"
#include "scenes/strawberries/strawberry_leaf.h"
#include "sim/geometry/gradient_noise.h"
#include "sim/plant/color.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
constexpr int kFlowers = 3;
constexpr int kDaughterLeaves = 3;

class Grower {
 public:
  Grower(const StrawberryPlantConfig& config, const IsFree& is_free, Rng rng, LeafCrowd& crowd,
         const Vector3d& at_m)
      : c_(config), coarse_(config), is_free_(is_free), rng_(rng), crowd_(crowd), at_m_(at_m) {
    coarse_.surface.rows = std::min(coarse_.surface.rows, 18);
    coarse_.surface.columns = std::min(coarse_.surface.columns, 4);
    coarse_.leaf.teeth = 0;
  }

  Plant grow() {
    plant_.name = "strawberry plant";
    crown();
    Rng own = rng_.fork("plant");
    const int span = c_.leaf.count_max - c_.leaf.count_min + 1;
    const int leaves =
        c_.leaf.count_min + static_cast<int>(uniform_index(own, static_cast<std::uint64_t>(span)));
    const double first_rad = uniform(own, 0, 2 * kPi);
    const double vigour = truncated_normal(own, 1, c_.leaf.vigour_spread, 2);
    const Vector3d top(0, 0, c_.leaf.foot_share * c_.crown.height_m);
    for (int i = 0; i < c_.leaf.count_max; ++i) {
      const std::array<int, 4> ids = add_leaf("leaf " + std::to_string(i + 1), 0, i + 1);
      if (i >= leaves) continue;
      const double age = leaves > 1 ? 1 - static_cast<double>(i) / (leaves - 1) : 0.5;
      const double azimuth = first_rad + i * c_.leaf.divergence_rad;
      grow_leaf(ids, top, age, azimuth, vigour,
                rng_.fork("leaf").fork(static_cast<std::uint64_t>(i)), true);
    }
    flowers();
    runner();
    return std::move(plant_);
  }

 private:
  void crown() {
    Organ& organ = add_organ(plant_, OrganKind::stem, "crown", -1, 0);
    organ.look = kBerryCrownLook;
    organ.age_days = 1;
    const double r = c_.crown.radius_m, h = c_.crown.height_m;
    organ.line.points_m = {{0, 0, -0.01}, {0, 0, 0}, {0, 0, 0.4 * h}, {0, 0, 0.8 * h}, {0, 0, h}};
    organ.line.radii_m = {0.8 * r, r, 1.05 * r, 0.8 * r, 0.4 * r};
    organ.surface = tube_surface(organ.line, 14);
    plant_.keypoints.push_back({"crown", Vector3d::Zero()});
  }

  /// Places of a leaf's organs: petiole, middle, left and right leaflet.
  std::array<int, 4> add_leaf(const std::string& name, int parent, int rank) {
    const int petiole = add_organ(plant_, OrganKind::petiole, name + " petiole", parent, rank).id;
    std::array<int, 4> ids{petiole};
    constexpr std::array<const char*, 3> kNames = {"middle", "left", "right"};
    for (std::size_t k = 0; k < 3; ++k) {
      Organ& blade = add_organ(plant_, OrganKind::blade, name + " " + kNames[k], petiole, rank);
      blade.look = kBerryLeafletLook;
      ids[k + 1] = blade.id;
    }
    return ids;
  }

  LeafPose draw_pose(const Vector3d& base_m, double age, double azimuth, double scale, int attempt,
                     Rng rng) const {
    const auto& l = c_.leaf;
    LeafPose pose;
    pose.base_m = base_m;
    pose.age = age;
    pose.size = scale * std::lerp(l.size_youngest, 1.0, smoothstep(0.0, l.grown_age, age)) *
                truncated_normal(rng, 1, l.size_spread, 2);
    pose.azimuth_rad = azimuth + l.spread_rad * truncated_normal(rng, 0, 1, 2) +
                       0.12 * attempt * truncated_normal(rng, 0, 1, 2);
    // Leaves of the path's side lean out over the edge, and old ones hang down before the fruits.
    const double outward = std::max(0.0, std::cos(pose.azimuth_rad));
    const double lean = l.lean_rad * outward;
    pose.angle_rad = std::lerp(l.young_rad, l.old_rad, std::pow(age, l.angle_power)) + lean +
                     l.angle_spread_rad * truncated_normal(rng, 0, 1, 2);
    pose.angle_rad = std::max(0.03, pose.angle_rad * (1 - 0.04 * attempt));
    pose.petiole_m = scale * l.petiole_m *
                     (l.young_petiole + (1 - l.young_petiole) * smoothstep(0.0, l.grown_age, age)) *
                     std::lerp(1.0, l.reach, outward) * truncated_normal(rng, 1, l.cv_length, 2);
    const double hang =
        outward * std::sqrt(age) * uniform(rng, l.hang_least, 1) * (1 - 0.04 * attempt);
    pose.sag_rad = l.sag_rad * age + l.hang_rad * hang;
    pose.droop_rad = l.hang_blade * l.hang_rad * hang +
                     std::lerp(l.droop_young_rad, l.droop_old_rad, std::pow(age, l.droop_power)) +
                     l.droop_spread_rad * truncated_normal(rng, 0, 1, 2) - 0.03 * attempt;
    pose.roll_rad = l.roll_rad * truncated_normal(rng, 0, 1, 2);
    for (double& phase : pose.phases_rad) phase = uniform(rng, 0, 2 * kPi);
    pose.colour_key = rng();
    return pose;
  }

  bool is_free(const OrganSurface& part) const { return !is_free_ || is_free_(part.mesh); }

  bool is_free(const LeafOrgans& leaf) const {
    return is_free(leaf.petiole) && is_free(leaf.leaflets[0]) && is_free(leaf.leaflets[1]) &&
           is_free(leaf.leaflets[2]);
  }

  bool is_crossed(const LeafOrgans& leaf) const {
    return std::any_of(leaf.leaflets.begin(), leaf.leaflets.end(),
                       [&](const OrganSurface& l) { return crowd_.is_crossed_by(l.mesh, at_m_); });
  }

  /// @param in_crowd  a leaf of the crown, which keeps off others: coarse ones are asked first
  void grow_leaf(const std::array<int, 4>& ids, const Vector3d& base_m, double age, double azimuth,
                 double scale, const Rng& rng, bool in_crowd) {
    for (int attempt = 0; attempt < c_.surface.tries; ++attempt) {
      const LeafPose pose = draw_pose(base_m, age, azimuth, scale, attempt,
                                      rng.fork(static_cast<std::uint64_t>(attempt)));
      const LeafOrgans coarse = make_strawberry_leaf(coarse_, pose);
      if (!is_free(coarse) || (in_crowd && is_crossed(coarse))) continue;
      const LeafOrgans leaf = make_strawberry_leaf(c_, pose);
      if (!is_free(leaf)) continue;
      if (in_crowd) {
        for (const OrganSurface& leaflet : coarse.leaflets) crowd_.add(leaflet.mesh, at_m_);
      }
      set(ids, pose, leaf);
      return;
    }
  }

  void set(const std::array<int, 4>& ids, const LeafPose& pose, const LeafOrgans& leaf) {
    Organ& petiole = plant_.organs[static_cast<std::size_t>(ids[0])];
    petiole.age_days = 10 + 60 * pose.age;
    petiole.line = leaf.petiole_line;
    petiole.surface = leaf.petiole;
    for (std::size_t k = 0; k < 3; ++k) {
      Organ& blade = plant_.organs[static_cast<std::size_t>(ids[k + 1])];
      blade.age_days = petiole.age_days;
      blade.line = leaf.midribs[k];
      blade.surface = leaf.leaflets[k];
      blade.albedo = leaflet_albedo(c_, pose, leaf, k);
    }
    const std::string& name = petiole.name;
    plant_.keypoints.push_back({name + " end", leaf.petiole_line.points_m.back()});
  }

  CentreLine flower_stalk(int attempt, Rng rng) const {
    const auto& f = c_.flower;
    AxisGrowth growth;
    const double azimuth = uniform(rng, -kPi, kPi);
    const double angle =
        std::max(0.2, f.stalk_rad * truncated_normal(rng, 1, f.angle_spread, 2) - 0.04 * attempt);
    growth.start_m = {0, 0, 0.8 * c_.crown.height_m};
    growth.heading = {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                      std::cos(angle)};
    growth.length_m = f.stalk_m * truncated_normal(rng, 1, f.length_spread, 2);
    growth.radius_base_m = f.stalk_thick[0] * f.stalk_radius_m;
    growth.radius_tip_m = f.stalk_thick[1] * f.stalk_radius_m;
    growth.tropisms.push_back({-Vector3d::UnitZ(), f.stalk_sag_rad, f.sag_begin});
    return grow_axis(growth);
  }

  void flowers() {
    Rng draw = rng_.fork("flowers");
    const int count = std::min(kFlowers, static_cast<int>(poisson(draw, c_.flower.mean)));
    for (int i = 0; i < kFlowers; ++i) {
      const std::string name = "flower " + std::to_string(i + 1);
      const int stalk = add_organ(plant_, OrganKind::petiole, name + " stalk", 0, 0).id;
      const int petals = add_organ(plant_, OrganKind::flower, name + " petals", stalk, 0).id;
      const int sepals = add_organ(plant_, OrganKind::flower, name + " sepals", stalk, 0).id;
      const int middle = add_organ(plant_, OrganKind::flower, name + " middle", stalk, 0).id;
      if (i >= count) continue;
      const Rng own = rng_.fork("flower").fork(static_cast<std::uint64_t>(i));
      for (int attempt = 0; attempt < c_.surface.tries; ++attempt) {
        Rng rng = own.fork(static_cast<std::uint64_t>(attempt));
        const CentreLine line = flower_stalk(attempt, rng.fork("stalk"));
        const OrganSurface tube = tube_surface(line, c_.surface.sides);
        const std::size_t n = line.points_m.size();
        const Vector3d end = (line.points_m[n - 1] - line.points_m[n - 2]).normalized();
        // Open flowers face up and out.
        const Vector3d facing = end + c_.flower.facing_up * Vector3d::UnitZ() +
                                c_.flower.facing_out * Vector3d::UnitX();
        const FlowerOrgans head =
            make_strawberry_flower(c_, line.points_m.back(), facing, rng.fork("head"));
        if (!is_free(tube) || !is_free(head.petals)) continue;
        set_part(stalk, kBerryStalkLook, tube).line = line;
        set_part(petals, kBerryPetalLook, head.petals);
        set_part(sepals, kBerryLeafletLook, head.sepals);
        set_part(middle, kBerryReceptacleLook, head.middle).albedo = head.middle_albedo;
        plant_.keypoints.push_back({name, line.points_m.back()});
        break;
      }
    }
  }

  Organ& set_part(int id, int look, const OrganSurface& surface) {
    Organ& organ = plant_.organs[static_cast<std::size_t>(id)];
    organ.look = look;
    organ.age_days = 1;
    organ.surface = surface;
    return organ;
  }

  /// A runner over the edge with a small plant at its end.
  void runner() {
    const int id = add_organ(plant_, OrganKind::stem, "runner", 0, 0).id;
    std::array<std::array<int, 4>, kDaughterLeaves> leaves{};
    for (int i = 0; i < kDaughterLeaves; ++i)
      leaves[static_cast<std::size_t>(i)] =
          add_leaf("daughter leaf " + std::to_string(i + 1), id, i + 1);
    const Rng own = rng_.fork("runner");
    Rng draw = own.fork("share");
    if (uniform(draw) >= c_.runner.share) return;
    for (int attempt = 0; attempt < c_.surface.tries; ++attempt) {
      Rng rng = own.fork(static_cast<std::uint64_t>(attempt));
      AxisGrowth growth;
      const auto& r = c_.runner;
      const double azimuth = r.azimuth_rad * truncated_normal(rng, 0, 1, 2);
      growth.start_m = {0, 0, 0.3 * c_.crown.height_m};
      growth.heading =
          Vector3d(std::cos(azimuth), std::sin(azimuth), uniform(rng, r.rise[0], r.rise[1]));
      growth.heading.normalize();
      growth.length_m = r.length_m * truncated_normal(rng, 1, r.length_spread, 2);
      growth.radius_base_m = growth.radius_tip_m = r.radius_m;
      growth.segments = 30;
      growth.tropisms.push_back(
          {-Vector3d::UnitZ(), uniform(rng, r.sag_rad[0], r.sag_rad[1]), 0.2});
      const CentreLine line = grow_axis(growth);
      const OrganSurface tube = tube_surface(line, c_.surface.sides);
      if (!is_free(tube)) continue;
      Organ& organ = set_part(id, kBerryStalkLook, tube);
      organ.line = line;
      const Vector3d tint =
          color_vector(c_.runner.albedo).cwiseQuotient(stalk_base()).cwiseMin(1.0);
      organ.albedo.assign(tube.mesh.vertices_m.size(), to_rgb(tint));
      for (std::size_t i = 0; i < leaves.size(); ++i) {
        grow_leaf(leaves[i], line.points_m.back(), 0.25 + 0.3 * static_cast<double>(i),
                  azimuth + r.divergence_rad * static_cast<double>(i), r.leaf_share,
                  own.fork("daughter").fork(i), false);
      }
      return;
    }
  }

  Vector3d stalk_base() const {
    return color_vector(c_.leaf.petiole_albedo).cwiseMax(color_vector(c_.runner.albedo));
  }

  const StrawberryPlantConfig& c_;
  StrawberryPlantConfig coarse_;  ///< for asking whether a leaf has room
  const IsFree& is_free_;
  Rng rng_;
  LeafCrowd& crowd_;
  Vector3d at_m_;
  Plant plant_;
};

/// Petioles are a share of the stalks' colour, which runners have too.
void tint_stalks(Plant& plant, const StrawberryPlantConfig& config) {
  const Vector3d petiole = color_vector(config.leaf.petiole_albedo);
  const Vector3d base = petiole.cwiseMax(color_vector(config.runner.albedo));
  for (Organ& organ : plant.organs) {
    if (organ.look != kBerryStalkLook || !organ.albedo.empty()) continue;
    organ.albedo.assign(organ.surface.mesh.vertices_m.size(), to_rgb(petiole.cwiseQuotient(base)));
  }
}

}  // namespace

Plant grow_strawberry_plant(const StrawberryPlantConfig& config, const IsFree& is_free, Rng rng,
                            LeafCrowd* crowd, const Vector3d& at_m) {
  LeafCrowd own;
  Plant plant = Grower(config, is_free, rng, crowd != nullptr ? *crowd : own, at_m).grow();
  tint_stalks(plant, config);
  return plant;
}

std::vector<Material> strawberry_materials(const StrawberryPlantConfig& config) {
  const auto& s = config.surface;
  const auto coated = [&](const char* name, const Vector3d& albedo) {
    Material m;
    m.name = name;
    m.albedo = to_rgb(albedo);
    m.roughness = s.stem_roughness;
    return m;
  };
  Material leaflet;
  leaflet.name = "strawberry leaf";
  leaflet.kind = SurfaceKind::leaf;
  const auto& l = config.leaf;
  const Vector3d bright = color_vector(l.albedo)
                              .cwiseMax(color_vector(l.albedo_young))
                              .cwiseMax(color_vector(l.albedo_vein))
                              .cwiseMax(color_vector(l.albedo_old));
  leaflet.albedo = to_rgb(bright);
  leaflet.back_albedo = to_rgb(color_vector(l.albedo_back).cwiseMax(bright));
  leaflet.transmittance = to_rgb(color_vector(l.transmittance));
  leaflet.roughness = s.leaf_roughness;
  leaflet.infrared_transmittance = static_cast<float>(s.infrared_transmittance);
  Material petal;
  petal.name = "strawberry petal";
  petal.kind = SurfaceKind::leaf;
  petal.albedo = to_rgb(color_vector(config.flower.albedo_petal));
  petal.transmittance = to_rgb(color_vector(config.flower.transmittance_petal));
  petal.roughness = s.stem_roughness;
  petal.infrared_transmittance = static_cast<float>(s.infrared_transmittance);
  std::vector<Material> materials = {
      coated("strawberry petiole",
             color_vector(l.petiole_albedo).cwiseMax(color_vector(config.runner.albedo))),
      leaflet, petal, coated("strawberry flower", color_vector(config.flower.albedo_receptacle)),
      coated("strawberry crown", color_vector(config.crown.albedo))};
  for (Material& m : materials) {
    m.ior = s.ior;
    m.infrared_albedo = static_cast<float>(s.infrared_albedo);
  }
  return materials;
}

}  // namespace cousin
