#include "scenes/seedlings/seedlings_scene.h"
#include "scenes/seedlings/seedlings_text.h"
#include "scenes/seedlings/toml_text.h"

namespace cousin {
namespace {

const std::vector<CousinMove>& seedlings_moves() {
  static const std::vector<CousinMove> kMoves =
      read_cousin_moves(seedling_cousins_toml(), "scenes/seedlings/cousins.toml");
  return kMoves;
}

}  // namespace

/// A growth series is one tray on one day after another.
Scene build_scene(const SeedlingsSceneConfig& config, const SceneBuild& which) {
  SeedlingsSceneConfig own = config;
  own.day += which.index * config.day_step;
  const SceneBuild tray{.seed = which.seed, .index = is_series(config) ? 0 : which.index};
  return build_seedlings_scene(own, tray.rng().fork("build"));
}

std::vector<std::string> shared_plants(const SeedlingsSceneConfig& config, int /*index*/) {
  return is_series(config) ? std::vector<std::string>{"tray"} : std::vector<std::string>{};
}

bool is_series(const SeedlingsSceneConfig& config) { return config.day_step > 0; }

const SceneRow& seedlings_row() {
  static const SceneRow kRow = {
      .text = kSeedlingsText,
      .why_paths = kLeavesLetLightThrough,
      .cousin_moves = seedlings_moves,
      .defaults = []() -> SceneConfig { return SceneConfig(SeedlingsSceneConfig()); }};
  return kRow;
}

std::vector<std::string> specimen_categories(const SeedlingsSceneConfig& /*config*/) {
  return {"watermelon"};
}

const SceneRow& row_of(const SeedlingsSceneConfig&) { return seedlings_row(); }

}  // namespace cousin
