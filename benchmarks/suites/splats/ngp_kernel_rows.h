#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// What a sample of a ray costs the radiance field of default size: core time of both networks,
/// forward and backward, for each instruction set there is, and of its corners in the hash grid,
/// read and written. Beside it the rows "seconds.cpu a sample" of whole trainings (`field_rows`):
/// what is more there is marching, compositing, Adam and looks for matter.
/// @param samples  a multiple of 256
std::vector<ScoreRow> ngp_kernel_rows(std::uint64_t seed, int samples = 65536);

}  // namespace cousin
