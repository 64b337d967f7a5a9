#include "scenes/strawberries/truss.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scenes/strawberries/bed_outline.h"

namespace cousin {
namespace {

/// A place from which stems grow on.
struct Fork {
  int stem = -1;
  Eigen::Vector3d at_m;
  Eigen::Vector3d along;   ///< unit
  Eigen::Vector3d across;  ///< unit: in the plane of the next fork
};

class TrussGrower {
 public:
  TrussGrower(const TrussShape& shape, const TrussConfig& config, Rng rng)
      : shape_(shape), config_(config), rng_(rng) {}

  /// Stems and places of fruits, rank by rank; `plant.loads` is left to the fruits.
  struct Place {
    int stem = 0;
    int rank = 0;
    Eigen::Vector3d end_m;
    Eigen::Vector3d along;
  };
  std::vector<Place> grow(BendingPlant& plant) {
    const Eigen::Vector3d out =
        Eigen::AngleAxisd(config_.turn_rad + shape_.turn_spread_rad * normal(rng_),
                          Eigen::Vector3d::UnitZ()) *
        Eigen::Vector3d::UnitX();
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    const Fork crown{-1,
                     {-shape_.crown_m, config_.along_m, 2 * shape_.peduncle_radius_m},
                     std::cos(shape_.rise_rad) * out + std::sin(shape_.rise_rad) * up,
                     up.cross(out)};
    const double thick = shape_.peduncle_radius_m;
    const double thin = shape_.pedicel_radius_m;
    // What the peduncle is shorter for forking early, its branches are longer.
    const double vigour = uniform(rng_, shape_.vigour_low, shape_.vigour_high);
    const double at = uniform(rng_, shape_.fork_low, shape_.fork_high);
    const double peduncle_m = vigour * at * shape_.peduncle_length_m;
    const double branch_m = vigour * (shape_.branch_length_m +
                                      shape_.early_share * (1 - at) * shape_.peduncle_length_m);
    std::vector<Fork> forks = {add(plant, crown, peduncle_m, thick, shape_.peduncle_taper * thick,
                                   14, -shape_.peduncle_droop_rad)};
    std::vector<Place> places;
    for (int rank = 0; static_cast<int>(places.size()) < config_.fruits; ++rank) {
      std::vector<Fork> next;
      for (const Fork& fork : forks) {
        if (static_cast<int>(places.size()) == config_.fruits) break;
        const double length_m = std::sqrt(vigour) * shape_.pedicel_length_m *
                                std::max(shape_.pedicel_least, 1 - shape_.pedicel_less * rank);
        const Fork end = add(plant, fork, length_m, shape_.pedicel_thick * thin, thin, 7,
                             -shape_.pedicel_droop_rad);
        places.push_back({end.stem, rank, end.at_m, end.along});
        const bool is_single = uniform(rng_) < shape_.one_branch_share;
        const int only = uniform(rng_) < 0.5 ? -1 : 1;
        for (const int side : {-1, 1}) {
          if (is_single && side != only) continue;
          const Fork turned{fork.stem, fork.at_m,
                            Eigen::AngleAxisd(side * shape_.fork_rad,
                                              fork.along.cross(fork.across).normalized()) *
                                fork.along,
                            fork.across};
          next.push_back(turned);
        }
      }
      if (static_cast<int>(places.size()) == config_.fruits) break;
      // Branches only for fruits that come.
      const std::size_t left = static_cast<std::size_t>(config_.fruits) - places.size();
      next.resize(std::min(next.size(), left));
      forks = add_branches(plant, next, branch_m, rank);
    }
    return places;
  }

 private:
  /// From each fork a branch to the next one.
  std::vector<Fork> add_branches(BendingPlant& plant, const std::vector<Fork>& from,
                                 double branch_m, int rank) {
    const double thick = shape_.peduncle_radius_m;
    const double length_m = branch_m * std::max(shape_.branch_least, 1 - shape_.branch_less * rank);
    std::vector<Fork> forks;
    for (const Fork& fork : from) {
      Fork end = add(plant, fork, length_m, shape_.branch_thick[0] * thick,
                     shape_.branch_thick[1] * thick, 4, 0);
      // The next fork stands crosswise.
      end.across =
          Eigen::AngleAxisd(shape_.crosswise_rad + shape_.crosswise_spread_rad * normal(rng_),
                            end.along) *
          end.across;
      forks.push_back(end);
    }
    return forks;
  }

  Fork add(BendingPlant& plant, const Fork& from, double mean_length_m, double radius_begin_m,
           double radius_end_m, int segments, double droop_rad) {
    const double length_m = mean_length_m * truncated_normal(rng_, 1, shape_.cv_length, 2);
    BendingStem stem;
    stem.parent = from.stem;
    stem.young_modulus_pa = shape_.young_modulus_pa;
    stem.density_kg_m3 = shape_.density_kg_m3;
    stem.strength_pa = shape_.strength_pa;
    stem.damping_time_s = shape_.damping_time_s;
    stem.segments = segments;
    const Eigen::Vector3d down_axis =
        from.along.cross(Eigen::Vector3d::UnitZ()).norm() > 1e-6
            ? Eigen::Vector3d(from.along.cross(Eigen::Vector3d::UnitZ()).normalized())
            : from.across;
    Fork end = from;
    constexpr int kPieces = 12;
    stem.points_m.push_back(end.at_m);
    stem.radii_m.push_back(radius_begin_m);
    for (int i = 1; i <= kPieces; ++i) {
      end.along = Eigen::AngleAxisd(droop_rad / kPieces, down_axis) * end.along;
      end.at_m += length_m / kPieces * end.along;
      stem.points_m.push_back(end.at_m);
      stem.radii_m.push_back(
          std::lerp(radius_begin_m, radius_end_m, static_cast<double>(i) / kPieces));
    }
    end.across = (end.across - end.across.dot(end.along) * end.along).normalized();
    end.stem = static_cast<int>(plant.stems.size());
    plant.stems.push_back(std::move(stem));
    return end;
  }

  const TrussShape& shape_;
  const TrussConfig& config_;
  Rng rng_;
};

/// The ground beside the bed, on which long trusses lie.
BendingObstacle path(const TrussShape& shape) {
  BendingObstacle box;
  box.half_m = {3, 3, 0.2};
  box.world_from_box.translation_m = {0, 0, -shape.bed_height_m - 0.2};
  return box;
}

/// What a fruit of a rank is like: later ranks are smaller and behind.
StrawberryConfig fruit_config(const TrussShape& shape, const TrussConfig& config, double ripeness,
                              int rank, const std::optional<Ripening>& ripening, Rng rng) {
  StrawberryConfig fruit;
  fruit.variety = config.variety;
  fruit.numbers = config.numbers;
  fruit.grid = config.grid;
  fruit.family = config.family;
  fruit.elongation = config.elongation;
  const double stage = ripeness_of_rank(shape, ripeness, rank, rng);
  double color = stage;
  if (ripening && stage > 0) color = ripeness_of_rank(shape, ripening->first, rank, ripening->rng);
  fruit.red_share = std::clamp(color, 0.0, 1.0);
  const auto k = static_cast<std::size_t>(std::min(rank, 3));
  const double grown =
      std::clamp(1 + shape.growth_by_ripeness * std::min(0.0, stage - shape.grown_ripeness),
                 shape.growth_least, 1.0);
  fruit.growth = std::clamp(std::cbrt(shape.mass_by_rank[k]) * grown, 0.1, 1.5);
  fruit.to_sun = config.to_sun;  // it hangs nearly upright
  return fruit;
}

/// The point of the hanging stalk that is cut, in the fruit's frame.
Eigen::Vector3d cut_point_m(const Truss& truss, std::size_t fruit, double above_m) {
  const BendingLoad& load = truss.plant.loads[fruit];
  const BendingStem& stem = truss.plant.stems[static_cast<std::size_t>(load.stem)];
  const double share = std::max(0.0, 1 - above_m / length_m(stem));
  return inverse(truss.world_from_fruit[fruit]) *
         bend_m(truss.plant, truss.sag.bent, load.stem, share, point_at_m(stem, share));
}

}  // namespace

double draw_ripeness(const TrussShape& shape, Rng rng) {
  return uniform(rng, shape.ripeness_low, shape.ripeness_high);
}

double ripeness_of_rank(const TrussShape& shape, double first, int rank, Rng rng) {
  return first - shape.lag_by_rank * rank + shape.lag_spread * truncated_normal(rng, 0, 1, 2);
}

std::vector<int> ranks_of(const TrussConfig& config, Rng rng) {
  validate(config);
  BendingPlant plant;
  std::vector<int> ranks;
  for (const TrussGrower::Place& place :
       TrussGrower(config.shape, config, rng.fork("stems")).grow(plant))
    ranks.push_back(place.rank);
  return ranks;
}

BendingPlant grow_stalks(const TrussConfig& config, Rng rng) {
  validate(config);
  BendingPlant plant;
  TrussGrower(config.shape, config, rng.fork("stems")).grow(plant);
  return plant;
}

Truss grow_truss(const TrussConfig& config, Rng rng, const std::optional<Ripening>& ripening) {
  validate(config);
  const TrussShape& shape = config.shape;
  Truss truss;
  truss.shape = shape;
  TrussGrower grower(shape, config, rng.fork("stems"));
  const std::vector<TrussGrower::Place> places = grower.grow(truss.plant);
  const double ripeness = config.ripeness.value_or(draw_ripeness(shape, rng.fork("ripeness")));
  truss.cut_above_m = numbers_of(config.variety, config.numbers).cut_point_m;
  truss.fruits.resize(places.size());
  truss.unbent_from_fruit.resize(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const Rng one = rng.fork("fruit").fork(i);
    std::optional<Ripening> own = ripening;
    if (own) own->rng = own->rng.fork(i);
    // Its stalk's end points into it, from its calyx to its tip.
    Pose& unbent = truss.unbent_from_fruit[i];
    unbent.rotation =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -places[i].along);
    truss.fruits[i] = make_strawberry(
        fruit_config(shape, config, ripeness, places[i].rank, own, one.fork("stage")),
        one.fork("model"));
    unbent.translation_m = places[i].end_m - unbent.rotation * truss.fruits[i].stalk_base_m;
  });
  for (std::size_t i = 0; i < places.size(); ++i) {
    BendingLoad load;
    load.stem = places[i].stem;
    load.mass_kg = truss.fruits[i].mass_kg * config.heavier;
    load.centroid_m = truss.unbent_from_fruit[i].translation_m;
    load.hulls = {truss.fruits[i].hull};
    load.world_from_hulls = truss.unbent_from_fruit[i].rotation;
    // Of the fruit's shadow.
    load.drag_area_m2 =
        shape.fruit_drag * std::numbers::pi / 4 * std::pow(trait(truss.fruits[i], "diameter"), 2);
    truss.plant.loads.push_back(std::move(load));
    truss.rank.push_back(places[i].rank);
  }
  truss.plant.obstacles = bed_obstacles(shape);
  truss.plant.obstacles.push_back(path(shape));
  return truss;
}

std::vector<double> asked_red_shares(const TrussConfig& config, Rng rng,
                                     const std::optional<Ripening>& ripening) {
  validate(config);
  const TrussShape& shape = config.shape;
  const double ripeness = config.ripeness.value_or(draw_ripeness(shape, rng.fork("ripeness")));
  std::vector<double> shares;
  const std::vector<int> ranks = ranks_of(config, rng);
  for (std::size_t k = 0; k < ranks.size(); ++k) {
    std::optional<Ripening> own = ripening;
    if (own) own->rng = own->rng.fork(k);
    shares.push_back(fruit_config(shape, config, ripeness, ranks[k], own,
                                  rng.fork("fruit").fork(k).fork("stage"))
                         .red_share);
  }
  return shares;
}

BendingPlant bending_plant(std::span<const Truss> trusses) {
  BendingPlant all;
  for (const Truss& truss : trusses) {
    const int first = static_cast<int>(all.stems.size());
    for (BendingStem stem : truss.plant.stems) {
      if (stem.parent >= 0) stem.parent += first;
      all.stems.push_back(std::move(stem));
    }
    for (BendingLoad load : truss.plant.loads) {
      load.stem += first;
      all.loads.push_back(std::move(load));
    }
  }
  if (!trusses.empty()) all.obstacles = trusses.front().plant.obstacles;
  return all;
}

namespace {

/// @throws std::invalid_argument naming the stem if the bent shape has other stems or nodes.
void check_shape(std::span<const Truss> trusses, const BentPlant& bent) {
  std::size_t s = 0;
  for (const Truss& truss : trusses) {
    for (const BendingStem& stem : truss.plant.stems) {
      const auto nodes = static_cast<std::size_t>(stem.segments) + 1;
      if (s >= bent.sections.size() || s >= bent.joints_rad.size() ||
          bent.sections[s].size() != nodes || bent.joints_rad[s].size() != 3 * (nodes - 1))
        throw std::invalid_argument("trusses: the bent shape is of others: stem " +
                                    std::to_string(s) + " has not " + std::to_string(nodes) +
                                    " nodes");
      ++s;
    }
  }
  if (s == bent.sections.size() && s == bent.joints_rad.size()) return;
  throw std::invalid_argument("trusses: the bent shape is of others: it has " +
                              std::to_string(bent.sections.size()) + " stems, they have " +
                              std::to_string(s));
}

}  // namespace

void hang(std::span<Truss> trusses, const SagResult& sag) {
  check_shape(trusses, sag.bent);
  auto first = std::ptrdiff_t{0};
  for (Truss& truss : trusses) {
    const auto end = first + static_cast<std::ptrdiff_t>(truss.plant.stems.size());
    truss.sag = sag;
    truss.sag.bent.sections.assign(sag.bent.sections.begin() + first,
                                   sag.bent.sections.begin() + end);
    truss.sag.bent.joints_rad.assign(sag.bent.joints_rad.begin() + first,
                                     sag.bent.joints_rad.begin() + end);
    first = end;
    truss.status = sag.status;
    truss.world_from_fruit.clear();
    for (std::size_t i = 0; i < truss.fruits.size(); ++i) {
      truss.world_from_fruit.push_back(
          bent_from_unbent(truss.plant, truss.sag.bent, truss.plant.loads[i].stem, 1) *
          truss.unbent_from_fruit[i]);
      for (Keypoint& keypoint : truss.fruits[i].flesh.model.keypoints) {
        if (keypoint.name == "cut_point")
          keypoint.in_object_m = cut_point_m(truss, i, truss.cut_above_m);
      }
    }
  }
}

SagConfig truss_sag() {
  SagConfig config;
  config.step_s = 0.004;
  return config;
}

SagResult settle_trusses(std::span<const Truss> trusses) {
  const BendingPlant plant = bending_plant(trusses);
  SagResult rest = sag(plant, truss_sag());
  if (rest.status == PlantStatus::engine_warning) rest = sag(plant);
  return rest;
}

Truss make_truss(const TrussConfig& config, Rng rng) {
  Truss truss = grow_truss(config, rng);
  const SagResult rest = settle_trusses({&truss, 1});
  hang({&truss, 1}, rest);
  return truss;
}

}  // namespace cousin
