#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "calibration/board_detection.h"
#include "perception/mvs/plane_sweep.h"
#include "perception/segment/green.h"
#include "perception/sfm/sfm_poses.h"
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
  int start_points = 20000;    ///< drawn evenly over the volume that is reconstructed
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

/// Gaussians of what lies in the volume. Empty where the views show nothing that could be learned.
/// @throws std::runtime_error if training diverged
SplatModel train_on_seeds(std::span<const SplatView> views, const SweepVolume& volume,
                          const SplatTrainConfig& training, int stop_after, int start_points,
                          std::uint64_t seed);

/// Depth of a model on the pixels of the photographs themselves, lens and all: along the axis, NaN
/// where a ray is never half blocked or ends outside the volume. Views without a pose have none.
Depths depths_of_splats(const SplatModel& model, const Poses& poses, const SweepVolume& volume);

}  // namespace cousin
