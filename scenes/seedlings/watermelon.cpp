#include "scenes/seedlings/watermelon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/geometry/gradient_noise.h"
#include "sim/plant/blade_colours.h"
#include "sim/plant/color.h"
#include "sim/plant/growth.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

/// What one plant is, on whatever day.
struct Individual {
  bool germinates = false;
  double emergence_day = 0, vigour = 1;
  double azimuth_rad = 0;  ///< of the hook and of the first cotyledon
  double lean_rad = 0, lean_azimuth_rad = 0;
  std::array<double, 2> cotyledon_size{}, cotyledon_open{};
  struct Leaf {
    double size = 1, azimuth_draw = 0, angle = 0, phase_rad = 0, twist_rad = 0;
  };
  std::array<Leaf, kSeedlingLeaves> leaves;
  std::uint64_t colour_key = 0;
};

Individual draw_individual(const WatermelonConfig& config, Rng rng) {
  Individual own;
  const auto about_one = [&](double sigma) { return truncated_normal(rng, 1, sigma, 2.5); };
  own.germinates = uniform(rng) >= config.emergence.failed_share;
  own.emergence_day =
      std::max(0.0, truncated_normal(rng, config.emergence.day, config.emergence.spread_days, 2.5));
  own.vigour = about_one(config.emergence.spread);
  own.azimuth_rad = uniform(rng, 0, 2 * kPi);
  own.lean_rad = std::abs(truncated_normal(rng, 0, config.hypocotyl.lean_rad, 2.5));
  own.lean_azimuth_rad = uniform(rng, 0, 2 * kPi);
  for (int i = 0; i < 2; ++i) {
    own.cotyledon_size[static_cast<std::size_t>(i)] = about_one(config.cotyledon.size_spread);
    own.cotyledon_open[static_cast<std::size_t>(i)] = about_one(config.cotyledon.open_spread);
  }
  for (Individual::Leaf& leaf : own.leaves) {
    leaf.size = about_one(config.leaf.size_spread);
    leaf.azimuth_draw = truncated_normal(rng, 0, 1, 2.5);
    leaf.angle = about_one(config.leaf.angle_spread);
    leaf.phase_rad = uniform(rng, 0, 2 * kPi);
    leaf.twist_rad = truncated_normal(rng, 0, config.leaf.twist_rad, 2.5);
  }
  own.colour_key = rng();
  return own;
}

int cells(double length_m, double detail_m, int least, int most) {
  return std::clamp(static_cast<int>(std::ceil(length_m / detail_m)), least, most);
}

/// Grows one seedling organ by organ; organs that are not there yet are added all the same.
class Grower {
 public:
  Grower(const WatermelonConfig& config, const SeedlingPlace& place, const Individual& own,
         double day)
      : c_(config), place_(place), own_(own), age_(day - own.emergence_day) {}

  Plant grow() {
    plant_.name = "watermelon seedling";
    hypocotyl();
    for (int i = 0; i < 2; ++i) cotyledon(i);
    int below = 0;  // the hypocotyl
    for (int rank = 1; rank <= place_.leaves; ++rank) below = leaf(rank, below);
    if (age_ > 0) plant_.keypoints.push_back({"apex", top_m_});
    return std::move(plant_);
  }

 private:
  void hypocotyl() {
    const auto& h = c_.hypocotyl;
    Organ& organ = add_organ(plant_, OrganKind::stem, "hypocotyl", -1, 0);
    organ.look = kStemLook;
    organ.age_days = age_;
    if (age_ <= 0) return;
    const Vector3d along(std::cos(own_.azimuth_rad), std::sin(own_.azimuth_rad), 0);
    across_ = Vector3d::UnitZ().cross(along);
    const double full_m = own_.vigour * h.length_m;
    AxisGrowth growth;
    growth.start_m = {0, 0, -h.depth_m};
    const Vector3d lean(std::cos(own_.lean_azimuth_rad), std::sin(own_.lean_azimuth_rad), 0);
    growth.heading = (Vector3d::UnitZ() + std::tan(own_.lean_rad) * lean).normalized();
    growth.length_m = h.depth_m + h.start_m +
                      size_at({std::max(0.0, full_m - h.start_m), h.days, h.fastest_days}, age_);
    const double thick =
        std::sqrt(std::min(1.0, 1 - h.section_gain + h.section_gain * age_ / h.days));
    growth.radius_base_m = own_.vigour * thick * h.radius_base_m;
    growth.radius_tip_m = own_.vigour * thick * h.radius_tip_m;
    growth.segments = 40;
    growth.tropisms.push_back(
        {place_.to_light, h.light_rad * std::min(1.0, age_ / h.light_days), h.light_begin});
    const double hook = h.hook_rad * (1 - logistic(age_, h.hook_day, h.hook_scale_days));
    growth.curls.push_back({across_, hook, h.hook_begin});
    organ.line = grow_axis(growth);
    organ.surface = tube_surface(organ.line, c_.surface.tube_sides);
    colour_stem(organ);
    const auto n = organ.line.points_m.size();
    heading_ = (organ.line.points_m[n - 1] - organ.line.points_m[n - 2]).normalized();
    side_ = across_.cross(heading_).normalized();
    across_ = heading_.cross(side_);
    top_m_ = organ.line.points_m.back();
    radius_m_ = organ.line.radii_m.back();
    plant_.keypoints.push_back({"collar", Vector3d::Zero()});
    plant_.keypoints.push_back({"cotyledon node", top_m_});
  }

  void colour_stem(Organ& organ) const {
    const Vector3d base =
        color_vector(c_.hypocotyl.albedo).cwiseMax(color_vector(c_.hypocotyl.albedo_base));
    for (const Eigen::Vector2d& place : organ.surface.place) {
      const double green = organ.name == "hypocotyl" ? smoothstep(0.1, 0.75, place.x()) : 1;
      const Vector3d colour = (1 - green) * color_vector(c_.hypocotyl.albedo_base) +
                              green * color_vector(c_.hypocotyl.albedo);
      organ.albedo.push_back(to_rgb(colour.cwiseQuotient(base)));
    }
  }

  /// A straight stalk; returns its tip's heading.
  Vector3d stalk(Organ& organ, const AxisGrowth& growth) const {
    organ.line = grow_axis(growth);
    organ.surface = tube_surface(organ.line, std::max(6, c_.surface.tube_sides - 4));
    colour_stem(organ);
    const auto n = organ.line.points_m.size();
    return (organ.line.points_m[n - 1] - organ.line.points_m[n - 2]).normalized();
  }

  BladeShape cotyledon_shape(double scale, double old) const {
    const auto& c = c_.cotyledon;
    BladeShape shape;
    shape.width_m = scale * c.width_m;
    shape.envelope_base = c.outline[0];
    shape.envelope_peak = c.outline[1];
    shape.envelope_rise = c.outline[2];
    shape.envelope_fall = c.outline[3];
    shape.envelope_tip = c.outline[4];
    shape.fold_rad = c.fold_rad;
    shape.camber = -c.camber * old;
    return shape;
  }

  void cotyledon(int i) {
    const auto& c = c_.cotyledon;
    const std::string name = "cotyledon " + std::to_string(i + 1);
    const int stalk_id = add_organ(plant_, OrganKind::petiole, name + " petiole", 0, 0).id;
    add_organ(plant_, OrganKind::cotyledon, name, stalk_id, 0).look = kCotyledonLook;
    Organ& petiole = plant_.organs[static_cast<std::size_t>(stalk_id)];
    Organ& blade = plant_.organs.back();
    petiole.age_days = blade.age_days = age_;
    if (age_ <= 0) return;
    const auto k = static_cast<std::size_t>(i);
    const double open =
        std::max(c.least_open_rad, c.open_rad * own_.cotyledon_open[k] *
                                       logistic(age_, c.open_day, c.open_scale_days));
    const Vector3d side = (i == 0 ? 1 : -1) * side_;
    const Vector3d heading = std::cos(open) * heading_ + std::sin(open) * side;
    const Vector3d upper = std::sin(open) * heading_ - std::cos(open) * side;
    const double size = c.start_share + size_at({1 - c.start_share, c.days, c.fastest_days}, age_);
    const double scale = size * own_.vigour * own_.cotyledon_size[k];
    AxisGrowth growth;
    growth.start_m = top_m_ + 0.5 * radius_m_ * side;
    growth.heading = heading;
    growth.length_m = scale * c.petiole_m;
    growth.radius_base_m = c.radius_share[0] * radius_m_;
    growth.radius_tip_m = c.radius_share[1] * radius_m_;
    growth.segments = 4;
    stalk(petiole, growth);
    growth.start_m = petiole.line.points_m.back();
    growth.length_m = scale * c.length_m;
    growth.radius_base_m = c.radius_share[1] * radius_m_;
    growth.radius_tip_m = c.radius_share[2] * radius_m_;
    growth.segments = 20;
    const double old = logistic(age_, c.open_day + c.old_after_days, c.old_scale_days);
    const double droop = (c.old_droop - c.young_droop) * old + c.young_droop;
    growth.curls.push_back({upper.cross(heading), droop * c.droop_rad, 0});
    blade.line = grow_axis(growth);
    const BladeShape shape = cotyledon_shape(scale, old);
    const LineWalk midrib(blade.line, upper);
    const double detail_m = c_.surface.detail_m;
    blade.surface = blade_surface(midrib, shape, cells(midrib.length_m(), detail_m, 12, 48),
                                  2 * cells(0.5 * shape.width_m, detail_m, 4, 20));
    const double green = logistic(age_, c.green_day, 0.45);
    BladeColours colours;
    colours.lamina = (1 - green) * color_vector(c.albedo_young) + green * color_vector(c.albedo);
    colours.vein = (1 - green) * color_vector(c.albedo_young) + green * color_vector(c.albedo_vein);
    colours.base = brightest(c.albedo, c.albedo_young, c.albedo_vein);
    colours.vein_m = 0.0009;
    colours.halo = 0.35;
    colours.length_m = midrib.length_m();
    colours.key = own_.colour_key + k;
    blade.albedo = blade_albedo(blade.surface, shape, colours, detail_m);
    plant_.keypoints.push_back({name + " tip", blade.line.points_m.back()});
  }

  BladeShape leaf_shape(int rank, double size, double age) const {
    const auto& l = c_.leaf;
    const auto k = static_cast<std::size_t>(rank - 1);
    const Individual::Leaf& own = own_.leaves[k];
    const double unfolded = logistic(age, l.unfold_day, l.unfold_scale_days);
    BladeShape shape;
    shape.width_m =
        size * l.length_m[k] * l.width_share * (l.folded_width + (1 - l.folded_width) * unfolded);
    shape.envelope_base = l.outline[0];
    shape.envelope_peak = l.outline[1];
    shape.envelope_rise = l.outline[2];
    shape.envelope_fall = l.outline[3];
    shape.envelope_tip = l.outline[4];
    shape.sweep_base_rad = l.sweep_base_rad;
    shape.sweep_tip_rad = l.sweep_tip_rad;
    shape.lobes = static_cast<int>(std::lround(l.lobes[k]));
    shape.lobe_depth = l.lobe_depth[k];
    shape.lobe_round = l.lobe_round;
    shape.teeth = l.teeth;
    shape.teeth_depth = l.teeth_depth;
    shape.fold_rad = (1 - unfolded) * l.young_fold_rad + unfolded * l.old_fold_rad;
    shape.camber = -l.camber * unfolded;
    shape.wave_m = size * l.wave_m * (l.folded_wave + (1 - l.folded_wave) * unfolded);
    shape.wave_phase_rad = own.phase_rad;
    shape.quilt_m = size * l.quilt_m;
    shape.twist_rad = own.twist_rad * unfolded;
    return shape;
  }

  void leaf_colours(Organ& blade, const BladeShape& shape, double size, double age) const {
    const auto& l = c_.leaf;
    const double green = logistic(age, l.unfold_day + 0.6, 0.7);
    BladeColours colours;
    colours.lamina = (1 - green) * color_vector(l.albedo_young) + green * color_vector(l.albedo);
    colours.vein = (1 - green) * color_vector(l.albedo_young) + green * color_vector(l.albedo_vein);
    colours.base = brightest(l.albedo, l.albedo_young, l.albedo_vein);
    colours.vein_m = std::max(0.25, std::sqrt(size)) * l.vein_width_m;
    colours.halo = 0.30;
    colours.length_m = line_length_m(blade);
    colours.key = own_.colour_key + 16 + static_cast<std::uint64_t>(blade.rank);
    blade.albedo = blade_albedo(blade.surface, shape, colours, c_.surface.detail_m);
  }

  /// @param tip  heading of the petiole's tip  @param side  horizontal, away from the axis
  void blade_of_leaf(Organ& blade, const Organ& petiole, const Vector3d& tip, const Vector3d& side,
                     double size, double age) {
    const auto& l = c_.leaf;
    const auto k = static_cast<std::size_t>(blade.rank - 1);
    const double old = logistic(age, l.angle_day, l.angle_scale_days);
    // The blade hangs on from the petiole's tip, away from the axis.
    const Vector3d sideways = side.cross(heading_).normalized();
    const Vector3d heading =
        Eigen::AngleAxisd(-(l.young_blade + (1 - l.young_blade) * old) * l.blade_angle_rad,
                          sideways) *
        tip;
    const Vector3d upper = sideways.cross(heading).normalized();
    AxisGrowth growth;
    growth.start_m = petiole.line.points_m.back();
    growth.heading = heading;
    growth.length_m = size * l.length_m[k];
    growth.radius_base_m = petiole.line.radii_m.back();
    growth.radius_tip_m = l.midrib_taper * growth.radius_base_m;
    growth.segments = 24;
    growth.curls.push_back({upper.cross(heading), old * l.droop_rad, 0});
    blade.line = grow_axis(growth);
    const BladeShape shape = leaf_shape(blade.rank, size, age);
    const double detail_m = c_.surface.detail_m;
    blade.surface = blade_surface(LineWalk(blade.line, upper), shape,
                                  cells(growth.length_m, 0.8 * detail_m, 24, 72),
                                  2 * cells(0.5 * shape.width_m, detail_m, 5, 28));
    leaf_colours(blade, shape, size, age);
    plant_.keypoints.push_back({blade.name + " base", blade.line.points_m.front()});
    plant_.keypoints.push_back({blade.name + " tip", blade.line.points_m.back()});
  }

  /// Internode, petiole and blade. @return the internode's id, on which the next one grows.
  int leaf(int rank, int below) {
    const auto& l = c_.leaf;
    const auto k = static_cast<std::size_t>(rank - 1);
    const Individual::Leaf& own = own_.leaves[k];
    const std::string name = "leaf " + std::to_string(rank);
    const double age = age_ - l.first_day - (rank - 1) * l.plastochron_days;
    const int node =
        add_organ(plant_, OrganKind::stem, "internode " + std::to_string(rank), below, rank).id;
    const int stalk_id = add_organ(plant_, OrganKind::petiole, name + " petiole", node, rank).id;
    const int blade_id = add_organ(plant_, OrganKind::blade, name, stalk_id, rank).id;
    Organ& internode = plant_.organs[static_cast<std::size_t>(node)];
    Organ& petiole = plant_.organs[static_cast<std::size_t>(stalk_id)];
    Organ& blade = plant_.organs[static_cast<std::size_t>(blade_id)];
    blade.look = kLeafLook;
    internode.age_days = petiole.age_days = blade.age_days = age;
    const double share = size_at({1, l.days, l.fastest_days}, age);
    const double size = share * own_.vigour * own.size;
    if (age_ <= 0 || size * l.length_m[k] < l.least_m) return node;

    AxisGrowth growth;
    growth.start_m = top_m_;
    growth.heading = heading_;
    growth.length_m = std::max(2e-4, size * l.internode_m);
    growth.radius_base_m = growth.radius_tip_m = l.internode_radius * radius_m_;
    growth.segments = 4;
    heading_ = stalk(internode, growth);
    top_m_ = internode.line.points_m.back();
    // The first leaf stands across the cotyledons.
    const double azimuth =
        azimuth_rad({kPi / 2, l.divergence_rad, l.spread_rad}, rank - 1, own.azimuth_draw);
    const Vector3d side = std::cos(azimuth) * side_ + std::sin(azimuth) * across_;
    const double old = logistic(age, l.angle_day, l.angle_scale_days);
    const double angle = own.angle * ((1 - old) * l.young_angle_rad + old * l.old_angle_rad);
    growth.heading = std::cos(angle) * heading_ + std::sin(angle) * side;
    growth.start_m = top_m_ + 0.4 * radius_m_ * side;
    growth.length_m = std::max(3e-4, size * l.length_m[k] * l.petiole_share);
    growth.radius_base_m = std::max(l.young_petiole, std::sqrt(share)) * l.petiole_radius_m;
    growth.radius_tip_m = l.petiole_taper * growth.radius_base_m;
    growth.segments = 12;
    growth.tropisms.push_back({Vector3d::UnitZ(), l.petiole_rise_rad, 0});
    const Vector3d tip = stalk(petiole, growth);
    blade_of_leaf(blade, petiole, tip, side, size, age);
    return node;
  }

  const WatermelonConfig& c_;
  const SeedlingPlace& place_;
  const Individual& own_;
  double age_;  ///< days since emergence
  Plant plant_;
  // Where the stem has got to.
  Vector3d top_m_ = Vector3d::Zero(), heading_ = Vector3d::UnitZ();
  Vector3d side_ = Vector3d::UnitX();    ///< unit, across the heading: the first cotyledon's
  Vector3d across_ = Vector3d::UnitY();  ///< heading x side
  double radius_m_ = 0;
};

/// Length of a line above z = 0.
double length_above_m(const CentreLine& line) {
  double sum = 0;
  for (std::size_t i = 1; i < line.points_m.size(); ++i) {
    const Vector3d &a = line.points_m[i - 1], &b = line.points_m[i];
    const double low = std::min(a.z(), b.z()), high = std::max(a.z(), b.z());
    if (high <= 0) continue;
    sum += (b - a).norm() * (low >= 0 ? 1 : high / (high - low));
  }
  return sum;
}

std::vector<TrueTrait> seedling_traits(const Seedling& seedling, double counted_m) {
  const Plant& plant = seedling.plant;
  const double blades_m2 = blade_area_m2(plant), all_m2 = leaf_area_m2(plant);
  return {{"emergence", "1", seedling.has_emerged ? 1.0 : 0.0},
          {"leaf_count", "1", static_cast<double>(leaf_count(plant, counted_m))},
          {"leaf_area", "m2", all_m2},
          {"cotyledon_area", "m2", all_m2 - blades_m2},
          {"height", "m", height_m(plant)},
          {"hypocotyl_length", "m",
           seedling.has_emerged ? length_above_m(plant.organs.front().line) : 0.0}};
}

}  // namespace

Seedling grow_watermelon(const WatermelonConfig& config, const SeedlingPlace& place, double day,
                         Rng rng) {
  check_day(day, kLastSeedlingDay, "seedlings");
  if (place.leaves < 0 || place.leaves > kSeedlingLeaves) {
    throw std::invalid_argument("leaves = " + std::to_string(place.leaves) + " is not in [0, " +
                                std::to_string(kSeedlingLeaves) + "]");
  }
  Individual own = draw_individual(config, rng);
  Seedling seedling;
  seedling.germinates = own.germinates;
  seedling.emergence_day = own.emergence_day;
  seedling.has_emerged = own.germinates && day > own.emergence_day;
  // A seed that fails has its organs' places, and never an organ.
  if (!own.germinates) own.emergence_day = 10 * kLastSeedlingDay;
  seedling.plant = Grower(config, place, own, day).grow();
  seedling.traits = seedling_traits(seedling, config.leaf.counted_m);
  return seedling;
}

}  // namespace cousin
