#include <algorithm>

#include "scenes/apples/apples_scene.h"
#include "scenes/apples/apples_text.h"
#include "scenes/apples/apples_toml.h"
#include "scenes/fruit/fruit_model.h"

namespace cousin {
namespace {

constexpr const char* kExtension = ".tree";
/// A person taps on the apple to set the exposure: the camera meters it and the leaves near it.
constexpr double kApple_m = 0.09;

const std::vector<CousinMove>& apples_moves() {
  static const std::vector<CousinMove> kMoves =
      read_cousin_moves(apple_cousins_toml(), "scenes/apples/cousins.toml");
  return kMoves;
}

}  // namespace

Scene build_scene(const ApplesSceneConfig& config, const SceneBuild& which) {
  return build_apples_scene(config, which.rng().fork("build"), tree_settler(config, which));
}

void see(ApplesSceneConfig& config, const RigSight& sight) { config.eye = sight.eye; }

std::vector<std::string> specimen_categories(const ApplesSceneConfig& /*config*/) {
  return {kMaturities.begin(), kMaturities.end()};
}

std::string* cache_folder(ApplesSceneConfig& config) { return &config.cache; }

PhysicsUse physics_of(const ApplesSceneConfig& config) {
  if (!config.sag || !COUSIN_WITH_MUJOCO) return {false, "nothing settles or moves by force"};
  const bool sways = config.wind.mean_speed_m_s > 0 || config.push.force_n > 0;
  return {true,
          sways ? "branches bend under their fruits to rest, and sway"
                : "branches bend under their fruits to rest",
          sways};
}

std::string tree_key(const ApplesSceneConfig& config, const SceneBuild& which) {
  return description_of_tree(config) + "\nseed " + std::to_string(which.seed) + "\ntree " +
         std::to_string(which.index);
}

BranchSettler tree_settler(const ApplesSceneConfig& config, const SceneBuild& which) {
  if (!which.rests) return settle_branches;
  return [key = tree_key(config, which),
          rests = which.rests](const std::vector<HangingBranch>& branches) {
    if (const auto kept = rests->find(key, kExtension))
      return rests_from_text(kept->text, kept->where, branches);
    std::vector<SagResult> settled = settle_branches(branches);
    const bool can_be_kept = std::all_of(settled.begin(), settled.end(), [](const SagResult& sag) {
      return sag.status == PlantStatus::ok || sag.status == PlantStatus::not_at_rest ||
             sag.status == PlantStatus::penetrates;  // what overlaps is thinned
    });
    if (can_be_kept && !settled.empty()) rests->keep(key, kExtension, rests_to_text(settled));
    return settled;
  };
}

const SceneRow& apples_row() {
  static const SceneRow kRow = {
      .text = kApplesText,
      .why_paths = kLeavesLetLightThrough,
      .metered_m = kApple_m,
      .cousin_moves = apples_moves,
      .defaults = []() -> SceneConfig { return SceneConfig(ApplesSceneConfig()); }};
  return kRow;
}

const SceneRow& row_of(const ApplesSceneConfig&) { return apples_row(); }

}  // namespace cousin
