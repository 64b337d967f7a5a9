#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/boards/board_detection.h"
#include "perception/mvs/plane_sweep.h"
#include "perception/segment/green.h"
#include "perception/sfm/sfm_poses.h"
#include "perception/splats/splat_start.h"
#include "perception/splats/splat_train_config.h"
#include "perception/splats/splat_views.h"
#include "perception/splats/train_splats.h"
#include "sim/config/fields.h"

namespace cousin {

/// Where the views of a splat training come from: the board's corners; COLMAP without a word about
/// the lens and one factor from the board's squares, as the Seeds paper has them; or our adjustment
/// of its tracks with the lens that the device reports and the board's corners.
enum class SplatPoses { board, sfm, adjusted };
std::string_view to_string(SplatPoses poses);

struct SeedsSplatConfig {
  SplatPoses poses = SplatPoses::board;
  int steps = 1200;            ///< of `splats`
  int most_splats = 60000;     ///< of `splats`
  int reference_steps = 7000;  ///< of `splats_paper`: the reference's schedule is left here
  /// `splats_paper` starts from the points that structure from motion left, as the reference does:
  /// COLMAP's with poses from it, else so many of the plane sweep's; where there are none, of the
  /// volume.
  int reference_points = 10000;
  /// Gaussians of `splats` at the beginning, see start_on_surfaces. Where that has less than half
  /// of them, the others are drawn evenly over the volume that is reconstructed.
  int start_points = 40000;
  /// `splats`: the start is on the surface, and photographs fix depth on plain surfaces less well.
  /// With 4e-3, the default of training, the board of 30 views of maize (seed 3) sank by 0.2 mm in
  /// the median with a tail to 1.6; with 1e-6 it stays.
  double centre_rate = 1e-6;
  double flatness = 0.03;       ///< `splats`: thickness over width at the start, across the normal
  double shape_rate = 0.05;     ///< `splats`: rates of scales and rotations, of training's own
  double opacity_rate = 0.05;   ///< `splats`: likewise of opacities
  double start_opacity = 0.95;  ///< `splats`
  /// `splats`: as in SplatModel, of training, depths and images. With 0.3, that of
  /// the reference, discs of a grain 15 to 40 pixels wide reach over its edge and where it curves:
  /// drawn so, depths stand 0.1 mm out; trained so, discs sink by 0.05 mm to make up for it.
  double low_pass_px2 = 0.03;
  double raised_share = 0.5;  ///< `splats`: of the points at the start, those on grains
  /// `splats_paper`: of a centre that becomes a point. Half of the reference's Gaussians are more
  /// transparent than 0.2, on grains too: of maize (seed 1, 60 views of 1280 x 720, 5,000 steps)
  /// the RMSE of length is 1.2, 1.3 and 1.6 mm with 0.05, 0.1 and 0.3; with 0.5 two grains are
  /// lost.
  double least_opacity = 0.05;
  int margin_px = 8;  ///< `splats`: kept around what a view shows of that volume
  /// `splats_paper`: the same. Whole photographs, as in the paper: where they are cut, the loss is
  /// a mean over fewer pixels, and more Gaussians grow (204,000 of 60 views of maize, seed 1, in
  /// place of 112,000).
  int reference_margin_px = 10000;
  /// Every so many-th view has no part in the training, so that it can score the model; 0 or 1:
  /// all have. Poses come from all views, with those of COLMAP the points of the start too, and
  /// what is measured afterwards reads all.
  int hold_out_every = 0;
  /// Of all photographs of a training together; 12 to 20 bytes each are kept.
  double most_pixels = SplatViewsConfig{}.most_pixels;
};
Fields fields(SeedsSplatConfig& config);
void validate(const SeedsSplatConfig& config);

/// Whether a frame of the capture has no part in the training.
bool is_held_out(const SeedsSplatConfig& config, int frame);
/// The poses that a training sees: those of frames that are held out are none.
Poses training_poses(const SeedsSplatConfig& config, Poses poses);

/// Called now and then by a stage that takes minutes.
using StepProgress = std::function<void(int done, int steps)>;

/// Who watches a training of Gaussians. Nobody changes a byte of it.
struct SplatWatch {
  StepProgress progress;
  SplatSnapshots snapshots;
  SplatCheckpoint checkpoint;  ///< none: a training that is stopped begins anew
  /// Told how it ended, before the model is taken out.
  std::function<void(const SplatTraining& training)> end;
  /// Where COLMAP keeps what it did, so that whoever goes on there has the same poses (its models
  /// vary from run to run); empty: nowhere.
  std::filesystem::path sfm_folder;
  /// Told what structure from motion found, also where that is no poses.
  std::function<void(const SfmEstimate& estimate)> posed;
  /// Told why a training was left before its end, whose model is taken all the same. Without it
  /// there is none then.
  std::function<void(const std::string& why)> left_early;
};

/// Structure from motion found no poses in metres.
class NoPosesError : public std::runtime_error {
 public:
  NoPosesError(SfmStatus why, const std::string& what) : std::runtime_error(what), status(why) {}
  SfmStatus status;  ///< `no_scale`: there is a model, and no size
};

/// Poses by structure from motion for the views of a training; frames without a place have none.
/// @param config  the paper's or ours, see SplatPoses
/// @param points  out: of its model, in the world, those in the volume
/// @param posed   told what was found, if given
/// @throws NoPosesError if there is no metric model, saying why
Poses poses_by_sfm(const Capture& capture, const Corners& corners, const SeedBoard& board,
                   const SweepVolume& volume, const SfmConfig& config,
                   std::vector<StartPoint>& points,
                   const std::function<void(const SfmEstimate&)>& posed = {});

/// The photographs of a training: each is cut to what it shows of the volume, and green screen is
/// behind the scene, where it is more than specks. Views without a pose, or that show none of it,
/// are left out.
/// @throws as splat_views
std::vector<SplatView> seed_views(const Capture& capture, const Poses& poses,
                                  const SweepVolume& volume, const GreenConfig& green,
                                  int margin_px,
                                  double most_pixels = SplatViewsConfig{}.most_pixels);

/// Where Gaussians begin, at most `start_points` of them: `raised_share` on closed surfaces, drawn
/// evenly over their area with their normals; the others on the cloud, where it shows the board,
/// whose face is known (z = 0), or grains without a closed surface, evenly spread over its order. A
/// surface's colour is the mean of its cluster's. @param cloud  what `clusters` were made of
std::vector<StartPoint> start_on_surfaces(const Clusters& clusters, const Cloud& cloud,
                                          const Surfaces& surfaces, const SeedsSplatConfig& config,
                                          const Rng& rng);

/// Adds points drawn evenly over the volume, up to `count`, where there are less than half as many.
void fill_start(const SweepVolume& volume, int count, Rng rng, std::vector<StartPoint>& start);

/// Gaussians that the views show. Empty where there is nothing to begin from, or the views show
/// nothing that could be learned. @throws std::runtime_error if training diverged
SplatModel train_on_views(std::span<const SplatView> views, std::span<const StartPoint> from,
                          const SplatStartConfig& start, const SplatTrainConfig& training,
                          int stop_after, const SplatWatch& watch = {});

/// The model without the Gaussians that have left the volume by more than a fifth of its longest
/// side: what parts of photographs show of the volume does not hold them, and in whole ones they
/// would hang in the air. Nearer ones stay: corners of the parts show the board out there.
/// Where none is left `why_none` says so.
SplatModel without_strays(SplatModel model, const SweepVolume& volume);

/// Depth of a model on the pixels of the photographs themselves, lens and all: along the axis, NaN
/// where a ray is never half blocked or ends outside the volume. Views without a pose have none.
/// @param low_pass_px2  as in SplatRenderConfig
/// @param with_normals  normals too, of pixels whose four neighbours show the same surface, by the
/// lines between these
Depths depths_of_splats(const SplatModel& model, const Poses& poses, const SweepVolume& volume,
                        double low_pass_px2, bool with_normals = false);

}  // namespace cousin
