#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "calibration/board_detection.h"
#include "perception/mvs/plane_sweep.h"
#include "perception/segment/green.h"
#include "perception/sfm/sfm_poses.h"
#include "perception/splats/splat_start.h"
#include "perception/splats/splat_train_config.h"
#include "perception/splats/splat_views.h"
#include "sim/config/fields.h"

namespace cousin {

/// Where the views of a splat training come from: the board's corners, or COLMAP without a word
/// about the lens and one factor from the board's squares, as the Seeds paper has them.
enum class SplatPoses { board, sfm };

struct SeedsSplatConfig {
  SplatPoses poses = SplatPoses::board;
  int steps = 3000;            ///< of `splats`
  int most_splats = 40000;     ///< of `splats`
  int reference_steps = 7000;  ///< of `splats_paper`: the reference's schedule is left here
  /// Gaussians at the beginning. `splats`: points of the plane sweep's cloud, for photographs alone
  /// leave Gaussians of plain surfaces where they are; where it has less than half as many, and for
  /// `splats_paper`, they are drawn evenly over the volume that is reconstructed.
  int start_points = 20000;
  /// `splats`: the start is on the surface, and photographs fix depth on plain surfaces less well.
  /// Of 30 views of maize (seed 3), 1e-5 and 1e-6 left the cloud 0.58 and 0.47 mm off, and the
  /// board -0.07 and 0.00; 4e-3, the default of training, -0.2 with a tail to -1.6 (medians).
  double centre_rate = 1e-6;
  double least_opacity = 0.5;  ///< of a centre that becomes a point
  int margin_px = 8;           ///< kept around what a view shows of that volume
};
Fields fields(SeedsSplatConfig& config);
void validate(const SeedsSplatConfig& config);

/// Poses by COLMAP for the views of a training; frames that found no place have none.
/// @throws std::runtime_error if there is no metric model, saying why
Poses poses_by_sfm(const Capture& capture, const Corners& corners, const SeedBoard& board);

/// The photographs of a training: each is cut to what it shows of the volume, and green screen is
/// black, as the paper's background is. Views without a pose, or that show none of it, are left
/// out. @throws as splat_views
std::vector<SplatView> seed_views(const Capture& capture, const Poses& poses,
                                  const SweepVolume& volume, const GreenConfig& green,
                                  int margin_px);

/// At most `most` points of a cloud, evenly spread over its order.
std::vector<StartPoint> start_of_cloud(const Cloud& cloud, int most);

/// Adds points drawn evenly over the volume, up to `count`, where there are less than half as many.
void fill_start(const SweepVolume& volume, int count, Rng rng, std::vector<StartPoint>& start);

/// Gaussians that the views show. Empty where there is nothing to begin from, or the views show
/// nothing that could be learned. @throws std::runtime_error if training diverged
SplatModel train_on_seeds(std::span<const SplatView> views, std::span<const StartPoint> from,
                          const SplatTrainConfig& training, int stop_after);

/// Depth of a model on the pixels of the photographs themselves, lens and all: along the axis, NaN
/// where a ray is never half blocked or ends outside the volume. Views without a pose have none.
Depths depths_of_splats(const SplatModel& model, const Poses& poses, const SweepVolume& volume);

}  // namespace cousin
