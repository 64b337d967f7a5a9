#include "scenes/fruit/fruit_model.h"
#include "scenes/strawberries/strawberries_scene.h"
#include "scenes/strawberries/strawberries_text.h"
#include "scenes/strawberries/strawberry_toml.h"
#include "scenes/strawberries/variety.h"

namespace cousin {
namespace {

constexpr const char* kExtension = ".stand";

const std::vector<CousinMove>& strawberries_moves() {
  static const std::vector<CousinMove> kMoves =
      read_cousin_moves(strawberry_cousins_toml(), "scenes/strawberries/cousins.toml");
  return kMoves;
}

}  // namespace

/// Stretches of bed come again with other colours, light and views.
Scene build_scene(const StrawberriesSceneConfig& config, const SceneBuild& which) {
  const int stretch = which.index % config.plants;
  return build_strawberries_scene(config, stand_at_rest(config, which.seed, stretch, which.rests),
                                  stretch_rng(which.seed, stretch), which.rng().fork("build"));
}

void see(StrawberriesSceneConfig& config, const RigSight& sight) { config.eye = sight.eye; }

std::vector<std::string> shared_plants(const StrawberriesSceneConfig& config, int index) {
  return {"stretch " + std::to_string(index % config.plants)};
}

std::vector<std::string> specimen_categories(const StrawberriesSceneConfig& config) {
  if (config.category == "variety") return strawberry_varieties();
  return {kMaturities.begin(), kMaturities.end()};
}

std::string* cache_folder(StrawberriesSceneConfig& config) { return &config.cache; }

PhysicsUse physics_of(const StrawberriesSceneConfig& config) {
  return {true, "trusses hang at rest, or come from the folder `cache`", !is_still(config.motion)};
}

Rng stretch_rng(std::uint64_t seed, int plant) {
  return Rng(seed).fork("strawberry stretch").fork(static_cast<std::uint64_t>(plant));
}

std::string stand_key(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant) {
  return description(config.stand, config.bed) + "\nseed " + std::to_string(seed) + "\nstretch " +
         std::to_string(plant);
}

StandRest stand_at_rest(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant,
                        const RestStore* rests) {
  const Rng rng = stretch_rng(seed, plant);
  if (!rests) return settle_stand(config.stand, config.bed, rng);
  const std::string key = stand_key(config, seed, plant);
  if (const auto kept = rests->find(key, kExtension))
    return rest_from_text(kept->text, kept->where, config.stand, config.bed, rng);
  StandRest rest = settle_stand(config.stand, config.bed, rng);
  rests->keep(key, kExtension, to_text(rest));
  return rest;
}

const SceneRow& strawberries_row() {
  static const SceneRow kRow = {
      .text = kStrawberriesText,
      .why_paths = kLeavesLetLightThrough,
      .cousin_moves = strawberries_moves,
      .defaults = []() -> SceneConfig { return SceneConfig(StrawberriesSceneConfig()); }};
  return kRow;
}

const SceneRow& row_of(const StrawberriesSceneConfig&) { return strawberries_row(); }

}  // namespace cousin
