#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/score/image_fidelity.h"
#include "benchmarks/score/learned/learned_distance.h"
#include "perception/pipelines/seeds.h"

namespace cousin {

/// A photograph of the capture, or the part of it that shows what was reconstructed, green screen
/// black: what a model's image is held beside.
struct ScoredPhotograph {
  SplatView view;         ///< its first level
  bool held_out = false;  ///< it had no part in the training
  /// All of the photograph, where `view` is a part of it: a model may draw beyond what it was
  /// trained on, and is charged for it.
  std::optional<SplatView> whole;
};

/// Evenly spread over the views that were trained on and over those held out: at most so many of
/// each. @param margin_px  kept around the volume that is reconstructed
std::vector<ScoredPhotograph> scored_photographs(const Capture& capture, const Poses& poses,
                                                 const SeedsPipelineConfig& config, int margin_px,
                                                 std::size_t most_views);

/// Beside Instant-NGP, photographs are a third as wide and high.
inline constexpr int kSmallPhotograph = 3;
/// Pixels averaged in squares of that side, what is over left out; a pixel counts as far as all of
/// its own do.
ScoredPhotograph made_small(const ScoredPhotograph& photograph);

using SeedsImageRenderer = std::function<FidelityPlanes(const Camera&, const Pose&)>;

/// How a model's images look beside photographs, means over them, "train." and, if there are any,
/// "held_out.", of pixels whose weight is whole: `psnr`, `ssim` and `flip` of the part;
/// `psnr_object`, `ssim_object` and `flip_object` over what is not green, the same pixels whatever
/// part a method trains on; `psnr_whole`, `ssim_whole` and `flip_whole` over the whole photograph,
/// drawn whole, as the Seeds paper has them: these, unlike those of a part, compare models trained
/// on parts of different size;
/// `psnr_whole_small`, the same for pixels averaged to a third
/// of the size; and with a network `lpips` and `lpips_whole`. A score that is not a number, of an
/// image that has none, makes its mean NaN. @param base  labels, seconds and memory of the training
std::vector<ScoreRow> photograph_rows(const std::vector<ScoredPhotograph>& photographs,
                                      const SeedsImageRenderer& render, const ScoreRow& base,
                                      const LearnedDistance* learned);

/// The rows of an estimate's Gaussians and their number, of the photographs or their parts that its
/// method trains on; each has the seconds of the stage "splats". Empty if it holds none.
std::vector<ScoreRow> splat_image_rows(const Capture& capture, const Estimate& estimate,
                                       const SeedsPipelineConfig& config,
                                       const SeedsScoreLabels& labels,
                                       const LearnedDistance* learned, std::size_t most_views);

}  // namespace cousin
