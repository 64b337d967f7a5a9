#include "scenes/strawberries/strawberry_stand.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "scenes/strawberries/strawberry_toml.h"
#include "sim/config/limits.h"
#include "sim/types/not_built.h"

namespace cousin {
namespace {

constexpr int kAttempts = 4;
constexpr int kMostOnATruss = 7;

std::string draw_variety(const StandConfig& config, Rng rng) {
  if (config.variety != "drawn") return config.variety;
  // Plants of Benihoppe, Akihime and Sweet Charlie [Strawberries 2.1].
  const double u = 180 * uniform(rng);
  return u < 70 ? "benihoppe" : (u < 130 ? "akihime" : "sweet_charlie");
}

[[noreturn]] void fail(const SagResult& sag, double heavier) {
  if (sag.status == PlantStatus::not_built)
    throw NotBuilt("strawberries: MuJoCo is not built in (WITH_MUJOCO=OFF), so no truss can hang");
  char text[200];
  std::snprintf(text, sizeof text,
                "stalk %d is strained %.3g times its strength at %.2f of its length; overlaps are "
                "%.2g m (at most 0.0005)",
                sag.strain.stem, sag.strain.ratio, sag.strain.share, sag.max_penetration_m);
  throw std::runtime_error(
      "strawberries: trusses do not hang at rest in " + std::to_string(kAttempts) +
      " tries, status " + std::string(to_string(sag.status)) + ": " + text +
      (heavier > 1
           ? "; fruits are too heavy for their stalks at heavier = " + std::to_string(heavier)
           : "") +
      (sag.first_warning.empty() ? "" : "; the engine: " + sag.first_warning));
}

}  // namespace

Fields fields(StandConfig& c) {
  Fields truss;
  for (Field& field : fields(c.truss)) {
    if (!field.key.starts_with("ripeness_")) truss.push_back(std::move(field));  // the stand's own
  }
  Fields all = {
      {"variety", &c.variety, "drawn, benihoppe, akihime or sweet_charlie"},
      {"fruits_min", &c.fruits_min, "fewest fruits that hang before the camera", 1, 40},
      {"fruits_max", &c.fruits_max, "most fruits", 1, 40},
      {"fruits_share", &c.fruits_share, "mean of the way from the fewest to the most", 0, 1},
      {"ripeness_low", &c.ripeness_low, "of a truss's first fruit: 0 white, 1 red", -1, 5},
      {"ripeness_high", &c.ripeness_high, "of a truss's first fruit", -1, 5},
      {"heavier", &c.heavier, "times the fruits' masses", 0.01, 1000},
      {"family", &c.family, "of the fruits' shapes: botanical or harmonics"},
      {"elongation", &c.elongation, "times the fruits' length over diameter", 0.4, 2.5},
      {"fruit_grid", &c.fruit_grid, "cells along an edge of a fruit's mesh", 8, 200}};
  all = all + nested("truss", std::move(truss));
  const std::vector<std::string> names = strawberry_varieties();
  for (std::size_t i = 0; i < std::min(names.size(), c.varieties.size()); ++i)
    all = all + nested("varieties." + names[i], fields(c.varieties[i]));
  return all;
}

const StrawberryVariety& numbers_of(const StandConfig& config, const std::string& variety) {
  strawberry_variety(variety);
  const std::vector<std::string> names = strawberry_varieties();
  const auto found = std::find(names.begin(), names.end(), variety);
  return config.varieties.at(static_cast<std::size_t>(found - names.begin()));
}

void validate(const StandConfig& config) {
  StandConfig copy = config;
  check_limits(fields(copy), "strawberries");
  if (config.variety != "drawn") strawberry_variety(config.variety);
  fruit_family(config.family);
  validate(config.truss);
  if (config.varieties.size() != strawberry_varieties().size())
    throw std::invalid_argument("strawberries: there are numbers of " +
                                std::to_string(config.varieties.size()) + " varieties, not of " +
                                std::to_string(strawberry_varieties().size()));
  for (const StrawberryVariety& variety : config.varieties) validate(variety);
  if (config.fruits_min > config.fruits_max)
    throw std::invalid_argument("fruits_min " + std::to_string(config.fruits_min) +
                                " is above fruits_max " + std::to_string(config.fruits_max));
  if (config.ripeness_low > config.ripeness_high)
    throw std::invalid_argument("ripeness_low " + std::to_string(config.ripeness_low) +
                                " is above ripeness_high " + std::to_string(config.ripeness_high));
}

Stand draw_stand(const StandConfig& config, const StrawberryBedConfig& bed, Rng rng) {
  validate(config);
  Stand stand;
  stand.variety = draw_variety(config, rng.fork("variety"));
  stand.ripeness_low = config.ripeness_low;
  stand.ripeness_high = config.ripeness_high;
  Rng count = rng.fork("fruits");
  int left = config.fruits_min;
  for (int i = config.fruits_min; i < config.fruits_max; ++i)
    left += uniform(count) < config.fruits_share ? 1 : 0;
  const int middle = bed.row.plants / 2;
  // Two trusses a plant, from the middle plant outwards.
  for (int k = 0; left > 0; ++k) {
    Rng own = rng.fork("truss").fork(static_cast<std::uint64_t>(k));
    const int step = (k / 2 + 1) / 2 * ((k / 2) % 2 == 0 ? -1 : 1);
    const int crown = std::clamp(middle + step, 0, bed.row.plants - 1);
    TrussConfig truss;
    truss.family = fruit_family(config.family);
    truss.elongation = config.elongation;
    truss.variety = stand.variety;
    truss.numbers = numbers_of(config, stand.variety);
    truss.shape = config.truss;
    truss.fruits = std::min(left, 2 + static_cast<int>(uniform_index(own, kMostOnATruss - 1)));
    truss.heavier = config.heavier;
    Rng ripe = own.fork("ripeness");
    truss.ripeness = uniform(ripe, config.ripeness_low, config.ripeness_high);
    truss.grid = config.fruit_grid;
    truss.along_m =
        std::clamp(crown_in_world_m(bed, config.truss, crown, true, rng).y(), -0.5, 0.5);
    const double apart_rad = config.truss.apart_rad;
    truss.turn_rad = (k % 2 == 0 ? -apart_rad : apart_rad) +
                     config.truss.apart_spread_rad * truncated_normal(own, 0, 1, 2);
    left -= truss.fruits;
    stand.trusses.push_back(truss);
    stand.crowns.push_back(crown);
  }
  return stand;
}

std::optional<Ripening> ripening_of(const Stand& stand, const std::optional<Ripening>& all,
                                    std::size_t truss) {
  if (!all) return all;
  Ripening own{0, all->rng.fork(truss)};
  Rng first = own.rng.fork("first");
  own.first = uniform(first, stand.ripeness_low, stand.ripeness_high);
  return own;
}

std::vector<Truss> grow_trusses(const Stand& stand, const Rng& rng,
                                const std::optional<Ripening>& ripening) {
  std::vector<Truss> trusses;
  for (std::size_t i = 0; i < stand.trusses.size(); ++i)
    trusses.push_back(
        grow_truss(stand.trusses[i], truss_rng(rng, i), ripening_of(stand, ripening, i)));
  return trusses;
}

Rng attempt_rng(const Rng& rng, int attempt) {
  return rng.fork("attempt").fork(static_cast<std::uint64_t>(attempt));
}

Rng truss_rng(const Rng& rng, std::size_t truss) { return rng.fork("grow").fork(truss); }

StandRest settle_stand(const StandConfig& config, const StrawberryBedConfig& bed, const Rng& rng) {
  StandRest rest;
  for (; rest.attempt < kAttempts; ++rest.attempt) {
    const Rng own = attempt_rng(rng, rest.attempt);
    const std::vector<Truss> trusses = grow_trusses(draw_stand(config, bed, own), own);
    rest.sag = settle_trusses(trusses);
    if (rest.sag.status == PlantStatus::ok) return rest;
    if (rest.sag.status == PlantStatus::not_built) break;
  }
  fail(rest.sag, config.heavier);
}

bool can_settle() {
  BendingPlant plant;
  BendingStem stem;
  stem.points_m = {{0, 0, 0}, {0, 0, 0.1}};
  stem.radii_m = {0.001, 0.001};
  stem.segments = 1;
  plant.stems.push_back(stem);
  return sag(plant).status != PlantStatus::not_built;
}

}  // namespace cousin
