#include "scenes/limbs/plant_limbs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kGap_m = 1e-6;  // points of a line nearer than this are one

/// Appends a line's points that do not repeat the last.
void append_line(BendingStem& stem, const CentreLine& line, double least_radius_m) {
  for (std::size_t i = 0; i < line.points_m.size(); ++i) {
    if (!stem.points_m.empty() && (line.points_m[i] - stem.points_m.back()).norm() < kGap_m)
      continue;
    stem.points_m.push_back(line.points_m[i]);
    stem.radii_m.push_back(std::max(least_radius_m, line.radii_m[i]));
  }
}

/// Share of a stem's length at the point of its line nearest to `at_m`.
double nearest_share(const BendingStem& stem, const Vector3d& at_m) {
  double along_m = 0, best_m = 0, least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < stem.points_m.size(); ++i) {
    const Vector3d way = stem.points_m[i + 1] - stem.points_m[i];
    const double length = way.norm();
    const double t = std::clamp((at_m - stem.points_m[i]).dot(way) / (length * length), 0.0, 1.0);
    const double distance = (stem.points_m[i] + t * way - at_m).squaredNorm();
    if (distance < least) {
      least = distance;
      best_m = along_m + t * length;
    }
    along_m += length;
  }
  return best_m / along_m;
}

/// Makes the limbs of one plant.
class LimbMaker {
 public:
  LimbMaker(const Plant& plant, const PlantModel& model, const LimbConfig& config, double wind_m_s,
            Rng rng)
      : plant_(plant), model_(model.model), c_(config) {
    stiffness_ = 1 + config.modulus_spread * truncated_normal(rng, 0, 1, 2);
    // Leaves fold and turn from a strong wind [Vogel, Journal of Experimental Botany 1989].
    drag_ = config.drag_coefficient * std::pow(std::max(1.0, wind_m_s), config.reconfiguration);
  }

  Limbs make() {
    stem_of_.assign(plant_.organs.size(), -1);
    add_stalk();
    if (!limbs_.plant.stems.empty()) {
      for (const Organ& organ : plant_.organs) add_limb(organ);
    }
    place_triangles();
    place_keypoints();
    if (!limbs_.plant.stems.empty()) load_blades();
    return std::move(limbs_);
  }

 private:
  int add_stem(BendingStem stem, double modulus_pa, int segments, const std::string& name) {
    stem.young_modulus_pa = stiffness_ * modulus_pa;
    stem.density_kg_m3 = c_.density_kg_m3;
    stem.damping_time_s = c_.damping_time_s;
    stem.segments = segments;
    limbs_.plant.stems.push_back(std::move(stem));
    limbs_.stem_names.push_back(name);
    return static_cast<int>(limbs_.plant.stems.size()) - 1;
  }

  /// All organs of the stem in a row; each remembers where on it it lies.
  void add_stalk() {
    BendingStem stalk;
    for (const Organ& organ : plant_.organs) {
      if (organ.kind == OrganKind::stem) append_line(stalk, organ.line, 0);
    }
    if (stalk.points_m.size() < 2) return;
    add_stem(std::move(stalk), c_.stem_modulus_pa, c_.stem_segments, "stalk");
  }

  bool is_long_enough(const Organ& organ) const {
    if (organ.kind == OrganKind::petiole) {
      // As long as the blade on it.
      return std::any_of(plant_.organs.begin(), plant_.organs.end(), [&](const Organ& blade) {
        return blade.parent == organ.id && is_blade(blade) && is_long_enough(blade);
      });
    }
    return is_there(organ) && line_length_m(organ) >= c_.least_leaf_m;
  }
  static bool is_blade(const Organ& organ) {
    return organ.kind == OrganKind::blade || organ.kind == OrganKind::cotyledon;
  }

  void add_limb(const Organ& organ) {
    const bool is_petiole = organ.kind == OrganKind::petiole;
    if (!(is_petiole || is_blade(organ)) || !is_long_enough(organ) || organ.line.points_m.empty())
      return;
    const int bearer =
        organ.parent >= 0 ? std::max(0, stem_of_[static_cast<std::size_t>(organ.parent)]) : 0;
    const BendingStem& below = limbs_.plant.stems[static_cast<std::size_t>(bearer)];
    BendingStem stem;
    stem.parent = bearer;
    stem.parent_share = nearest_share(below, organ.line.points_m.front());
    // Begins on the bearer's axis, which what it grows on may have left by a radius.
    const Vector3d foot_m = point_at_m(below, stem.parent_share);
    const double radius_m = c_.least_radius_m;
    if ((foot_m - organ.line.points_m.front()).norm() > 2 * kGap_m) {
      stem.points_m.push_back(foot_m);
      stem.radii_m.push_back(std::max(radius_m, organ.line.radii_m.front()));
    }
    append_line(stem, organ.line, radius_m);
    stem_of_[static_cast<std::size_t>(organ.id)] =
        is_petiole
            ? add_stem(std::move(stem), c_.petiole_modulus_pa, c_.petiole_segments, organ.name)
            : add_stem(std::move(stem), c_.blade_modulus_pa, c_.blade_segments, organ.name);
  }

  /// Where an organ without a stem of its own is fixed, or nothing: it lies along the stalk.
  const LimbPlace* whole_place(const Organ& organ) {
    const auto known = bases_.find(organ.id);
    if (known != bases_.end()) return &known->second;
    const bool is_leaf = is_blade(organ) || organ.kind == OrganKind::petiole;
    if (!is_leaf || organ.line.points_m.empty()) return nullptr;
    LimbPlace base{0, nearest_share(limbs_.plant.stems.front(), organ.line.points_m.front())};
    // A short blade on a short petiole: both where the petiole begins.
    if (organ.parent >= 0) {
      const Organ& parent = plant_.organs[static_cast<std::size_t>(organ.parent)];
      const LimbPlace* below = parent.kind == OrganKind::petiole ? whole_place(parent) : nullptr;
      if (below) base = *below;
    }
    return &bases_.emplace(organ.id, base).first->second;
  }

  void place_triangles() {
    const bool moves = !limbs_.plant.stems.empty();
    limbs_.triangles.resize(model_.mesh.triangles.size());
    for (std::size_t t = 0; moves && t < limbs_.triangles.size(); ++t) {
      const Organ& organ = plant_.organs[model_.triangle_part[t]];
      const auto& [a, b, c] = model_.mesh.triangles[t];
      const Vector3d middle_m =
          (model_.mesh.vertices_m[a] + model_.mesh.vertices_m[b] + model_.mesh.vertices_m[c]) / 3;
      const int own = stem_of_[static_cast<std::size_t>(organ.id)];
      const LimbPlace* whole = own < 0 ? whole_place(organ) : nullptr;
      if (whole) {
        limbs_.triangles[t] = *whole;
      } else {
        const int stem = std::max(0, own);
        limbs_.triangles[t] = {
            stem, nearest_share(limbs_.plant.stems[static_cast<std::size_t>(stem)], middle_m)};
      }
    }
  }

  /// Each with the vertex that is nearest to it.
  void place_keypoints() {
    for (const Keypoint& keypoint : model_.keypoints) {
      LimbPlace place;
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t t = 0; t < model_.mesh.triangles.size(); ++t) {
        for (const std::uint32_t vertex : model_.mesh.triangles[t]) {
          const double distance =
              (model_.mesh.vertices_m[vertex] - keypoint.in_object_m).squaredNorm();
          if (!(distance < least)) continue;
          least = distance;
          place = limbs_.triangles[t];
        }
      }
      limbs_.keypoints.push_back(place);
    }
  }

  /// Mass and drag of blades, at the middle of what each section carries.
  void load_blades() {
    struct Sum {
      double area_m2 = 0, mass_kg = 0;
      Vector3d moment = Vector3d::Zero();
    };
    std::map<std::pair<int, int>, Sum> sums;  // by stem and section
    for (std::size_t t = 0; t < limbs_.triangles.size(); ++t) {
      const Organ& organ = plant_.organs[model_.triangle_part[t]];
      if (!is_blade(organ)) continue;
      const LimbPlace& place = limbs_.triangles[t];
      const int segments = limbs_.plant.stems[static_cast<std::size_t>(place.stem)].segments;
      Sum& sum = sums[{place.stem, static_cast<int>(place.share * segments + 0.5)}];
      const auto& [a, b, c] = model_.mesh.triangles[t];
      const Vector3d &p = model_.mesh.vertices_m[a], &q = model_.mesh.vertices_m[b],
                     &r = model_.mesh.vertices_m[c];
      const double area_m2 = 0.5 * (q - p).cross(r - p).norm();
      const bool is_leaf = organ.kind == OrganKind::blade;
      sum.area_m2 += area_m2;
      sum.mass_kg += area_m2 * (is_leaf ? c_.leaf_kg_m2 : c_.cotyledon_kg_m2);
      sum.moment += area_m2 * (p + q + r) / 3;
    }
    for (const auto& [section, sum] : sums) {
      const int segments = limbs_.plant.stems[static_cast<std::size_t>(section.first)].segments;
      BendingLoad load;
      load.stem = section.first;
      load.share = static_cast<double>(section.second) / segments;
      load.mass_kg = std::max(1e-9, sum.mass_kg);
      load.centroid_m = sum.moment / std::max(sum.area_m2, 1e-12);
      load.drag_area_m2 = drag_ * sum.area_m2;
      limbs_.plant.loads.push_back(load);
    }
  }

  const Plant& plant_;
  const ObjectModel& model_;
  const LimbConfig& c_;
  double stiffness_ = 1, drag_ = 0;
  Limbs limbs_;
  std::vector<int> stem_of_;        ///< of each organ, -1: none of its own
  std::map<int, LimbPlace> bases_;  ///< of organs that move with another, by id
};

}  // namespace

Fields fields(LimbConfig& c) {
  return {
      {"stem_modulus_pa", &c.stem_modulus_pa, "Young's modulus of the stalk", 1e5, 1e11},
      {"petiole_modulus_pa", &c.petiole_modulus_pa, "of petioles", 1e5, 1e11},
      {"blade_modulus_pa", &c.blade_modulus_pa, "of a rod that bends as the blade", 1e5, 1e11},
      {"least_radius_m", &c.least_radius_m, "of that rod and of petioles", 1e-4, 0.1},
      {"density_kg_m3", &c.density_kg_m3, "of stems and petioles", 10, 2000},
      {"leaf_kg_m2", &c.leaf_kg_m2, "fresh mass of blades over their area", 0.01, 10},
      {"cotyledon_kg_m2", &c.cotyledon_kg_m2, "of cotyledons", 0.01, 10},
      {"damping_time_s", &c.damping_time_s, "tau of the hinges' damping c = tau k", 0.004, 1},
      {"drag_coefficient", &c.drag_coefficient, "of a blade's side, up to 1 m/s", 0, 10},
      {"reconfiguration", &c.reconfiguration, "drag grows as speed to 2 + this above 1 m/s", -2, 0},
      {"modulus_spread", &c.modulus_spread, "sigma from plant to plant over the mean", 0, 0.4},
      {"stem_segments", &c.stem_segments, "hinges of the stalk", 1, 40},
      {"petiole_segments", &c.petiole_segments, "hinges of a petiole", 1, 20},
      {"blade_segments", &c.blade_segments, "hinges of a blade", 1, 20},
      {"least_leaf_m", &c.least_leaf_m, "shorter blades move with what bears them", 1e-3, 10},
      {"lead_s", &c.lead_s, "of wind before the first view", 0, 100},
  };
}

Limbs plant_limbs(const Plant& plant, const PlantModel& model, const LimbConfig& config,
                  double wind_m_s, Rng rng) {
  return LimbMaker(plant, model, config, wind_m_s, rng).make();
}

}  // namespace cousin
