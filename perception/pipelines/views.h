#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "perception/pipelines/seeds.h"
#include "perception/pipelines/small_photographs.h"
#include "perception/splats/splat_train_config.h"
#include "perception/splats/view_exposures.h"

namespace cousin {

/// `splats`: ours; `splats_paper`: the reference's schedule and density control, left early.
enum class ViewsMethod { splats, splats_paper };
/// Where poses come from: the capture's own, by COLMAP and our adjustment of its tracks, or `best`:
/// the capture's own where at least half of its frames, and two, have them.
enum class ViewsPoses { best, reported, sfm };

/// Gaussians of photographs of anything: no board, no specimens, no traits.
struct ViewsPipelineConfig {
  ViewsMethod method = ViewsMethod::splats;
  ViewsPoses poses = ViewsPoses::best;
  SfmConfig sfm;  ///< of poses by COLMAP; pairs, scale and folder are the pipeline's own choice
  /// Photographs are made smaller by a whole number until their longer side is at most this, after
  /// they were placed; 0: they stay.
  int largest_side_px = 1000;
  /// Every so many-th placed view, the first included, has no part in the training and scores it
  /// [Barron et al., CVPR 2022]; 0 or 1: all have. With poses by COLMAP it has its part in these
  /// and in where Gaussians begin, as is usual.
  int hold_out_every = 8;
  int steps = 3000;                            ///< `splats`
  int most_splats = 60000;                     ///< `splats`
  SplatGrowth growth = SplatGrowth::budgeted;  ///< `splats`
  int reference_steps = 7000;                  ///< `splats_paper`: of the reference's 30,000
  /// Folder of masks, named as frames are in a dataset ("000012.png", grey of at most 8 bits), of
  /// the photographs' size, full or made small: where one is 0, its photograph is neither trained
  /// on nor scored. A frame without a file counts whole; empty: all do.
  std::string masks;
  int sh_degree = 3;
  double low_pass_px2 = 0.1;  ///< `splats`, as in SplatModel
  /// `splats`: exposures and vignetting of the photographs trained on are measured on surfaces that
  /// are swept at a small size, and taken out (estimate_exposures). Where those of fewer than half
  /// of them can be measured, all stay as they are.
  bool one_exposure = true;
  /// `splats`: at most so many of these surfaces' points, opacity 0.5, are in the start too.
  /// Photographs are swept at 64 to 128 pixels, and at up to 512 until surfaces are found; where
  /// they are, random points begin at an opacity of 0.02 and centres a quarter as fast.
  int swept_points = 5000;
  /// File of points that Gaussians begin at (read_start_points), in the frame of the capture's own
  /// poses, as those of the model that these were imported from; empty: see start_points.
  std::string start;
  /// Where no tracks are, Gaussians begin at so many places drawn evenly over a cube of twice the
  /// cameras' median distance about the point that they look at.
  int start_points = 20000;
  bool normals = false;  ///< depth images have normals too
  /// Evenly spread, whose depths become the cloud; 0: there is no cloud. One is refused, before the
  /// training, where cameras are 2^21 of its voxels from the origin.
  int cloud_views = 24;
  double voxel_px = 2;      ///< of the cloud, in pixels at the median depth
  double agreement_px = 3;  ///< along the normal, likewise
  /// Along the longest side of what the cloud, or without one the depths, cover; 0: no mesh.
  int mesh_cells = 160;
};
Fields fields(ViewsPipelineConfig& config);
void validate(const ViewsPipelineConfig& config);
std::string_view to_string(ViewsMethod method);

/// Whether the stage poses asks structure from motion; of the capture its reported poses are read.
bool needs_sfm(const Capture& capture, const ViewsPipelineConfig& config);

/// Whether the `place`-th of the views that have poses has no part in the training.
bool is_held_out(const ViewsPipelineConfig& config, std::size_t place);

/// What the stages found beside their seams.
struct ViewsFindings {
  bool by_tracks = false;  ///< by COLMAP and our adjustment
  /// Lengths are the capture's own, or a board's; else they are in the unit of COLMAP's model,
  /// which says nothing.
  bool is_metric = true;
  std::string sfm_doubts;  ///< what structure from motion says of its model; empty where it is ok
  std::vector<StartPoint> tracks;
  /// Of the photographs that `splats` trained on, taken out of them where the status is ok. Of
  /// views whose gain is NaN only the vignetting was.
  ViewExposures exposures;
  std::vector<int>
      exposed_frames;  ///< places of theirs in the capture; none where status is not ok
};
/// An image of the model as the photograph's camera shows it: with the lens's vignetting and the
/// photograph's exposure. That of a photograph that was not trained on is taken from the nearest
/// ones before and after it in the capture that have one, as if the light had changed evenly.
ColorPlanes as_exposed(ColorPlanes image, const SplatView& photograph,
                       const ViewsFindings& findings);

StageOrder views_stage_order();

// What its row of the table of pipelines goes by (pipeline_table.h).
struct PipelineRow;
const PipelineRow& row_of(const ViewsPipelineConfig& config);
PipelineNeeds needs(const ViewsPipelineConfig& config);
Stages stages_for(const ViewsPipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch);

/// Stages of views_stage_order(), the others are none. They run on
/// `reduced(full, config.largest_side_px)`, whose cameras `poses` has. The unit is the capture's
/// own: metres where its poses or a board give them. `splats` is empty where training had nothing
/// to learn; `surfaces` is one closed mesh, `empty` where depths agree on none.
/// @param full  outlives the stages. `poses` throws std::runtime_error where fewer than two views
/// find a place, `splats` if training diverged or no photograph is left to train on.
/// @param findings  out, once the stages have run
/// @param masks     empty, or one for each frame, of the reduced photographs' size or empty: what
/// `config.masks` holds
Stages views_stages(const ViewsPipelineConfig& config, const Capture& full, std::uint64_t seed,
                    const SplatWatch& watch = {}, std::shared_ptr<ViewsFindings> findings = {},
                    std::vector<Image<std::uint8_t>> masks = {});

}  // namespace cousin
