#pragma once

#include "perception/pipelines/seeds.h"
#include "sim/types/capture.h"

namespace cousin {

/// Where nobody says the lens, the board tells it: the focal length that is assumed may be a
/// quarter off, and a phone's autofocus changes it from image to image.
void trust_the_board(SeedsPipelineConfig& config);

/// The lens that a board tells.
struct BoardLens {
  double focal_px = 0;  ///< median over the views that are posed; 0 = no view is
  int views = 0;        ///< posed, of those that were looked at
};

/// Replaces the reported lens of every frame by the one with which the board's corners in at most
/// 24 of the views agree best: PnP and one bundle adjustment, twice, as the first starts from a
/// focal length that may be far off. Nothing changes where no view shows the board.
BoardLens take_lens_of_board(const SeedsPipelineConfig& config, Capture& capture);

}  // namespace cousin
