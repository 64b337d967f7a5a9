#include "scenes/maize/maize_scene.h"
#include "scenes/maize/maize_text.h"
#include "scenes/maize/toml_text.h"

namespace cousin {
namespace {

const std::vector<CousinMove>& maize_moves() {
  static const std::vector<CousinMove> kMoves =
      read_cousin_moves(maize_cousins_toml(), "scenes/maize/cousins.toml");
  return kMoves;
}

}  // namespace

Scene build_scene(const MaizeSceneConfig& config, const SceneBuild& which) {
  return build_maize_scene(config, which.rng().fork("build"));
}

const SceneRow& maize_row() {
  static const SceneRow kRow = {
      .text = kMaizeText,
      .why_paths = kLeavesLetLightThrough,
      .cousin_moves = maize_moves,
      .defaults = []() -> SceneConfig { return SceneConfig(MaizeSceneConfig()); }};
  return kRow;
}

std::vector<std::string> specimen_categories(const MaizeSceneConfig& /*config*/) {
  return {"maize"};
}

const SceneRow& row_of(const MaizeSceneConfig&) { return maize_row(); }

}  // namespace cousin
