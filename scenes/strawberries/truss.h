#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/strawberries/strawberry.h"
#include "sim/config/fields.h"
#include "sim/physics/plant_motion.h"

namespace cousin {

/// truss.toml, which says what each number is and where it comes from. Every value is given there.
struct TrussShape {
  double peduncle_length_m = 0, branch_length_m = 0, pedicel_length_m = 0, cv_length = 0;
  double peduncle_radius_m = 0, pedicel_radius_m = 0;
  double young_modulus_pa = 0, density_kg_m3 = 0, strength_pa = 0, damping_time_s = 0;
  double fork_rad = 0, rise_rad = 0;
  double apart_rad = 0, apart_spread_rad = 0;  ///< of the two trusses of a plant
  double turn_spread_rad = 0, crosswise_rad = 0, crosswise_spread_rad = 0;
  double peduncle_taper = 0, peduncle_droop_rad = 0, early_share = 0;
  double pedicel_thick = 0, pedicel_droop_rad = 0, pedicel_less = 0, pedicel_least = 0;
  double branch_less = 0, branch_least = 0;
  std::vector<double> branch_thick;
  double growth_by_ripeness = 0, grown_ripeness = 0, growth_least = 0, fruit_drag = 0;
  double vigour_low = 0, vigour_high = 0;  ///< lengths of a truss over those above
  double fork_low = 0, fork_high = 0;      ///< where the peduncle forks, over its length
  double one_branch_share = 0;             ///< of the forks, from which one branch goes on
  std::vector<double> mass_by_rank;
  double lag_by_rank = 0, lag_spread = 0, ripeness_low = 0, ripeness_high = 0;
  double maturity_medium = 0, maturity_high = 0;
  double crown_m = 0, bed_half_width_m = 0, bed_height_m = 0, bed_round_m = 0;
  double bed_slope_rad = 0;
};
Fields fields(TrussShape& shape);
void validate(const TrussShape& shape);
/// As truss.toml says.
const TrussShape& truss_shape();

/// Ripeness of a truss's first fruit in the field, and of one of its fruits of a rank: see
/// TrussConfig.
double draw_ripeness(const TrussShape& shape, Rng rng);
double ripeness_of_rank(const TrussShape& shape, double first, int rank, Rng rng);
struct TrussConfig {
  std::string variety = "benihoppe";
  std::optional<StrawberryVariety> numbers;  ///< in place of the variety's own
  TrussShape shape = truss_shape();
  int fruits = 5;  ///< 1..15
  /// Of the first fruit: below 0 green, 0..1 its red share, above 1 ripe; absent: drawn.
  std::optional<double> ripeness;
  double heavier = 1;  ///< times the fruits' masses: what stalks can hold
  FruitFamily family = FruitFamily::botanical;
  double elongation = 1;                      ///< times the fruits' length over diameter
  Eigen::Vector3d to_sun = {0.4, -0.5, 0.8};  ///< in the world
  double along_m = 0;                         ///< y of its crown
  double turn_rad = 0;                        ///< of the peduncle, from straight over the edge
  int grid = 0;  ///< cells along an edge of a fruit's mesh, as a variety's; 0: the variety's own
};
/// @throws std::invalid_argument naming key, value and limit.
void validate(const TrussConfig& config);

/// Rank of each fruit of a truss in their order, as grow_truss makes it: 0, 1, 1, 2, 2, 2, 2, 3,
/// ... where each fork has two branches.
std::vector<int> ranks_of(const TrussConfig& config, Rng rng);

/// A truss that hangs over the shoulder of a bed at rest. World: the bed's top is z = 0, its edge
/// x = 0 with the path on the side +x.
struct Truss {
  PlantStatus status = PlantStatus::not_at_rest;  ///< ok, or why it does not hang so
  std::vector<FruitModel>
      fruits;  ///< cut_point is moved to the hanging stalk; no stalk of their own
  std::vector<Pose> world_from_fruit;
  std::vector<Pose> unbent_from_fruit;  ///< where the fruits would be without weight
  TrussShape shape;
  std::vector<int> rank;  ///< 0 = the first fruit, 1, 1, 2, ...
  BendingPlant plant;     ///< unloaded; the last stem before each load's end carries the fruit
  SagResult sag;
  double cut_above_m = 0;  ///< of the cut point above the calyx, along the stalk
};
Truss make_truss(const TrussConfig& config, Rng rng);

/// Colours of another day: fruits that are full-grown ripen anew, with `first` as
/// TrussConfig::ripeness; those that still grow stay green. Shapes, masses and stalks stay.
struct Ripening {
  double first = 0;
  Rng rng;
};
/// The stalks alone, unloaded, as grow_truss makes them for the same (config, rng).
BendingPlant grow_stalks(const TrussConfig& config, Rng rng);
/// The first step of make_truss: all but the weight. Deterministic in (config, rng, ripening).
Truss grow_truss(const TrussConfig& config, Rng rng, const std::optional<Ripening>& ripening = {});
/// Red shares that it asks of its fruits, without making them.
std::vector<double> asked_red_shares(const TrussConfig& config, Rng rng,
                                     const std::optional<Ripening>& ripening = {});
/// The second: trusses beside each other on one bed as one plant, for sag().
BendingPlant bending_plant(std::span<const Truss> trusses);
/// Their shape under weight: sag() at twice its own step, which ends at the same rest in half the
/// time (stresses within 1e-3, overlaps of 0.01 mm instead of 0.0025); at its own where that
/// diverges.
SagResult settle_trusses(std::span<const Truss> trusses);
SagConfig truss_sag();  ///< the first of the two
/// The last: puts stalks and fruits where sag() of their bending_plant left them.
/// @throws std::invalid_argument if `sag` is of other trusses.
void hang(std::span<Truss> trusses, const SagResult& sag);

/// The truss, its bed under black film and the ground, without lights and views. Fruits are
/// specimens with their traits and keypoints; calyces and stems are not.
/// @param frames  of the truss's motion, as sway() gives them; empty = at rest. Fruits and calyces
/// move; stems, whose meshes bend, stay as at rest.
Scene truss_scene(const Truss& truss, const std::vector<BentPlant>& frames = {});

}  // namespace cousin
