#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "calibration/boards/board_detection.h"
#include "perception/sfm/colmap_run.h"
#include "perception/sfm/track_bundle.h"
#include "sim/types/capture.h"

namespace cousin {

/// Where metres come from. `adjusted`: the board's corners are known points of the adjustment;
/// `squares`: one factor, the side of a square over its side in the finished model, as the Seeds
/// paper does; `none`: the model's own unit.
enum class SfmScale { adjusted, squares, none };
std::string_view to_string(SfmScale scale);

struct SfmConfig {
  PairConfig pairs;
  ColmapConfig colmap;
  BoardDetectionConfig board;
  SfmScale scale = SfmScale::adjusted;
  bool refine = true;  ///< our own adjustment; else COLMAP's poses and lens stay (not `adjusted`)
  SfmFocal focal = SfmFocal::shared;
  double focal_jitter = 3e-4;     ///< relative deviation of one image's focal length about all's
  double board_sigma_m = 2e-5;    ///< of each coordinate of a corner of the print
  double corner_floor_px = 0.05;  ///< added in quadrature to each corner's predicted deviation
  int min_board_corners = 8;      ///< fewer: there is no scale; in one image: no place by them
  /// `adjusted` only: images that COLMAP lost but that show the board enter the adjustment by it.
  bool place_by_board = true;
  /// Images whose adjusted turn differs by more from what their own corners say are taken out of
  /// the model, and count as lost. Needs `refine`; with pi none is.
  double max_board_turn_rad = 0.2;
  /// `loss_px` is in pixels of a track: matches of SIFT have long tails. Of 48 views of 1756 points
  /// by COLMAP with exact poses known, 0.5 px left centres 0.13 % of the distance off, 2 px 0.18 %,
  /// COLMAP itself 0.27 %. Priors about the lens given are as those of BoardPosesConfig. A lens
  /// that is left open where no track is does poses no harm: their deviations know, so more of it
  /// is let pass than where the lens is what is sought.
  BundleAdjustmentConfig adjust = {.loss = RobustLoss::cauchy,
                                   .loss_px = 0.5,
                                   .focal_prior_share = 0.005,
                                   .centre_prior_px = 6,
                                   .distortion_prior = 0.02,
                                   .max_iterations = 300,
                                   .tolerance = 1e-9,
                                   .max_deviation_share = 0.02};
};
Fields fields(SfmConfig& config);
/// What a pipeline's user may change: those that hold for photographs of anything. Which program
/// runs and where is not among them, as configurations come with datasets from elsewhere.
Fields fields_of_pipelines(SfmConfig& config);
/// @throws std::invalid_argument also for `adjusted` without `refine`
void validate(const SfmConfig& config);

/// The Seeds paper's way: nothing is given of the lens, COLMAP calibrates it, one factor scales.
SfmConfig paper_sfm_config();

/// `partly_registered`: some images found no place, the rest have poses. `no_scale`: poses are
/// good up to a similarity, the board was not seen well enough. `not_determined`: the images do not
/// fix the lens, whose parameters `reason` names, or COLMAP's own calibration of it is no lens.
/// `contradicted`: the board, as the images show it one by one, does not stand still in the model.
/// `not_built`: no COLMAP, or Ceres is not built in.
enum class SfmStatus {
  ok,
  partly_registered,
  no_scale,
  contradicted,
  not_determined,
  not_converged,
  too_few_images,
  no_model,
  program_failed,
  timed_out,
  not_built
};
std::string_view to_string(SfmStatus status);
/// What the end of COLMAP's run alone says.
SfmStatus sfm_status_of(ColmapStatus status);
/// Whether there are poses.
inline bool has_poses(SfmStatus status) {
  return status == SfmStatus::ok || status == SfmStatus::partly_registered ||
         status == SfmStatus::no_scale;
}

struct SfmEstimate {
  SfmStatus status = SfmStatus::not_built;
  std::string reason;  ///< unless ok: what and why
  /// One for each frame of the capture. Status ok where there is a place. The world is the board's
  /// frame in metres, or where `gauge` is a similarity the model's own.
  Poses poses;
  std::vector<int> lost;          ///< ids of frames without a place
  std::vector<int> contradicted;  ///< ids of frames whose place in the model the board denied
  std::vector<int> by_board;      ///< ids of frames that only the board placed
  Camera lens;                    ///< of all images; with SfmFocal::per_image their mean
  std::vector<SfmPoint> points;   ///< images as indices into the capture's frames
  BundleGauge gauge = BundleGauge::similarity;
  double metres_per_unit = kNaN;  ///< of the model as COLMAP left it
  /// Deviation of that over itself: of the fit to the board, and of the focal length before the
  /// board was adjusted with the rest.
  double scale_sigma_share = kNaN;
  double feature_sigma_px = kNaN;  ///< of a track's sighting, a coordinate, as the fit left it
  std::vector<std::string> not_determined;   ///< parameters of the lens
  std::vector<std::string> lens_parameters;  ///< those refined: "fx_px"
  Eigen::MatrixXd lens_covariance;           ///< of these
  std::vector<int> model_sizes;              ///< images in each of COLMAP's models, descending
  std::vector<ImageMatches> images;          ///< features and matches of each frame; may be empty
  std::string colmap_version;
  std::vector<StageTiming> timings;
  StageTiming done_before;  ///< of `timings`: steps of COLMAP found done in its folder, together
};

/// The first lens with the mean of all focal lengths. @throws std::out_of_range if there is none
Camera mean_lens(const std::vector<Camera>& lenses);

/// @throws NotBuilt where the program has no structure from motion
void require_sfm();

/// Poses of a capture's colour images without known ones: COLMAP on pairs chosen by their order,
/// then our adjustment of poses, lens and points over its tracks, and the scale from the board that
/// `capture.board` names ("markers" or "plain"; without one there is none). Reads colour images and
/// the first sensor's reported lens, whose numbers the adjustment starts from.
/// @throws as run_colmap and detect_board
SfmEstimate estimate_poses_sfm(const Capture& capture, const SfmConfig& config = {});

/// The same for corners that were found before. @throws std::invalid_argument also if they are not
/// one entry for each frame
SfmEstimate estimate_poses_sfm(const Capture& capture, const Corners& corners,
                               const SeedBoard& board, const SfmConfig& config = {});

/// What follows COLMAP alone.
/// @param frames   ids of the frames that the model's images count through
/// @param corners  one entry for each of them, or empty: there is no scale
/// @param lens     what the device reports; none: the model's lens is the start
/// Images of the model with fewer than four sightings of points that another one shows are lost.
SfmEstimate refine_sfm(const SfmModel& model, const std::vector<int>& frames,
                       const std::optional<Camera>& lens, const Corners& corners,
                       const SeedBoard& board, const SfmConfig& config = {});

}  // namespace cousin
