// The pipeline of seeds as a row of the table.
#include "perception/cloud/measure_traits.h"
#include "perception/pipelines/pipeline_table.h"
#include "perception/pipelines/seeds.h"

namespace cousin {

const PipelineRow& seeds_pipeline();

bool needs_sfm(const Capture& /*capture*/, const SeedsPipelineConfig& config) {
  return needs_sfm(config);
}

void check_capture(const Capture& capture, const SeedsPipelineConfig& config) {
  board_of(capture, config);
  require_images(capture, config);
}

std::vector<std::string> unused_settings(const SeedsPipelineConfig& config) {
  const bool trains =
      config.method == SeedsMethod::splats || config.method == SeedsMethod::splats_paper;
  if (trains || config.splats.poses == SplatPoses::board) return {};
  return {"splats.poses=" + std::string(to_string(config.splats.poses)) +
          " is not used: it is of the methods splats and splats_paper"};
}

Stages stages_for(const SeedsPipelineConfig& config, const Capture& /*capture*/, std::uint64_t seed,
                  const SplatWatch& watch) {
  return seeds_stages(config, seed, watch);
}

const PipelineRow& row_of(const SeedsPipelineConfig& /*config*/) { return seeds_pipeline(); }

const PipelineRow& seeds_pipeline() {
  static const PipelineRow kRow = {
      .name = "seeds",
      .help = "seeds on a calibration board: five sizes of each",
      .scenes = {"seeds"},
      .order = seeds_stage_order(),
      .traits = {kSeedTraits.begin(), kSeedTraits.end()},
      .methods =
          {{"ours",
            "board poses, plane sweep, sub-pixel outlines, closed surface per seed, minimum-volume "
            "box",
            {"CERES"}},
           {"paper",
            "the paper's steps: outlier removal, voxel grid, RANSAC plane, clusters, PCA box, "
            "alpha shape",
            {"PCL", "CERES"}},
           {"sensor_depth",
            "ours with a depth camera's own depth in place of the plane sweep; reads color,depth "
            "(--set rig=d405)",
            {"CERES"}},
           {"depth_only",
            "a depth camera on an arm that knows its poses: points, PCA box, alpha shape; reads "
            "depth (--set rig=d405 --set knows_pose=true)"},
           {"splats",
            "Gaussians that begin on the closed surfaces of ours, trained on the board's part of "
            "each photograph, their depth fused; then outlines, closed surfaces and boxes as ours",
            {"CERES"}},
           {"splats_paper",
            "the paper's chain: Gaussians trained as their reference does, their centres, the "
            "paper's steps (perceive --set splats.poses=sfm, run --set pipeline.splats.poses=sfm: "
            "poses by COLMAP; adjusted: by our adjustment of its tracks)",
            {"PCL", "CERES"}}},
      .defaults = [] { return PipelineConfig(SeedsPipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
