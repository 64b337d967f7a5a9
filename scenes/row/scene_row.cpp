#include "scenes/row/scene_row.h"

#include <set>

namespace cousin {

Fields fields(SceneConfig& config) { return config.own_->keys(); }
void validate(const SceneConfig& config) { config.own_->check(); }
void see(SceneConfig& config, const RigSight& sight) { config.own_->look(sight); }
Scene build_scene(const SceneConfig& config, const SceneBuild& which) {
  return config.own_->build(which);
}
std::vector<std::string> shared_plants(const SceneConfig& config, int index) {
  return config.own_->shared(index);
}
bool is_series(const SceneConfig& config) { return config.own_->series(); }
std::vector<UserFile> user_files(const SceneConfig& config) { return config.own_->files(); }
std::vector<std::string> specimen_categories(const SceneConfig& config) {
  const std::vector<std::string> all = config.own_->categories();
  const std::set<std::string> sorted(all.begin(), all.end());
  return {sorted.begin(), sorted.end()};
}
std::string* cache_folder(SceneConfig& config) { return config.own_->cache(); }
PhysicsUse physics_of(const SceneConfig& config) { return config.own_->physics(); }
void check_movable(const SceneConfig& config, const CousinDistance& distance) {
  config.own_->movable(distance);
}
const SceneRow& row_of(const SceneConfig& config) { return config.own_->row(); }

}  // namespace cousin
