#include <stdexcept>

#include "scenes/specimen/specimen_scene.h"
#include "scenes/specimen/specimen_text.h"

namespace cousin {
Scene build_scene(const SpecimenSceneConfig& config, const SceneBuild& which) {
  if (config.mesh.empty())
    throw std::invalid_argument("mesh is not set: --set mesh=FILE names the specimen's file");
  return build_specimen_scene(config, read_user_mesh(config.mesh), which.rng().fork("build"));
}

std::vector<UserFile> user_files(const SpecimenSceneConfig& config) {
  if (config.mesh.empty()) return {};
  return {{.setting = "mesh = \"" + config.mesh + "\"", .path = config.mesh, .is_mesh = true}};
}

const SceneRow& specimen_row() {
  static const SceneRow kRow = {
      .text = kSpecimenText, .why_paths = kLeavesLetLightThrough, .defaults = []() -> SceneConfig {
        return SceneConfig(SpecimenSceneConfig());
      }};
  return kRow;
}

std::vector<std::string> specimen_categories(const SpecimenSceneConfig& config) {
  return {config.name};
}

const SceneRow& row_of(const SpecimenSceneConfig&) { return specimen_row(); }

}  // namespace cousin
