// The pipeline of photographs of anything as a row of the table.
#include "perception/pipelines/pipeline_table.h"
#include "perception/pipelines/views.h"

namespace cousin {

const PipelineRow& views_pipeline();

PipelineNeeds needs(const ViewsPipelineConfig& config) {
  PipelineNeeds result{.images = {"color"}, .stages = {"poses", "splats", "depth"}, .left_out = {}};
  const auto stage = [&](const char* name, bool runs, const char* key) {
    if (runs)
      result.stages.emplace_back(name);
    else
      result.left_out.emplace_back(name, std::string(key) + "=0");
  };
  stage("cloud", config.cloud_views > 0, "cloud_views");
  stage("surfaces", config.mesh_cells > 0, "mesh_cells");
  return result;
}

Stages stages_for(const ViewsPipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch) {
  return views_stages(config, capture, seed, watch);
}

const PipelineRow& row_of(const ViewsPipelineConfig& /*config*/) { return views_pipeline(); }

const PipelineRow& views_pipeline() {
  static const PipelineRow kRow = {
      .name = "scene",
      .old_name = "views",
      .help = "Gaussians of photographs of anything (docs/splats.md)",
      .scenes = {},
      .order = views_stage_order(),
      .traits_of = TraitsOf::nothing,
      .methods = {{"splats",
                   "poses of the capture or by COLMAP, Gaussians, their depth, cloud and closed "
                   "mesh, PSNR of views trained on and held out"},
                  {"splats_paper", "the same by the reference's schedule"}},
      .defaults = [] { return PipelineConfig(ViewsPipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
