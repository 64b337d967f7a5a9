#pragma once

#include <vector>

#include "benchmarks/learned/learned_distance.h"
#include "benchmarks/seeds/score_seeds.h"
#include "perception/pipelines/seeds.h"

namespace cousin {

/// How the photographs that Gaussians were trained on look beside theirs, means over the views:
/// PSNR, SSIM and FLIP of the part that shows what was reconstructed, green screen black in
/// both; PSNR over what is not green; and PSNR over the whole photograph, as the Seeds paper has
/// it, whose rest is black in both. With them the number of Gaussians and the seconds of training.
/// Empty if the estimate holds no Gaussians. @param learned  a network's distance too
std::vector<ScoreRow> splat_image_rows(const Capture& capture, const SeedsEstimate& estimate,
                                       const SeedsPipelineConfig& config,
                                       const SeedsScoreLabels& labels,
                                       const LearnedDistance* learned = nullptr);

}  // namespace cousin
