#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "calibration/board_detection.h"
#include "calibration/board_poses.h"
#include "perception/cloud/clusters.h"
#include "perception/cloud/fuse.h"
#include "perception/cloud/measure_traits.h"
#include "perception/mvs/plane_sweep.h"
#include "perception/pipelines/seeds_splats.h"
#include "perception/segment/green.h"
#include "perception/silhouette/outlines.h"
#include "perception/silhouette/surface_fit.h"
#include "perception/splats/splat_model.h"
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

/// Everything between capture and traits, in the order it is made.
struct SeedsEstimate {
  Corners corners;
  Poses poses;
  SplatModel splats;
  Depths depths;
  Cloud cloud;
  Clusters clusters;
  Silhouettes silhouettes;
  Surfaces surfaces;
  Traits traits;
  std::vector<StageTiming> timings;
};

/// The seams, in order. Each takes the capture and all earlier results; a stage may be replaced by
/// files, a program or truth.
struct SeedsStages {
  std::function<Corners(const Capture&, const SeedsEstimate&)> corners;
  std::function<Poses(const Capture&, const SeedsEstimate&)> poses;
  std::function<SplatModel(const Capture&, const SeedsEstimate&)> splats;
  std::function<Depths(const Capture&, const SeedsEstimate&)> depth;
  std::function<Cloud(const Capture&, const SeedsEstimate&)> cloud;
  std::function<Clusters(const Capture&, const SeedsEstimate&)> clusters;
  std::function<Silhouettes(const Capture&, const SeedsEstimate&)> masks;
  std::function<Surfaces(const Capture&, const SeedsEstimate&)> surfaces;
  std::function<Traits(const Capture&, const SeedsEstimate&)> traits;
};

/// @param watch  of the training of Gaussians
/// @throws std::invalid_argument if a config is not valid.
SeedsStages seeds_stages(const SeedsPipelineConfig& config, std::uint64_t seed,
                         const SplatWatch& watch = {});

/// The board a configuration and a capture agree on; without a word from either, the one with
/// markers.
SeedBoard board_of(const Capture& capture, const SeedsPipelineConfig& config);

/// The part of the world that is reconstructed, in the board's frame.
SweepVolume volume_of(const SeedsPipelineConfig& config, const SeedBoard& board);

/// A stage failed: ours, a user's program, or a file that does not fit. Nested: the cause.
class StageError : public std::runtime_error {
 public:
  StageError(const std::string& stage_name, const std::string& what);
  std::string stage;
};

/// Which of a capture's images and which stages a configuration reads; what is not listed is left
/// out.
struct PipelineNeeds {
  std::vector<std::string> images;  ///< of "color", "raw", "infrared", "depth"
  std::vector<std::string> stages;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< stage, why
};
PipelineNeeds needs(const SeedsPipelineConfig& config);
/// Whether the stage poses asks structure from motion.
bool needs_sfm(const SeedsPipelineConfig& config);
/// @throws std::invalid_argument naming the method, and the depth images or poses that it reads and
/// the capture lacks. Without colour the stages that read it find nothing.
void require_images(const Capture& capture, const SeedsPipelineConfig& config);
std::string_view to_string(SeedsMethod method);

/// Called before and after each stage, for progress and for writing seams as soon as they exist.
using StageObserver =
    std::function<void(const std::string& stage, bool finished, const SeedsEstimate&)>;

/// Runs the stages that there are, in order. @throws StageError; std::invalid_argument without
/// frames
SeedsEstimate run_stages(const Capture& capture, const SeedsStages& stages,
                         const StageObserver& observer = {});
/// The same, having checked that the capture has what the configuration reads.
SeedsEstimate run_seeds(const Capture& capture, const SeedsPipelineConfig& config,
                        const SeedsStages& stages, const StageObserver& observer = {});

}  // namespace cousin
