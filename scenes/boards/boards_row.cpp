#include "scenes/boards/boards_scene.h"
#include "scenes/boards/boards_text.h"
#include "scenes/boards/toml_text.h"

namespace cousin {
namespace {

const std::vector<CousinMove>& boards_moves() {
  static const std::vector<CousinMove> kMoves =
      read_cousin_moves(board_cousins_toml(), "scenes/boards/cousins.toml");
  return kMoves;
}

}  // namespace

Scene build_scene(const BoardsSceneConfig& config, const SceneBuild& which) {
  return build_boards_scene(config, which.rng().fork("build"));
}

void see(BoardsSceneConfig& config, const RigSight& sight) {
  const Camera& camera = sight.eye.camera;
  config.half_view = {0.5 * camera.width_px / camera.fx_px, 0.5 * camera.height_px / camera.fy_px};
  config.eye_from_rig = sight.eye.eye_from_rig;
  config.readout_s = sight.readout_s;
}

std::vector<std::string> specimen_categories(const BoardsSceneConfig& config) {
  return {std::string(to_string(config.target.kind))};
}

PhysicsUse physics_of(const BoardsSceneConfig& config) {
  return {false, "nothing settles or moves by force", config.place == "hand"};
}

const SceneRow& boards_row() {
  static const SceneRow kRow = {
      .text = kBoardsText,
      .why_paths = "a held board moves, and some are glossy",
      .cousin_moves = boards_moves,
      .defaults = []() -> SceneConfig { return SceneConfig(BoardsSceneConfig()); }};
  return kRow;
}

const SceneRow& row_of(const BoardsSceneConfig&) { return boards_row(); }

}  // namespace cousin
