#include "benchmarks/app/pipeline_options.h"

#include "benchmarks/app/option_keys.h"

namespace cousin {
namespace {

/// "--pipeline views" of those that score a scene as a whole.
std::string whole_scene_pipelines() {
  std::string names;
  for (const PipelineRow* each : pipeline_table()) {
    const PipelineRow& row = *each;
    if (row.traits_of == TraitsOf::nothing)
      names += (names.empty() ? "--pipeline " : " or ") + std::string(row.name);
  }
  return names;
}

}  // namespace

PipelineConfig configured_pipeline(const Options& options, const PipelineConfig& start) {
  const KeyOption method{"--method", "method", options.method};
  return read_config(options, {method}, [&] {
    PipelineConfig config = start;
    if (!options.config.empty())
      read_toml(options.config, fields(config), MissingKeys::keep_default);
    if (!method.value.empty()) set_field(fields(config), method.assignment());
    for (const std::string& assignment : options.sets) {
      constexpr std::string_view kPrefix = "pipeline.";
      set_field(fields(config),
                assignment.starts_with(kPrefix) ? assignment.substr(kPrefix.size()) : assignment);
    }
    validate(config);
    return config;
  });
}

std::vector<StageSource> stage_sources(const Options& options, const PipelineRow& row) {
  std::vector<StageSource> sources;
  for (const std::string& stage : options.stages)
    sources.push_back(parse_stage_source(stage, options.stage_time_limit_s));
  check_stages(sources, row.order, row.name);
  return sources;
}

void refuse_foreign_options(const Options& options, const PipelineRow& row) {
  const std::string name(row.name);
  if (row.traits_of == TraitsOf::nothing || row.traits_of == TraitsOf::depths) {
    refuse_given(options, {"--attribution"},
                 "is of pipelines that measure traits; pipeline " + name +
                     " puts no truth in place of stages");
  }
  if (row.traits_of == TraitsOf::nothing) return;
  refuse_whole_scene_options(options);
}

void refuse_whole_scene_options(const Options& options) {
  refuse_given(options, {"--align"},
               "is of " + whole_scene_pipelines() + ": traits are measured in metres");
  refuse_given(options, {"--lpips"},
               "is of " + whole_scene_pipelines() +
                   "; `cousin bench seeds` has it for the Gaussians of seeds");
}

std::shared_ptr<const LearnedDistance> learned_of(const Options& options) {
  return options.lpips.empty() ? nullptr : load_learned_distance(options.lpips);
}

}  // namespace cousin
