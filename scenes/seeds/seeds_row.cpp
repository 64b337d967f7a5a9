#include <stdexcept>

#include "scenes/seeds/seeds_scene.h"
#include "scenes/seeds/seeds_text.h"
#include "scenes/seeds/toml_text.h"

namespace cousin {
namespace {

std::optional<UserMesh> user_specimen(const SeedsSceneConfig& config) {
  const std::string file = specimen_file(config);
  if (file.empty()) return std::nullopt;
  UserMesh user = welded(read_user_mesh(file));
  for (Eigen::Vector3d& vertex : user.mesh.vertices_m) vertex *= config.specimen_scale;
  return user;
}

std::optional<Environment> user_environment(const SeedsSceneConfig& config,
                                            const SceneBuild& which) {
  if (config.environment.empty()) return std::nullopt;
  if (!which.read_environment) throw std::logic_error("seeds: nobody reads environments");
  return which.read_environment(config.environment, config.environment_scale);
}

const std::vector<CousinMove>& seeds_moves() {
  static const std::vector<CousinMove> kMoves =
      read_cousin_moves(seeds_cousins_toml(), "scenes/seeds/cousins.toml");
  return kMoves;
}

}  // namespace

Scene build_scene(const SeedsSceneConfig& config, const SceneBuild& which) {
  return build_seeds_scene(config, which.rng().fork("build"), user_specimen(config),
                           user_environment(config, which));
}

std::vector<UserFile> user_files(const SeedsSceneConfig& config) {
  std::vector<UserFile> files;
  const std::string mesh = specimen_file(config);
  if (!mesh.empty())
    files.push_back(
        {.setting = "specimen = \"" + config.specimen + "\"", .path = mesh, .is_mesh = true});
  if (!config.environment.empty())
    files.push_back(
        {.setting = "environment = \"" + config.environment + "\"", .path = config.environment});
  return files;
}

std::vector<std::string> specimen_categories(const SeedsSceneConfig& config) {
  if (config.sphere) return {"sphere"};
  if (!config.specimen.empty()) return {"specimen"};
  if (config.cultivar == "mixed") return cultivar_names();
  return {config.cultivar};
}

PhysicsUse physics_of(const SeedsSceneConfig& config) {
  return {true, config.sphere ? "a sphere is dropped and settles on the board"
                              : "seeds are dropped and settle on the board"};
}

void check_movable(const SeedsSceneConfig& config, const CousinDistance& distance) {
  const auto refuse = [](const std::string& axis, const std::string& why) {
    throw std::invalid_argument("cousin." + axis + " is above 0, but " + why);
  };
  const bool is_grown = config.specimen.empty() && !config.sphere;
  for (const auto& [axis, value] : {std::pair{"shape", distance.shape},
                                    {"growth", distance.growth},
                                    {"texture", distance.texture}}) {
    if (value > 0 && !is_grown)
      refuse(axis, "the specimens are not grown: it moves a cultivar's numbers");
    if (value > 0 && config.seeds == 0) refuse(axis, "there are no seeds");
  }
  if (distance.light > 0 && !config.environment.empty())
    refuse("light", "an environment picture lights the scene: it moves lamps and sun");
  if (distance.texture > 0 && !config.gloss)
    refuse("texture", "gloss is false: it moves the coat's roughness");
}

std::string specimen_file(const SeedsSceneConfig& config) {
  constexpr std::string_view kMesh = "mesh:";
  if (config.specimen.empty()) return {};
  if (!config.specimen.starts_with(kMesh) || config.specimen == kMesh) {
    throw std::invalid_argument("specimen = \"" + config.specimen + "\" is not \"mesh:FILE\"");
  }
  return config.specimen.substr(kMesh.size());
}

const SceneRow& seeds_row() {
  static const SceneRow kRow = {
      .text = kSeedsText,
      .shows = "board, screen, specimens",
      // As deep as the cache, whose 4 bounces come after its points.
      .paths = {.max_bounces = 5},
      .cousin_moves = seeds_moves,
      .defaults = []() -> SceneConfig { return SceneConfig(SeedsSceneConfig()); }};
  return kRow;
}

const SceneRow& row_of(const SeedsSceneConfig&) { return seeds_row(); }

}  // namespace cousin
