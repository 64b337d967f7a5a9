#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calibration/boards/board_detection.h"
#include "calibration/boards/board_poses.h"
#include "perception/cloud/clusters.h"
#include "perception/cloud/fuse.h"
#include "perception/cloud/measure_traits.h"
#include "perception/mvs/plane_sweep.h"
#include "perception/pipelines/estimate.h"
#include "perception/pipelines/pipeline_needs.h"
#include "perception/pipelines/seeds_splats.h"
#include "perception/segment/green.h"
#include "perception/silhouette/outlines.h"
#include "perception/silhouette/surface_fit.h"
#include "perception/stereo/sensor_depth.h"

namespace cousin {

/// `ours` fits closed surfaces and `paper` measures clusters of points; both take depth from
/// several views. `sensor_depth` is ours with a depth camera's own depth in its place. `depth_only`
/// looks at no colour: a rig that knows its poses, its depth, clusters of points. `splats_paper` is
/// the Seeds paper's own chain: Gaussians trained as the reference trains them, their centres are
/// the cloud that its steps measure. `splats` is ours with the depth of Gaussians that are trained
/// our way from what ours finds.
enum class SeedsMethod { ours, paper, sensor_depth, depth_only, splats, splats_paper };

/// Which print lies under the seeds. A real capture without a rig.json does not say: then it is
/// asked for here.
enum class BoardKind { as_reported, markers, plain };

struct SeedsPipelineConfig {
  SeedsMethod method = SeedsMethod::ours;
  BoardKind board_kind = BoardKind::as_reported;
  double margin_m = 0.002;       ///< reconstructed beyond the plate's edge
  double below_board_m = 0.002;  ///< and below its face
  double tallest_m = 0.026;      ///< objects on the board are at most this high
  BoardDetectionConfig board;
  BoardPosesConfig poses;
  GreenConfig green;
  MvsConfig mvs;
  SensorDepthConfig sensor_depth;
  SeedsSplatConfig splats;
  /// Of the methods that read a sensor's depth: depths of two views agree within so many of their
  /// sigmas, if that is more than fuse.agreement_m.
  double agreement_sigmas = 3;
  /// Of `sensor_depth`, beside the others' own: sigma of an offset of all outlines, and of sizes
  /// and heights. A depth camera's colour imager is coarser than a phone's and moves while it
  /// exposes: outlines lie too far out. Fitted to the scatter of rendered maize before a D405 at
  /// 0.15 m, where a pixel spans 0.23 mm (seed 1; scored on another).
  double sensor_outline_sigma_px = 0.15;
  double sensor_size_sigma_m = 0.00005;
  double sensor_height_sigma_m = 0.0002;
  FuseConfig fuse;
  PaperClusterConfig paper_clusters;
  BoardClusterConfig clusters;
  OutlineConfig outlines;
  SurfaceFitConfig surface;
  MeshTraitConfig traits;
  PaperTraitConfig paper_traits;
};
Fields fields(SeedsPipelineConfig& config);
void validate(const SeedsPipelineConfig& config);

/// @param watch  of the training of Gaussians
/// @throws std::invalid_argument if a config is not valid.
Stages seeds_stages(const SeedsPipelineConfig& config, std::uint64_t seed,
                    const SplatWatch& watch = {});

/// All stages that any of its methods has, in order.
StageOrder seeds_stage_order();

/// The board a configuration and a capture agree on; without a word from either, the one with
/// markers.
SeedBoard board_of(const Capture& capture, const SeedsPipelineConfig& config);

/// The part of the world that is reconstructed, in the board's frame.
SweepVolume volume_of(const SeedsPipelineConfig& config, const SeedBoard& board);

PipelineNeeds needs(const SeedsPipelineConfig& config);
/// Whether the stage poses asks structure from motion.
bool needs_sfm(const SeedsPipelineConfig& config);
/// @throws std::invalid_argument naming the method, and the depth images or poses that it reads and
/// the capture lacks. Without colour the stages that read it find nothing.
void require_images(const Capture& capture, const SeedsPipelineConfig& config);
std::string_view to_string(SeedsMethod method);

// What its row of the table of pipelines goes by (pipeline_table.h).
struct PipelineRow;
const PipelineRow& row_of(const SeedsPipelineConfig& config);
bool needs_sfm(const Capture& capture, const SeedsPipelineConfig& config);
void check_capture(const Capture& capture, const SeedsPipelineConfig& config);
std::vector<std::string> unused_settings(const SeedsPipelineConfig& config);
Stages stages_for(const SeedsPipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch);

/// Runs the stages that there are, having checked that the capture has what the configuration
/// reads.
/// @throws as run_stages
Estimate run_seeds(const Capture& capture, const SeedsPipelineConfig& config, const Stages& stages,
                   const StageObserver& observer = {});

}  // namespace cousin
