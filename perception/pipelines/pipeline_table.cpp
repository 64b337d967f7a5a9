#include "perception/pipelines/pipeline_table.h"

#include <algorithm>
#include <stdexcept>

namespace cousin {

// To add a pipeline, add its line: the function that its own file has. The first is taken where
// nobody says which.
#define COUSIN_PIPELINES(PIPELINE) \
  PIPELINE(seeds_pipeline)         \
  PIPELINE(strawberries_pipeline)  \
  PIPELINE(apples_pipeline)        \
  PIPELINE(tree_pipeline)          \
  PIPELINE(maize_pipeline)         \
  PIPELINE(stereo_pipeline)        \
  PIPELINE(views_pipeline)

#define COUSIN_DECLARE(row) const PipelineRow& row();
COUSIN_PIPELINES(COUSIN_DECLARE)
#undef COUSIN_DECLARE

std::vector<const PipelineRow*> pipeline_table() {
#define COUSIN_NAME(row) &row(),
  return {COUSIN_PIPELINES(COUSIN_NAME)};
#undef COUSIN_NAME
}

Fields fields(PipelineConfig& config) { return config.own_->keys(); }
void validate(const PipelineConfig& config) { config.own_->check(); }
std::string_view method_of(const PipelineConfig& config) { return config.own_->method(); }
PipelineNeeds needs(const PipelineConfig& config) { return config.own_->reads(); }
bool needs_sfm(const Capture& capture, const PipelineConfig& config) {
  return config.own_->asks_sfm(capture);
}
void check_capture(const Capture& capture, const PipelineConfig& config) {
  config.own_->check_images(capture);
}
std::vector<std::string> unused_settings(const PipelineConfig& config) {
  return config.own_->unused();
}
Stages stages_for(const PipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch) {
  return config.own_->make(capture, seed, watch);
}
const PipelineRow& row_of(const PipelineConfig& config) { return config.own_->row(); }

Estimate run_pipeline(const Capture& capture, const PipelineConfig& config, const Stages& stages,
                      const StageObserver& observer) {
  validate(config);
  if (!capture.frames.empty()) check_capture(capture, config);
  return run_stages(capture, stages, row_of(config).order, observer);
}

std::string pipeline_names() {
  std::string names;
  for (const PipelineRow* row : pipeline_table())
    names += (names.empty() ? "" : ", ") + std::string(row->name);
  return names;
}

const PipelineRow& pipeline_row(std::string_view name) {
  for (const PipelineRow* row : pipeline_table()) {
    if (row->name == name || (!name.empty() && row->old_name == name)) return *row;
  }
  throw std::invalid_argument("pipeline \"" + std::string(name) +
                              "\" is not one of: " + pipeline_names());
}

const PipelineRow* pipeline_of_scene(std::string_view scene) {
  for (const PipelineRow* row : pipeline_table()) {
    if (std::find(row->scenes.begin(), row->scenes.end(), scene) != row->scenes.end()) return row;
  }
  return nullptr;
}

}  // namespace cousin
