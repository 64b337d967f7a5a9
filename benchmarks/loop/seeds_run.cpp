#include "benchmarks/loop/seeds_run.h"

#include <stdexcept>

namespace cousin {
namespace {

template <class Own>
Own& own_or_throw(Own* own, const char* what) {
  if (!own) throw std::logic_error(std::string("not a run of seeds: another ") + what);
  return *own;
}

}  // namespace

RunConfig seeds_run_config(const std::vector<std::string>& assignments,
                           const std::filesystem::path& file) {
  return run_config(seeds_row(), assignments, file, PipelineConfig(SeedsPipelineConfig()));
}

SeedsSceneConfig& seeds_scene(RunConfig& config) {
  return own_or_throw(config.scene.get_if<SeedsSceneConfig>(), "scene");
}
const SeedsSceneConfig& seeds_scene(const RunConfig& config) {
  return own_or_throw(config.scene.get_if<SeedsSceneConfig>(), "scene");
}
SeedsPipelineConfig& seeds_pipeline(RunConfig& config) {
  return own_or_throw(config.pipeline ? config.pipeline->get_if<SeedsPipelineConfig>() : nullptr,
                      "pipeline");
}
const SeedsPipelineConfig& seeds_pipeline(const RunConfig& config) {
  return own_or_throw(config.pipeline ? config.pipeline->get_if<SeedsPipelineConfig>() : nullptr,
                      "pipeline");
}

}  // namespace cousin
