#pragma once

#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// The Seedlings paper's methods as tables call them.
inline constexpr const char* kPublishedGaussians = "published: 3DGS";
inline constexpr const char* kPublishedNgp = "published: Instant-NGP";

/// Tables 2 to 4 of the Seedlings paper (shared/papers/README.md), a row a number: PSNR of samples
/// S1 to S12 under three lights, minutes on an RTX 4090. The paper does not say of which views its
/// PSNR is; the metric is "psnr" alone.
std::vector<ScoreRow> published_rows();

}  // namespace cousin
