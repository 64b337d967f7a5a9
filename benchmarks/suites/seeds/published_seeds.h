#pragma once

#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Tables 1 to 5 of the Seeds paper and its paired tests [Gao et al., Agriculture 15, 2329, 2025],
/// a row a number, as suite "seeds_splats" and methods "published: 3DGS", "published: SfM-MVS" and
/// "published: Instant-NGP". The paper does not say of which views its image quality is, nor after
/// how many steps traits were measured; scene "pooled" is what it says of none. n is the 50 grains
/// of a cultivar, and 1 where the paper says of how many a number is not.
std::vector<ScoreRow> published_seeds_rows();

}  // namespace cousin
